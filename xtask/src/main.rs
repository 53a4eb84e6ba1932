//! One way to run everything: `cargo xtask demo`, `cargo xtask test`.
//!
//! - [`setup`]: what a fresh machine lacks.
//! - [`build`]: the parts of the product.
//! - [`process`]: programs that run beside each other, and end with their owner.
//! - [`demo`]: the whole story on the virtual bench.
//! - [`test`]: everything that must be green.
#![forbid(unsafe_code)]

mod build;
mod demo;
mod process;
mod setup;
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
    /// Format, lints for both targets, host tests, firmware, and a system test on the virtual board
    Test,
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().task {
        Task::Demo(arguments) => demo::run(&arguments),
        Task::Test => test::run(),
    }
}
