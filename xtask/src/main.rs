//! One way to run everything: `cargo xtask demo`, `cargo xtask test`, `cargo xtask coverage`.
//!
//! - [`setup`]: what a fresh machine lacks.
//! - [`bench`]: twin, board and host tool together.
//! - [`build`]: the parts of the product.
//! - [`process`]: programs that run beside each other, and end with their owner.
//! - [`demo`]: the whole story on the virtual bench.
//! - [`bench_kinematics`]: how long kinematics takes.
//! - [`coverage`]: whether the stated uncertainties are honest.
//! - [`test`]: everything that must be green.
//! - [`system_test`]: the part of it that needs the virtual board.
#![forbid(unsafe_code)]

mod bench;
mod bench_kinematics;
mod build;
mod coverage;
mod demo;
mod process;
mod setup;
mod system_test;
mod test;

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
    /// Measure how fast the product is
    #[command(subcommand)]
    Bench(Bench),
    /// Format, lints for both targets, host tests, firmware, and a system test on the virtual board
    Test,
}

#[derive(Subcommand)]
enum Bench {
    /// Time of forward kinematics from home and from the pose before, of inverse kinematics, and of a recorded run
    Kinematics(bench_kinematics::Arguments),
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().task {
        Task::Demo(arguments) => demo::run(&arguments),
        Task::Coverage(arguments) => coverage::run(&arguments),
        Task::Bench(Bench::Kinematics(arguments)) => bench_kinematics::run(&arguments),
        Task::Test => test::run(),
    }
}
