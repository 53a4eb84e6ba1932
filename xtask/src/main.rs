//! One way to run everything: `cargo xtask demo`, `cargo xtask test`, `cargo xtask size`.
//!
//! This program builds the parts of the product and calls the crate that does the work; it links none of them.
//!
//! - [`command`]: other programs, started and waited for.
//! - [`setup`]: what a fresh machine lacks.
//! - [`build`]: the parts of the product, built and named in the environment.
//! - [`call`]: the programs that commands call, in `board-tests` and `host-tests`.
//! - [`fuzz`]: the fuzz targets under cargo-fuzz.
//! - [`mutants`]: a sample of small mistakes under cargo-mutants.
//! - [`mod@test`]: everything that must be green, in its order.
#![forbid(unsafe_code)]

mod build;
mod call;
mod command;
mod fuzz;
mod mutants;
mod setup;
mod test;

use clap::{Parser, Subcommand};

use self::build::Part;
use self::call::{Flags, board_alone, board_tests, host_tests};

#[derive(Parser)]
#[command(
    name = "cargo xtask",
    about = "Builds, demonstrates and tests hexsense"
)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Calibrate nine sensors on a simulated motion base with the real firmware, and prove the result
    #[command(disable_help_flag = true)]
    Demo(Flags),
    /// Simulate many campaigns and count how often the truth lies inside the stated uncertainties
    #[command(disable_help_flag = true)]
    Coverage(Flags),
    /// Measure how exact the harmonic estimator is, from 0.01 to 50 Hz, at every rate, over one period to a hundred
    #[command(disable_help_flag = true)]
    Accuracy(Flags),
    /// Measure how fast the product is
    #[command(subcommand)]
    Bench(Bench),
    /// Flash and static RAM of the firmware by module; fails when it exceeds its budget
    #[command(disable_help_flag = true)]
    Size(Flags),
    /// Count the firmware's instructions on the virtual board, while it is busy
    #[command(disable_help_flag = true)]
    Timing(Flags),
    /// Break what can break on the board, and count what is lost: every promise of docs/guarantees.md
    #[command(disable_help_flag = true)]
    Faults(Flags),
    /// Attack the parts that take input from outside with cargo-fuzz
    Fuzz(fuzz::Arguments),
    /// Put small mistakes into the core and the host tool with cargo-mutants, and list those that no test notices
    Mutants(mutants::Arguments),
    /// Format, lints for both targets, host tests, firmware, and a system test on the virtual board
    Test(test::Arguments),
}

#[derive(Subcommand)]
enum Bench {
    /// Time of forward kinematics from home and from the pose before, of inverse kinematics, and of a recorded run
    #[command(disable_help_flag = true)]
    Kinematics(Flags),
    /// Instructions of the sample path on the board's core, beside those of estimators from crates.io
    #[command(disable_help_flag = true)]
    SamplePath(Flags),
}

fn main() -> anyhow::Result<()> {
    let call = match Arguments::parse().task {
        Task::Demo(flags) => board_tests(&Part::BENCH, &["demo"], &flags)?,
        Task::Coverage(flags) => host_tests("coverage", &flags),
        Task::Accuracy(flags) => host_tests("accuracy", &flags),
        Task::Bench(Bench::Kinematics(flags)) => host_tests("speed", &flags),
        Task::Bench(Bench::SamplePath(flags)) => {
            let parts = [Part::SamplePathBench, Part::VirtualBoard];
            board_alone(&parts, &["bench", "sample-path"], &flags)?
        }
        Task::Size(flags) => board_alone(&[Part::Firmware], &["size"], &flags)?,
        Task::Timing(flags) => board_alone(&Part::COUNTED, &["timing"], &flags)?,
        Task::Faults(flags) => board_tests(&Part::FAULTS, &["faults"], &flags)?,
        Task::Fuzz(arguments) => return fuzz::run(&arguments),
        Task::Mutants(arguments) => return mutants::run(&arguments),
        Task::Test(arguments) => return test::run(&arguments),
    };
    call::finish(call)
}
