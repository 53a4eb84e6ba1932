//! `board-tests`: measurements and trials of the firmware's ELF on the virtual board. `cargo xtask` builds the programs
//! that a command needs, names them in the environment (see [`board_tests::programs`]) and calls it.
#![forbid(unsafe_code)]

use board_tests::figures::Print;
#[cfg(feature = "host-tool")]
use board_tests::{demo, faults};
use board_tests::{fixed_time, sample_path, size, timing};
use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(bin_name = "cargo xtask", disable_help_subcommand = true)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Flash and static RAM of the firmware by module; fails when it exceeds its budget
    Size(Print),
    /// Count the firmware's instructions on the virtual board, while it is busy
    Timing(Print),
    /// Measure how fast the product is
    #[command(subcommand)]
    Bench(Bench),
    /// Read the sample path in the ELF: no instruction's time depends on its operands
    FixedTime,
    /// Break what can break on the board, and count what is lost: every promise of docs/guarantees.md
    #[cfg(feature = "host-tool")]
    Faults(faults::Arguments),
    /// Calibrate nine sensors on a simulated motion base with the real firmware, and prove the result
    #[cfg(feature = "host-tool")]
    Demo(demo::Arguments),
}

#[derive(Subcommand)]
enum Bench {
    /// Instructions of the sample path on the board's core, beside those of estimators from crates.io
    SamplePath(Print),
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().task {
        Task::Size(print) => print.judged(&size::measure()?),
        Task::Timing(print) => print.judged(&timing::measure()?),
        Task::Bench(Bench::SamplePath(print)) => print.judged(&sample_path::measure()?),
        Task::FixedTime => fixed_time::check(),
        #[cfg(feature = "host-tool")]
        Task::Faults(arguments) => faults::run(&arguments),
        #[cfg(feature = "host-tool")]
        Task::Demo(arguments) => demo::run(&arguments),
    }
}
