//! The host tool records streams at every rate: no scan is missing, values are those that the counts give, and a stream that
//! the link cannot carry is refused.

use std::process::Command;

use anyhow::{Context, ensure};
use board_tests::folders;
use board_tests::process::{Beside, checked, output};
use board_tests::virtual_bench::VirtualBench;
use hexsense_core::channel::{CHANNELS, NAMES};
use hexsense_probe::capture::Capture;
use hexsense_probe::coefficient_file;
use hexsense_probe::replay::first_wrong_values;
use serde_json::Value;

use crate::bench;
use crate::told::{self, Told};

/// Rates with the blocks that are recorded at each.
const STREAMS: [(u32, u32); 6] = [
    (1_000, 1),
    (1_000, 16),
    (2_000, 1),
    (4_000, 1),
    (4_000, 8),
    (4_000, 32),
];
/// Length of a recording, s.
const STREAM_S: u32 = 4;

#[test]
#[ignore = "needs the built programs"]
fn streams_at_every_rate() -> anyhow::Result<()> {
    let folder = folders::emptied("system/streams")?;
    let bench = bench(&folder);
    let twin = bench.twin()?;
    bench.papers()?;
    let board = bench.board(&twin)?;
    for (rate, block) in STREAMS {
        let (capture, _) = record(&bench, &board, (rate, block), &[])?;
        ensure!(capture.values.is_none(), "values that nobody asked for");
    }
    checked(&mut bench.drive("calibrate", &board, &twin, 0)?)?;
    bench.provision(&board)?;
    checked(&mut bench.upload(&board)?)?;
    factors(&bench, &board)?;
    let (capture, note) = record(&bench, &board, (1_000, 16), &["--values"])?;
    ensure!(
        note["set"] == bench.active_id(&board)?,
        "the note names another set: {note}"
    );
    ensure!(capture.values.is_some(), "no values were recorded");
    let wrong = first_wrong_values(&capture, &coefficient_file::load(&bench.coefficients())?.0);
    ensure!(wrong.is_none(), "the board's values are wrong: {wrong:?}");
    let refused = Told::start(&mut capture_command(
        &bench,
        &board,
        (4_000, 16),
        &["--values"],
    )?)?;
    let (success, said) = refused.ended(told::WITHIN)?;
    ensure!(
        !success && said.contains("the link cannot carry"),
        "4 kHz with values was not refused: {said}"
    );
    let status = output(bench.hexsense("status", &board)?.arg("--json"))?;
    let status: Value = serde_json::from_str(&status)?;
    ensure!(
        status["link"]["blocks_dropped"] == 0 && status["faults"] == 0,
        "the board dropped blocks or had faults: {status}"
    );
    Ok(())
}

/// Largest difference between a factor of the board and the fitted gain; the cross terms of the matrix and the dynamics of
/// the servos make it.
const FACTOR_OFF: f64 = 0.05;

/// The board's own harmonics of the run that was recorded last, and its calibration factors beside the fitted gains.
fn factors(bench: &VirtualBench, board: &Beside) -> anyhow::Result<()> {
    let said = output(bench.hexsense("harmonics", board)?.arg("--json"))?;
    let said: Value = serde_json::from_str(&said)?;
    let channels = said["channels"].as_array().context("no channels")?;
    ensure!(channels.len() == CHANNELS, "not all channels: {said}");
    let factors = said["motion"]["factors"].as_array();
    let factors = factors.with_context(|| format!("no factors: {said}"))?;
    let (set, _) = coefficient_file::load(&bench.coefficients())?;
    let mut compared = 0;
    for factor in factors {
        let channel = NAMES.iter().position(|name| factor["channel"] == *name);
        let channel = channel.with_context(|| format!("no such channel: {factor}"))?;
        let (triad, axis) = (channel / 3, channel % 3);
        // In a rotation an accelerometer feels gravity and the lever arm.
        if triad == 0 {
            continue;
        }
        let gain = f64::from(set.triads[triad].matrix[axis][axis]).abs();
        let found = factor["per_count"].as_f64().unwrap_or(f64::NAN);
        let off = (found / gain - 1.0).abs();
        ensure!(off < FACTOR_OFF, "{factor}, and the fitted gain is {gain}");
        compared += 1;
    }
    ensure!(compared > 0, "no factor was compared: {said}");
    Ok(())
}

/// A recording that must be complete, and its note.
fn record(
    bench: &VirtualBench,
    board: &Beside,
    (rate, block): (u32, u32),
    more: &[&str],
) -> anyhow::Result<(Capture, Value)> {
    checked(&mut capture_command(bench, board, (rate, block), more)?)?;
    let capture = Capture::load(&bench.folder.join("stream.csv"))?;
    let note = std::fs::read_to_string(bench.folder.join("stream.json"))?;
    let note: Value = serde_json::from_str(&note)?;
    let due = (STREAM_S * rate) as usize;
    ensure!(
        capture.gaps().is_empty() && capture.scans.len() >= due && note["scans_lost"] == 0,
        "{} of {due} scans at {rate} Hz in blocks of {block}: {note}",
        capture.scans.len()
    );
    Ok((capture, note))
}

fn capture_command(
    bench: &VirtualBench,
    board: &Beside,
    (rate, block): (u32, u32),
    more: &[&str],
) -> anyhow::Result<Command> {
    let mut capture = bench.hexsense("capture", board)?;
    let [seconds, rate, block] = [STREAM_S, rate, block].map(|number| number.to_string());
    capture.args(["--seconds", &seconds, "--rate", &rate, "--block", &block]);
    capture
        .arg("--out")
        .arg(bench.folder.join("stream.csv"))
        .args(more);
    Ok(capture)
}
