//! One way to run everything: `cargo xtask demo`, `cargo xtask test`, `cargo xtask coverage`.
//!
//! - [`setup`]: what a fresh machine lacks.
//! - [`bench`]: twin, board and host tool together.
//! - [`build`]: the parts of the product.
//! - [`process`]: programs that run beside each other, and end with their owner.
//! - [`demo`]: the whole story on the virtual bench.
//! - [`bench_kinematics`]: how long kinematics takes.
//! - [`bench_sample_path`]: instructions of the sample path, beside what others offer.
//! - [`timing`]: instructions of the firmware itself, and its share of the core.
//! - [`counting`]: instruction counts on the virtual board.
//! - [`fixed_time`]: that the sample path has no instruction whose time depends on its operands; [`thumb`] decodes.
//! - [`faults`]: faults that are injected on the virtual board, and what the promises are worth; [`trial_set`] has sets.
//! - [`size`]: flash and RAM of the firmware, by module.
//! - [`accuracy`]: how exact the harmonic estimator is.
//! - [`fuzz`]: hostile input, as much as there is time for.
//! - [`coverage`]: whether the stated uncertainties are honest.
//! - [`test`]: everything that must be green.
//! - [`system_test`]: the part of it that needs the virtual board.
#![forbid(unsafe_code)]

mod accuracy;
mod bench;
mod bench_kinematics;
mod bench_sample_path;
mod build;
mod counting;
mod coverage;
mod demo;
mod faults;
mod fixed_time;
mod fuzz;
mod process;
mod setup;
mod size;
mod system_test;
mod test;
mod thumb;
mod timing;
mod told;
mod trial_set;

use clap::{Parser, Subcommand};

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
    Demo(demo::Arguments),
    /// Simulate many campaigns and count how often the truth lies inside the stated uncertainties
    Coverage(coverage::Arguments),
    /// Measure how exact the harmonic estimator is, from 0.01 to 50 Hz, at every rate, over one period to a hundred
    Accuracy(accuracy::Arguments),
    /// Measure how fast the product is
    #[command(subcommand)]
    Bench(Bench),
    /// Flash and static RAM of the firmware by module; fails when it has grown over its budget
    Size(size::Arguments),
    /// Count the firmware's instructions on the virtual board, while it is busy
    Timing(timing::Arguments),
    /// Break what can break on the board, and count what is lost: every promise of docs/guarantees.md
    Faults(faults::Arguments),
    /// Attack the parts that take input from outside with cargo-fuzz
    Fuzz(fuzz::Arguments),
    /// Format, lints for both targets, host tests, firmware, and a system test on the virtual board
    Test,
}

#[derive(Subcommand)]
enum Bench {
    /// Time of forward kinematics from home and from the pose before, of inverse kinematics, and of a recorded run
    Kinematics(bench_kinematics::Arguments),
    /// Instructions of the sample path on the board's core, beside those of estimators from crates.io
    SamplePath(bench_sample_path::Arguments),
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().task {
        Task::Demo(arguments) => demo::run(&arguments),
        Task::Coverage(arguments) => coverage::run(&arguments),
        Task::Accuracy(arguments) => accuracy::run(&arguments),
        Task::Bench(Bench::Kinematics(arguments)) => bench_kinematics::run(&arguments),
        Task::Bench(Bench::SamplePath(arguments)) => bench_sample_path::run(&arguments),
        Task::Size(arguments) => size::run(&arguments),
        Task::Timing(arguments) => timing::run(&arguments),
        Task::Faults(arguments) => faults::run(&arguments),
        Task::Fuzz(arguments) => fuzz::run(&arguments),
        Task::Test => test::run(),
    }
}
