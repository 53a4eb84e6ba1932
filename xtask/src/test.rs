//! Everything that must be green, in the order in which it fails soonest.

use std::process::Command;

use crate::build::Part;
use crate::call::{Flags, board_tests, host_tests, tests_on_the_board};
use crate::command::{cargo, checked, printed};
use crate::fuzz;
use crate::setup;

/// `cargo xtask test`
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The longer checks too: the whole fault campaign, accuracy, coverage, and a short run of the fuzzers
    #[arg(long)]
    all: bool,
}

const DENY: [&str; 3] = ["--", "--deny", "warnings"];
/// Inputs for each fuzz target in a short run.
const SMOKE: u64 = 100_000;

/// Runs all checks, prints a line for each, and fails if one of them did.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
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
    checks.run(
        "lints for the board",
        Part::Firmware.cargo("clippy").args(DENY),
    );
    checks.on_the_board("size of the firmware", &[Part::Firmware], &["size"]);
    checks.run("host tests", &mut tests());
    checks.run("documentation", &mut documentation());
    checks.on_the_board(
        "fixed time of the sample path",
        &[Part::Firmware, Part::SamplePathBench],
        &["fixed-time"],
    );
    checks.on_the_board("instructions of the firmware", &Part::COUNTED, &["timing"]);
    checks.tests("firmware on the virtual board", "firmware");
    checks.tests("board, twin and host tool", "system");
    checks.on_the_board("faults, in short", &Part::FAULTS, &["faults", "--short"]);
    if arguments.all {
        checks.on_the_board("faults", &Part::FAULTS, &["faults"]);
        for program in ["accuracy", "coverage"] {
            checks.run(program, &mut host_tests(program, &Flags::default()));
        }
        let short = fuzz::Arguments {
            runs: SMOKE,
            target: None,
        };
        checks.add("fuzz targets, in short", fuzz::run(&short));
    }
    checks.report()
}

/// The documentation of every library; the host tool's program has the name of the firmware's library.
fn documentation() -> Command {
    let mut doc = cargo("doc");
    doc.args(["--workspace", "--lib", "--no-deps"]);
    doc.env("RUSTDOCFLAGS", "-D warnings");
    doc
}

/// All tests that run on the host, with nextest where it is there.
fn tests() -> Command {
    let nextest = printed(cargo("nextest").arg("--version")).is_some();
    let mut tests = cargo(if nextest { "nextest" } else { "test" });
    if nextest {
        tests.arg("run");
    }
    tests.args(["--workspace", "--no-fail-fast"]);
    tests
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
        self.add(name, checked(command));
    }

    /// A command of `board-tests`.
    fn on_the_board(&mut self, name: &'static str, parts: &[Part], command: &[&str]) {
        eprintln!("\n=== {name}");
        let call = board_tests(parts, command, &Flags::default());
        self.add(name, call.and_then(|mut call| checked(&mut call)));
    }

    /// A file of tests of `board-tests`.
    fn tests(&mut self, name: &'static str, file: &str) {
        eprintln!("\n=== {name}");
        let tests = tests_on_the_board(file);
        self.add(name, tests.and_then(|mut tests| checked(&mut tests)));
    }

    fn add(&mut self, name: &'static str, result: anyhow::Result<()>) {
        match result {
            Ok(()) => self.passed.push(name),
            Err(error) => {
                eprintln!("{name}: {error:#}");
                self.failed.push(name);
            }
        }
    }

    fn report(self) -> ! {
        println!();
        self.passed
            .iter()
            .for_each(|name| println!("ok      {name}"));
        self.failed
            .iter()
            .for_each(|name| println!("FAILED  {name}"));
        println!("{} passed, {} failed", self.passed.len(), self.failed.len());
        // The count stays the last line; what failed stands above it.
        std::process::exit(i32::from(!self.failed.is_empty()));
    }
}
