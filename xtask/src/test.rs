//! Everything that must be green, in the order in which it fails soonest.

use std::process::Command;

use anyhow::Context;

use crate::build::{self, cargo, firmware};
use crate::process::checked;
use crate::setup;

/// Runs all checks, prints a line for each, and fails if one of them did.
pub fn run() -> anyhow::Result<()> {
    setup::board_target()?;
    setup::emulator_packages()?;
    let mut checks = Checks::default();
    checks.run("format", cargo("fmt").args(["--all", "--check"]));
    checks.run(
        "lints for the host",
        cargo("clippy")
            .args(["--workspace", "--all-targets"])
            .args(DENY),
    );
    checks.run("lints for the board", firmware("clippy").args(DENY));
    checks.run("host tests", &mut host_tests());
    checks.run(
        "documentation",
        cargo("doc")
            .args(["--package", "hexsense", "--no-deps"])
            .env("RUSTDOCFLAGS", "-D warnings"),
    );
    checks.run("firmware", &mut firmware("build"));
    checks.run("system test on the virtual board", &mut system_test());
    checks.report()
}

const DENY: [&str; 3] = ["--", "--deny", "warnings"];

/// All tests that run on the host, with nextest where it is there.
fn host_tests() -> Command {
    let nextest = cargo("nextest")
        .arg("--version")
        .output()
        .is_ok_and(|output| output.status.success());
    let mut tests = cargo(if nextest { "nextest" } else { "test" });
    if nextest {
        tests.arg("run");
    }
    tests.args(["--workspace"]);
    tests
}

/// The demo: the firmware's ELF through the whole method.
fn system_test() -> Command {
    let demo = std::env::current_exe().unwrap_or_else(|_| "xtask".into());
    let mut command = Command::new(demo);
    command
        .args(["demo", "--json", "--out"])
        .arg(build::workspace().join("target/system-test"));
    command
}

/// Which checks passed and which failed.
#[derive(Default)]
struct Checks {
    passed: Vec<&'static str>,
    failed: Vec<&'static str>,
}

impl Checks {
    fn run(&mut self, name: &'static str, command: &mut Command) {
        eprintln!("\n=== {name}");
        match checked(command) {
            Ok(()) => self.passed.push(name),
            Err(error) => {
                eprintln!("{error:#}");
                self.failed.push(name);
            }
        }
    }

    fn report(self) -> anyhow::Result<()> {
        println!();
        self.passed
            .iter()
            .for_each(|name| println!("ok      {name}"));
        self.failed
            .iter()
            .for_each(|name| println!("FAILED  {name}"));
        println!("{} passed, {} failed", self.passed.len(), self.failed.len());
        self.failed
            .is_empty()
            .then_some(())
            .context("see the checks that failed above")
    }
}
