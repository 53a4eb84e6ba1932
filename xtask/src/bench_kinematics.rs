//! `cargo xtask bench kinematics`: how long kinematics takes, in a release build.
//!
//! With `--beside-scipy` the same poses are solved by scipy in the same run, by the script `scipy_kinematics.py`; a
//! ratio of two times on one machine says more than either. Python's packages go into a virtual environment under the
//! target folder.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::Context;
use host_tests::speed::{Figures, Forward};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::build::{cargo, workspace};
use crate::process::{checked, output};

/// What is timed by Python.
const SCRIPT: &str = include_str!("scipy_kinematics.py");

/// `cargo xtask bench kinematics`
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Print one JSON document on standard output, and nothing else there
    #[arg(long)]
    json: bool,
    /// Time scipy on the same poses too, and print how many times longer it takes; needs python3, and its network for
    /// numpy and scipy the first time
    #[arg(long)]
    beside_scipy: bool,
}

/// What the script measured.
#[derive(Debug, Clone, Copy, Deserialize)]
struct Scipy {
    root_ns: f64,
    root_residual_m: f64,
    least_squares_ns: f64,
    least_squares_residual_m: f64,
}

/// Builds the measuring program with optimisation, runs it and prints its figures; fails when a pose was not found.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let python = arguments.beside_scipy.then(python).transpose()?;
    let program = ["--package", "host-tests", "--bin", "speed"];
    let speed = || {
        let mut speed = cargo("run");
        speed.args(["--quiet", "--release"]).args(program);
        speed
    };
    let text = output(&mut speed())?;
    let figures: Figures = serde_json::from_str(&text).context("the figures cannot be read")?;
    let scipy = match python {
        Some(python) => Some(scipy(&python, &output(speed().args(["--", "--cases"]))?)?),
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
    anyhow::ensure!(failed == 0, "{failed} poses were not found");
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

/// The Python of a virtual environment that has numpy and scipy.
fn python() -> anyhow::Result<PathBuf> {
    let target = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    let folder = target.unwrap_or_else(|| workspace().join("target"));
    let folder = folder.join("scipy");
    let python = folder.join("bin").join("python");
    let has_scipy = |python: &Path| {
        let mut asked = Command::new(python);
        asked.args(["-c", "import numpy, scipy"]);
        let quiet = asked.stdout(Stdio::null()).stderr(Stdio::null());
        quiet.status().is_ok_and(|status| status.success())
    };
    if !has_scipy(&python) {
        let mut environment = Command::new("python3");
        checked(environment.args(["-m", "venv"]).arg(&folder)).context(
            "--beside-scipy needs python3 with its module venv (on Debian: python3-venv); without it leave the option \
             out",
        )?;
        let mut packages = Command::new(&python);
        packages.args(["-m", "pip", "install", "--quiet", "numpy", "scipy"]);
        checked(&mut packages).context("numpy and scipy cannot be installed")?;
    }
    Ok(python)
}

/// Runs the script on `cases`.
fn scipy(python: &Path, cases: &str) -> anyhow::Result<Scipy> {
    let mut command = Command::new(python);
    // One thread, as the figures beside it.
    command
        .args(["-c", SCRIPT])
        .env("OMP_NUM_THREADS", "1")
        .env("OPENBLAS_NUM_THREADS", "1");
    let mut running = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .context("Python cannot be started")?;
    if let Some(mut input) = running.stdin.take() {
        input.write_all(cases.as_bytes())?;
    }
    let finished = running.wait_with_output()?;
    anyhow::ensure!(
        finished.status.success(),
        "scipy_kinematics.py failed ({})",
        finished.status
    );
    let figures: Scipy =
        serde_json::from_slice(&finished.stdout).context("the figures of scipy cannot be read")?;
    let worst_m = figures
        .root_residual_m
        .max(figures.least_squares_residual_m);
    anyhow::ensure!(
        worst_m < 1e-6,
        "scipy did not solve a pose: {worst_m} m off"
    );
    Ok(figures)
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
