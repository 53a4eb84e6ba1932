//! `cargo xtask coverage`: whether the stated uncertainties are honest.

use std::sync::atomic::{AtomicU64, Ordering};

use host_tests::coverage::{Coverage, coverage};

/// `cargo xtask coverage`
#[derive(Debug, clap::Args)]
pub struct Arguments {
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

/// Shares that a coefficient's 95 % interval must reach and not exceed over a thousand campaigns.
const HONEST: std::ops::RangeInclusive<f64> = 0.93..=0.97;

/// Simulates the campaigns and prints their figures; fails when a thousand of them find an interval dishonest.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let done = AtomicU64::new(0);
    let figures = coverage(arguments.campaigns, arguments.seed, || {
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        if count.is_multiple_of(20) {
            eprintln!("{count} of {} campaigns", arguments.campaigns);
        }
    });
    if arguments.json {
        println!("{}", serde_json::to_string(&figures)?);
    } else {
        print_table(&figures);
    }
    let outside = figures
        .coefficients
        .iter()
        .filter(|coefficient| !HONEST.contains(&coefficient.coverage));
    let outside: Vec<&str> = outside
        .map(|coefficient| coefficient.name.as_str())
        .collect();
    anyhow::ensure!(
        arguments.campaigns < 1000 || outside.is_empty(),
        "coverage outside 93 to 97 %: {}",
        outside.join(", ")
    );
    Ok(())
}

fn print_table(figures: &Coverage) {
    println!("{} campaigns", figures.campaigns);
    println!("coefficient  inside 95 %  median |error|/U  worst error");
    for coefficient in &figures.coefficients {
        let worst = if coefficient.name.ends_with("gain") {
            format!("{:.3} %", 100.0 * coefficient.worst_error)
        } else {
            format!("{:.1} counts", coefficient.worst_error)
        };
        let (inside, median) = (
            100.0 * coefficient.coverage,
            coefficient.median_error_over_u,
        );
        println!(
            "{:<11} {inside:>11.1} % {median:>16.3}  {worst}",
            coefficient.name
        );
    }
}
