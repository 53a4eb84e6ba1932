//! Captures record gaps as gaps: each fault that costs scans leaves one gap in the file of `hexsense capture`, at its place
//! and without a row in it, and the note beside the file names the gap.

use std::fs;
use std::process::Command;

use anyhow::Context;
use hexsense_probe::capture::Capture;
use serde_json::{Value, json};

use super::outcome::Outcome;
use crate::bench::Bench;
use crate::power::Power;
use crate::process::checked;
use crate::programs::Program;

/// When the first fault comes, long after the capture has begun, and the time from one fault to the next.
const FIRST_S: f64 = 2.0;
const APART_S: f64 = 0.1;
const RATE_HZ: u32 = 4_000;
/// A fault spoils the current block or the frame that is being sent, which may be two blocks older, scans.
const LATE: u64 = 48;

/// Records while each kind of fault comes `times` times; the outcome is a part of the promise `counted`.
pub fn record(seed: u64, times: u32) -> anyhow::Result<Outcome> {
    let kinds = [
        json!({"fault": "dma_stall", "of": "converters", "duration_us": 300}),
        json!({"fault": "trigger_stall", "duration_us": 40_000}),
        json!({"fault": "line", "towards": "host", "effect": "lost", "characters": 3}),
        json!({"fault": "line", "towards": "host", "effect": "damaged", "characters": 1}),
    ];
    let faults: Vec<Value> = (0..times as usize * kinds.len())
        .map(|index| {
            let mut fault = kinds[index % kinds.len()].clone();
            fault["at_s"] = json!(FIRST_S + APART_S * index as f64);
            fault
        })
        .collect();
    let mut outcome = Outcome::new("counted", faults.len() as u64);
    outcome.inject_many(faults.len() as u64);
    let bench = Bench::new("faults/captures", seed)?;
    let board = bench.start(&Power {
        faults: &faults,
        ..Power::default()
    })?;
    let port = board.address("link")?;
    let file = bench.folder().join("capture.csv");
    let seconds = FIRST_S + APART_S * faults.len() as f64;
    let mut command = Command::new(Program::HostTool.path()?);
    command.args(["capture", "--port", port, "--rate", &RATE_HZ.to_string()]);
    command.args(["--seconds", &format!("{seconds:.1}"), "--out"]);
    checked(command.arg(&file))?;
    let capture = Capture::load(&file)?;
    let note: Value = serde_json::from_str(&fs::read_to_string(file.with_extension("json"))?)?;
    judge(&mut outcome, &capture, &note, faults.len())?;
    Ok(outcome)
}

/// Compares the file, its note, and the faults.
fn judge(
    outcome: &mut Outcome,
    capture: &Capture,
    note: &Value,
    faults: usize,
) -> anyhow::Result<()> {
    let gaps = capture.gaps();
    outcome.check(gaps.len() == faults, || {
        format!("{faults} faults left {} gaps in the capture", gaps.len())
    });
    let told = note["gaps"].as_array().context("it names no gaps")?;
    let begins: Vec<u64> = gaps.iter().map(|gap| gap.first_scan).collect();
    let same = told
        .iter()
        .zip(&gaps)
        .all(|(told, gap)| told["first_scan"] == gap.first_scan && told["scans"] == gap.scans);
    outcome.check(same && told.len() == gaps.len(), || {
        format!("the capture has gaps {gaps:?}, its note {told:?}")
    });
    let apart = (f64::from(RATE_HZ) * APART_S) as u64;
    let late = |pair: &[u64]| (pair[1] - pair[0]).abs_diff(apart) > LATE;
    outcome.check(!begins.windows(2).any(late), || {
        format!("faults came every {apart} scans, but gaps at {begins:?}")
    });
    Ok(())
}
