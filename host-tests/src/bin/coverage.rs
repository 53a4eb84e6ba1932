//! `cargo xtask coverage`: whether the stated uncertainties are honest, and how often the checks refuse a good campaign.

use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::ensure;
use clap::Parser;
use host_tests::coverage::{Coverage, coverage};

/// Simulate many campaigns and count how often the truth lies inside the stated uncertainties, and how often a check
/// refuses a good campaign
#[derive(Parser)]
#[command(bin_name = "cargo xtask coverage")]
struct Arguments {
    /// Campaigns to simulate, each with a twin of its own seed, the five motion bases in turn
    #[arg(long, default_value_t = 1000)]
    campaigns: u64,
    /// Seed of the first campaign; the others follow
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print one JSON document on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

/// Largest share of good campaigns that the checks may refuse.
const REFUSED: f64 = 0.01;
/// Shares that a coefficient's 95 % interval must reach and not exceed over a thousand campaigns.
const HONEST: RangeInclusive<f64> = 0.93..=0.97;

/// Simulates the campaigns and prints their figures; fails when a thousand of them find an interval dishonest.
fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let figures = simulate(arguments.campaigns, arguments.seed);
    if arguments.json {
        println!("{}", serde_json::to_string(&figures)?);
    } else {
        print_table(&figures);
    }
    let outside: Vec<&str> = figures
        .coefficients
        .iter()
        .filter(|coefficient| !HONEST.contains(&coefficient.coverage))
        .map(|coefficient| coefficient.name.as_str())
        .collect();
    ensure!(
        arguments.campaigns < 1000 || outside.is_empty(),
        "coverage outside 93 to 97 %: {}",
        outside.join(", ")
    );
    let refused = figures.refused as f64 / arguments.campaigns.max(1) as f64;
    ensure!(
        arguments.campaigns < 1000 || refused <= REFUSED,
        "the checks refuse {:.1} % of the good campaigns, limit {:.0} %: {:?}",
        100.0 * refused,
        100.0 * REFUSED,
        figures.failed_checks
    );
    Ok(())
}

fn simulate(campaigns: u64, first_seed: u64) -> Coverage {
    let done = AtomicU64::new(0);
    coverage(campaigns, first_seed, || {
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        if count.is_multiple_of(50) {
            eprintln!("{count} of {campaigns} campaigns");
        }
    })
}

fn print_table(figures: &Coverage) {
    println!(
        "{} campaigns, of which the checks refuse {}",
        figures.campaigns, figures.refused
    );
    println!("coefficient    inside 95 %  median |error|/U  largest");
    for coefficient in &figures.coefficients {
        println!(
            "{:<13} {:>11.1} % {:>16.3} {:>8.2}",
            coefficient.name,
            100.0 * coefficient.coverage,
            coefficient.median_error_over_u,
            coefficient.worst_error_over_u,
        );
    }
}
