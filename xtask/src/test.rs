//! Everything that must be green, in the order in which it fails soonest.

use std::process::Command;

use crate::bench_sample_path;
use crate::build::{self, Parts, cargo, firmware};
use crate::faults;
use crate::fixed_time;
use crate::process::checked;
use crate::setup;
use crate::size;
use crate::system_test;
use crate::timing;

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
    checks.add("size of the firmware", size::check());
    checks.run("host tests", &mut host_tests());
    checks.run(
        "documentation",
        cargo("doc")
            .args(["--package", "hexsense", "--no-deps"])
            .env("RUSTDOCFLAGS", "-D warnings"),
    );
    checks.add("fixed time of the sample path", sample_path());
    checks.add("instructions of the firmware", timing::check());
    checks.add("sample path on the board", board_tests());
    checks.add("demo, twice the same", system_test::demo_twice());
    checks.add(
        "plug pulled in a run and in an upload",
        system_test::plug_pulled(),
    );
    checks.add("streams at every rate", system_test::streams());
    checks.add("faults, in short", faults::check());
    checks.report()
}

/// No instruction of the sample path takes a time that depends on its operands.
fn sample_path() -> anyhow::Result<()> {
    checked(&mut firmware("build"))?;
    bench_sample_path::build()?;
    let parts = Parts::find()?;
    let symbols = bench_sample_path::path_symbols();
    let portable = fixed_time::check(&parts.sample_path_bench(), &symbols)?;
    let whole = fixed_time::check(&parts.firmware, &[SAMPLE_INTERRUPT.to_owned()])?;
    eprintln!(
        "{portable} functions of the portable path and {whole} of the firmware's interrupt have a fixed time"
    );
    Ok(())
}

/// The vector in which the firmware has its sample path, first instruction to last.
const SAMPLE_INTERRUPT: &str = "DMA1_CHANNEL1";
const DENY: [&str; 3] = ["--", "--deny", "warnings"];

/// The host tests that run the firmware's ELF, on the virtual board.
fn board_tests() -> anyhow::Result<()> {
    let parts = build::everything()?;
    let mut tests = cargo("test");
    tests.args([
        "--package",
        "host-tests",
        "--test",
        "board",
        "--",
        "--ignored",
    ]);
    tests.env("HEXSENSE_VIRTUAL_BOARD", &parts.virtual_board);
    tests.env("HEXSENSE_FIRMWARE", &parts.firmware);
    checked(&mut tests)
}

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
