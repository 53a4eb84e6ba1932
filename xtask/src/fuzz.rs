//! `cargo xtask fuzz`: the targets of `host-tests/hostile` under cargo-fuzz.
//!
//! The host tests run the corpus that is kept beside the targets. A fuzzer begins with it and adds to a copy, so that only
//! chosen inputs become tests.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, ensure};

use crate::command::{cargo, checked, printed, workspace};

/// Longest input, bytes: what targets do with longer ones is the same again, and slower.
const MAX_LENGTH: u32 = 128;

/// `cargo xtask fuzz`
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Inputs for each target
    #[arg(long, default_value_t = 1_000_000)]
    pub runs: u64,
    /// The only target to run: frames, messages, storage, records or host
    pub target: Option<String>,
}

/// Runs the targets one after another, and fails with the first that finds something.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut names = targets()?;
    if let Some(target) = &arguments.target {
        ensure!(
            names.contains(target),
            "there is no target {target}; targets are {}",
            names.join(", ")
        );
        names.retain(|name| name == target);
    }
    for name in names {
        let grown = workspace().join("target/fuzz").join(&name);
        std::fs::create_dir_all(&grown)?;
        eprintln!("{name}: {} inputs", arguments.runs);
        checked(&mut fuzz(&name, &grown, arguments.runs))?;
    }
    println!("no target found anything");
    Ok(())
}

/// The names of the targets.
fn targets() -> anyhow::Result<Vec<String>> {
    let list = printed(cargo("fuzz").arg("list").arg("--fuzz-dir").arg(folder()));
    let list = list.context(
        "fuzzing needs cargo-fuzz and a C++ compiler; install them with\n\n    cargo install cargo-fuzz\n    sudo apt-get \
         install g++\n\n(or your system's equivalents) and start again",
    )?;
    Ok(list.lines().map(str::to_owned).collect())
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
