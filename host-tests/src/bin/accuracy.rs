//! `cargo xtask accuracy`: how exact the harmonic estimator is on noise-free counts, over its whole range.

use anyhow::ensure;
use clap::Parser;
use host_tests::accuracy::{Errors, cases, measure};

/// Measure how exact the harmonic estimator is, from 0.01 to 50 Hz, at every rate, over one period to a hundred
#[derive(Parser)]
#[command(bin_name = "cargo xtask accuracy")]
struct Arguments {
    /// Leave out windows of more scans; a hundred periods at 0.01 Hz and 4 kHz are forty million
    #[arg(long, value_name = "SCANS", default_value_t = 50_000_000)]
    most: u32,
    /// Print one JSON document on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

/// Largest error of the first harmonic against least squares in double precision on the same counts, over the amplitude.
const MAX_ERROR: f64 = 5e-7;

/// Measures and prints; fails when an error is too large.
fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let errors = measure(&cases(arguments.most.into()));
    if arguments.json {
        println!("{}", serde_json::to_string(&errors)?);
    } else {
        print_table(&errors);
    }
    let large = errors.iter().find(|errors| errors.of_blocks > MAX_ERROR);
    ensure!(
        large.is_none(),
        "an error is larger than {MAX_ERROR:e}: {large:?}"
    );
    Ok(())
}

fn print_table(errors: &[Errors]) {
    println!(
        "rate, Hz  drive, Hz  periods  offset  block     scans  arithmetic    blocks    counts"
    );
    for errors in errors {
        let case = &errors.case;
        println!(
            "{:>8} {:>10} {:>8} {:>7} {:>6} {:>9} {:>11.1e} {:>9.1e} {:>9.1e}",
            case.rate_hz,
            case.frequency_hz,
            case.periods,
            case.offset,
            errors.block,
            errors.scans,
            errors.of_arithmetic,
            errors.of_blocks,
            errors.of_counts,
        );
    }
    let worst = |of: fn(&Errors) -> f64| errors.iter().map(of).fold(0.0, f64::max);
    println!(
        "{} cases of sixteen phases; worst: arithmetic {:.1e}, blocks {:.1e}, rounding to counts {:.1e}",
        errors.len(),
        worst(|errors| errors.of_arithmetic),
        worst(|errors| errors.of_blocks),
        worst(|errors| errors.of_counts),
    );
}
