//! The time that scipy takes for the poses of [`crate::speed`], measured by the script `scipy_kinematics.py`.
//!
//! The ratio of two times on one machine says more than either. Python's packages go into a virtual environment in the
//! target folder.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, ensure};
use serde::Deserialize;

/// What Python times.
const SCRIPT: &str = include_str!("scipy_kinematics.py");
/// Largest residual of a pose that scipy has solved, m.
const MAX_RESIDUAL_M: f64 = 1e-6;

/// What the script measures.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Scipy {
    /// Time of `root`, ns.
    pub root_ns: f64,
    /// Its largest residual, m.
    pub root_residual_m: f64,
    /// Time of `least_squares`, ns.
    pub least_squares_ns: f64,
    /// Its largest residual, m.
    pub least_squares_residual_m: f64,
}

/// A Python that has numpy and scipy.
pub struct Python(PathBuf);

impl Python {
    /// The Python of the virtual environment, which is made where it is missing.
    ///
    /// # Errors
    /// When python3 cannot make one, or its packages cannot be installed.
    pub fn find() -> anyhow::Result<Self> {
        let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let target = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
        let folder = target.unwrap_or_else(|| workspace.join("target"));
        let folder = folder.join("scipy");
        let python = folder.join("bin").join("python");
        if !has_scipy(&python) {
            run(Command::new("python3").args(["-m", "venv"]).arg(&folder)).context(
                "--beside-scipy needs python3 with its module venv (on Debian: python3-venv); without it leave the \
                 option out",
            )?;
            let install = ["-m", "pip", "install", "--quiet", "numpy", "scipy"];
            run(Command::new(&python).args(install))
                .context("numpy and scipy cannot be installed")?;
        }
        Ok(Self(python))
    }

    /// Runs the script on `cases`, which are JSON.
    ///
    /// # Errors
    /// When the script fails or scipy does not solve a pose.
    pub fn measure(&self, cases: &str) -> anyhow::Result<Scipy> {
        let mut command = Command::new(&self.0);
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
        ensure!(
            finished.status.success(),
            "scipy_kinematics.py failed ({})",
            finished.status
        );
        let figures: Scipy = serde_json::from_slice(&finished.stdout)
            .context("the figures of scipy cannot be read")?;
        let worst_m = figures
            .root_residual_m
            .max(figures.least_squares_residual_m);
        ensure!(
            worst_m < MAX_RESIDUAL_M,
            "scipy did not solve a pose: {worst_m} m off"
        );
        Ok(figures)
    }
}

fn has_scipy(python: &Path) -> bool {
    let mut asked = Command::new(python);
    asked.args(["-c", "import numpy, scipy"]);
    let quiet = asked.stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().is_ok_and(|status| status.success())
}

/// Runs a command to its end with its output on standard error; fails when it fails.
fn run(command: &mut Command) -> anyhow::Result<()> {
    command.stdin(Stdio::null()).stdout(std::io::stderr());
    let status = command.status().context("it cannot be started")?;
    ensure!(status.success(), "it failed ({status})");
    Ok(())
}
