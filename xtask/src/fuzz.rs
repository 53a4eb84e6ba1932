//! Fuzzing: the targets of `host-tests/hostile` under cargo-fuzz, with what they find kept for the host tests.
//!
//! Their kept corpus is what the host tests run; a fuzzer begins with it and adds to a copy, so that only chosen inputs
//! become tests.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::bail;

use crate::build::{cargo, workspace};
use crate::process::{checked, output};

/// Longest input, bytes: what targets do with longer ones is the same again, and slower.
const MAX_LENGTH: u32 = 128;

#[derive(clap::Args)]
pub struct Arguments {
    /// Inputs for each target
    #[arg(long, default_value_t = 1_000_000)]
    runs: u64,
    /// The only target to run: frames, messages, storage or records
    target: Option<String>,
}

/// Runs the targets one after another, and fails with the first that finds something.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    check_installed()?;
    let names = hostile::TARGETS.map(|(name, _)| name);
    let chosen: Vec<&str> = match &arguments.target {
        None => names.to_vec(),
        Some(target) if names.contains(&target.as_str()) => vec![target],
        Some(target) => bail!(
            "there is no target {target}; targets are {}",
            names.join(", ")
        ),
    };
    for name in chosen {
        let grown = workspace().join("target/fuzz").join(name);
        std::fs::create_dir_all(&grown)?;
        eprintln!("{name}: {} inputs", arguments.runs);
        checked(&mut fuzz(name, &grown, arguments.runs))?;
    }
    println!("no target found anything");
    Ok(())
}

fn check_installed() -> anyhow::Result<()> {
    if output(cargo("fuzz").arg("--version")).is_err() {
        bail!(
            "fuzzing needs cargo-fuzz and a C++ compiler; install them with\n\n    cargo install cargo-fuzz\n    sudo apt-get install g++\n\n(or your system's equivalents) and start again"
        );
    }
    Ok(())
}

/// One target. Sanitizers need a nightly compiler and find what unsafe code does wrong; the core has none.
fn fuzz(name: &str, grown: &Path, runs: u64) -> Command {
    let mut command = cargo("fuzz");
    command.args(["run", "--sanitizer", "none", "--fuzz-dir"]);
    command.arg(folder()).arg(name).arg(grown);
    command.arg(folder().join("corpus").join(name));
    command.args([
        "--".to_owned(),
        format!("-runs={runs}"),
        format!("-max_len={MAX_LENGTH}"),
        "-print_final_stats=1".to_owned(),
    ]);
    command
}

fn folder() -> PathBuf {
    workspace().join("host-tests/fuzz")
}
