//! `cargo xtask bench kinematics`: how long kinematics takes, in a release build.

use anyhow::Context;
use host_tests::speed::{Figures, Forward};

use crate::build::cargo;
use crate::process::output;

/// `cargo xtask bench kinematics`
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Print one JSON document on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

/// Builds the measuring program with optimisation, runs it and prints its figures; fails when a pose was not found.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let program = ["--package", "host-tests", "--bin", "speed"];
    let text = output(cargo("run").args(["--quiet", "--release"]).args(program))?;
    let figures: Figures = serde_json::from_str(&text).context("the figures cannot be read")?;
    if arguments.json {
        print!("{text}");
    } else {
        print_table(&figures);
    }
    let failed = figures.cold.failed + figures.warm.failed;
    anyhow::ensure!(failed == 0, "{failed} poses were not found");
    Ok(())
}

fn print_table(figures: &Figures) {
    print_forward("forward, from home", &figures.cold);
    print_forward("forward, from the pose before", &figures.warm);
    println!("{:<30} {:>6.0} ns", "inverse", figures.inverse.ns);
    println!(
        "{:<30} {:>6.2} million solves/s on {} threads",
        "recorded run",
        figures.batch.solves_per_second / 1e6,
        figures.batch.threads
    );
}

fn print_forward(name: &str, figures: &Forward) {
    println!(
        "{name:<30} {:>6.0} ns, {:.2} iterations, at most {}, {} not found",
        figures.ns, figures.iterations_mean, figures.iterations_max, figures.failed
    );
}
