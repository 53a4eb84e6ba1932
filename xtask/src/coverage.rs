//! `cargo xtask coverage`: whether the stated uncertainties are honest, in a release build.

use anyhow::Context;
use host_tests::coverage::Coverage;

use crate::build::cargo;
use crate::process::output;

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
    let program = ["--package", "host-tests", "--bin", "coverage", "--"];
    let numbers = [arguments.campaigns, arguments.seed].map(|number| number.to_string());
    let mut command = cargo("run");
    command.args(["--quiet", "--release"]).args(program);
    let text = output(command.args(numbers))?;
    let figures: Coverage = serde_json::from_str(&text).context("the figures cannot be read")?;
    if arguments.json {
        print!("{text}");
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
