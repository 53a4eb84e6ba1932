//! The firmware's own ELF on the virtual board: what it streams, sums, counts and loses.
//!
//! `cargo xtask test` builds both, names them in `HEXSENSE_FIRMWARE` and `HEXSENSE_VIRTUAL_BOARD`, and runs these tests with
//! `-- --ignored`.

mod build;
mod chip;
mod converters;
mod counted;
mod latency;
mod recovery;
mod stack;
mod stream;
mod sums;
mod triggers;
mod writes;

use std::time::Duration;

use board_tests::bench::{Bench, Board};
use board_tests::key_holder::calibrate;
use board_tests::line::Line;
use board_tests::trial_set::Random;
use serde_json::Value;

/// A new board that has been on for a second.
fn on(name: &str) -> anyhow::Result<Board> {
    settled(bench(name)?.on(&[])?)
}

/// The same, with triggers counted.
fn on_counting(name: &str) -> anyhow::Result<Board> {
    settled(bench(name)?.on_counting(&["sample_path"])?)
}

fn settled(mut board: Board) -> anyhow::Result<Board> {
    board.line.run_until(Duration::from_secs(1))?;
    Ok(board)
}

/// A board with key and coefficients, whose power was cut and came back at time 0, and to which these faults come.
fn calibrated(name: &str, faults: &[Value]) -> anyhow::Result<Board> {
    let bench = bench(name)?;
    calibrate(&mut bench.on(&[])?.line, &mut random())?;
    bench.on(faults)
}

/// A bench with an erased chip.
fn bench(name: &str) -> anyhow::Result<Bench> {
    Bench::new(&format!("tests/{name}"), 1)
}

/// Draws the same coefficients in every test.
fn random() -> Random {
    Random(0x9E37_79B9)
}

/// Lets the board run until this time since power-on, s.
fn run_until_s(line: &mut Line, seconds: f64) -> anyhow::Result<()> {
    line.run_until(Duration::from_secs_f64(seconds))
}
