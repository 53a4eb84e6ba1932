//! `cargo xtask bench kinematics`: how long kinematics takes.

use anyhow::ensure;
use clap::Parser;
use host_tests::scipy::{Python, Scipy};
use host_tests::speed::{Figures, Forward, cases, measure};
use serde_json::{Value, json};

/// Time of forward kinematics from home and from the pose before, of inverse kinematics, and of a recorded run
#[derive(Parser)]
#[command(bin_name = "cargo xtask bench kinematics")]
struct Arguments {
    /// Print one JSON document on standard output, and nothing else there
    #[arg(long)]
    json: bool,
    /// Time scipy on the same poses too, and print how many times longer it takes; needs python3, and its network for
    /// numpy and scipy the first time
    #[arg(long)]
    beside_scipy: bool,
}

/// Measures and prints; fails when a pose was not found.
fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let python = arguments.beside_scipy.then(Python::find).transpose()?;
    let figures = measure();
    let scipy = match python {
        Some(python) => Some(python.measure(&serde_json::to_string(&cases())?)?),
        None => None,
    };
    if arguments.json {
        println!("{}", document(&figures, scipy.as_ref())?);
    } else {
        print_table(&figures);
        if let Some(scipy) = &scipy {
            print_scipy(scipy, figures.cold.ns);
        }
    }
    let failed = figures.cold.failed + figures.warm.failed;
    ensure!(failed == 0, "{failed} poses were not found");
    Ok(())
}

fn document(figures: &Figures, scipy: Option<&Scipy>) -> anyhow::Result<Value> {
    let mut document = serde_json::to_value(figures)?;
    if let Some(scipy) = scipy {
        document["scipy"] = json!({
            "root_ns": scipy.root_ns,
            "root_residual_m": scipy.root_residual_m,
            "root_ratio_cold": scipy.root_ns / figures.cold.ns,
            "least_squares_ns": scipy.least_squares_ns,
            "least_squares_residual_m": scipy.least_squares_residual_m,
            "least_squares_ratio_cold": scipy.least_squares_ns / figures.cold.ns,
        });
    }
    Ok(document)
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

fn print_scipy(scipy: &Scipy, cold_ns: f64) {
    for (name, ns) in [
        ("scipy root, from home", scipy.root_ns),
        ("scipy least_squares", scipy.least_squares_ns),
    ] {
        println!("{name:<30} {ns:>6.0} ns, {:.0} times as long", ns / cold_ns);
    }
}
