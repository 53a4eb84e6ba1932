//! Wrong readings of the supply: no value moves, the counts of the events tell each of them, and the stream says when the
//! last good reading is too old to be relied on.

use std::time::Duration;

use anyhow::ensure;
use hexsense_core::wire::telemetry::Header;
use serde_json::{Value, json};

use super::outcome::Outcome;
use crate::bench::{Bench, Board};
use crate::key_holder::calibrate;
use crate::line::ArrivedBlock;
use crate::trial_set::Random;

/// Within this time of its start a board samples, also without a reading, ms.
const STARTED_MS: u64 = 100;
/// The pins of the bench have 3.3 V, and the supply factor is 1 but for rounding and noise.
const RIGHT: f32 = 1.0;
const NOISE: f32 = 1e-3;
/// Readings a second.
const PER_S: f64 = 10.0;
/// The mean is old a second after the last good reading; a reading and the way of a block take less than this, s.
const OLD_S: f64 = 1.0;
const SLACK_S: f64 = 0.15;
/// Longer than any trial, s.
const FOR_EVER_S: f64 = 100.0;

/// What the reference reads as, as a share of the supply: it is 1.212 V.
const SHARES: [(&str, f64); 7] = [
    ("code 0", -1.0),
    ("code 1", 1.0 / 4_096.0),
    ("code 4095", 2.0),
    ("double", 2.0 * 1.212 / 3.3),
    ("half", 0.5 * 1.212 / 3.3),
    ("a sixth too much", 1.212 / 3.3 * 1.17),
    ("a sixth too little", 1.212 / 3.3 / 1.17),
];

/// When a disturbance begins, and how long it lasts, s.
const TIMES: [(f64, f64); 4] = [
    // One reading.
    (1.0, 0.1),
    (1.0, 0.5),
    (1.0, 2.5),
    (0.0, FOR_EVER_S),
];

/// A disturbance.
struct Case {
    name: String,
    fault: Value,
    begins_s: f64,
    lasts_s: f64,
    /// Whether each reading of the time is wrong, so that their number is known.
    is_counted: bool,
}

fn cases(random: &mut Random) -> Vec<Case> {
    let mut cases = Vec::new();
    for (begins_s, lasts_s) in TIMES {
        let drawn = begins_s * (1.0 + 0.1 * f64::from(random.share()));
        let mut add = |name: &str, fault: Value, is_counted| {
            cases.push(Case {
                name: format!("{name}, {lasts_s} s from {drawn:.3} s on"),
                fault,
                begins_s: drawn,
                lasts_s,
                is_counted,
            });
        };
        let duration_us = (lasts_s * 1e6) as u64;
        for (name, share) in SHARES {
            let fault = json!({"fault": "reference", "share": share, "duration_us": duration_us, "at_s": drawn});
            add(name, fault, true);
        }
        let stall = json!({"fault": "dma_stall", "of": "supply", "duration_us": duration_us, "at_s": drawn});
        add("no result", stall, false);
    }
    cases
}

/// Disturbs the reference in every way; only every so many of the ways in the short form.
pub fn disturb(seed: u64, every: usize) -> anyhow::Result<Outcome> {
    let bench = Bench::new("faults/supply", seed)?;
    let mut random = Random(seed as u32 | 1);
    calibrate(&mut bench.on(&[])?.line, &mut random)?;
    let cases = cases(&mut random);
    let mut outcome = Outcome::new("supply", cases.len().div_ceil(every) as u64);
    for case in cases.iter().step_by(every) {
        outcome.inject();
        let done = trial(&bench, case);
        outcome.settle(done.map_err(|error| error.context(case.name.clone())));
    }
    Ok(outcome)
}

fn trial(bench: &Bench, case: &Case) -> anyhow::Result<()> {
    let mut board = bench.on(std::slice::from_ref(&case.fault))?;
    board.line.stream(true, false)?;
    let end_s = case.begins_s + case.lasts_s.min(2.5) + 0.5;
    board.line.run_until(Duration::from_secs_f64(end_s))?;
    for arrived in &board.line.blocks {
        look(arrived, case)?;
    }
    ensure!(board.line.blocks.len() > 10, "nothing came");
    told(&mut board, case, end_s)
}

/// No block has another factor than the right one, or a number that is none; those with an old factor say so.
fn look(arrived: &ArrivedBlock, case: &Case) -> anyhow::Result<()> {
    let Header {
        supply,
        supply_is_old,
        temperature_c,
        first_scan,
        ..
    } = arrived.block.header;
    ensure!(
        (supply - RIGHT).abs() < NOISE && temperature_c.is_finite(),
        "scan {first_scan}: the factor is {supply} at {temperature_c} °C"
    );
    let values = arrived.block.values.iter().flatten().flatten();
    ensure!(
        values.copied().all(|value| value.abs() < 1e6),
        "scan {first_scan}: {:?}",
        arrived.block.values
    );
    let at_s = arrived.at.as_secs_f64();
    // Without any good reading the factor is old at once.
    let since_s = case.begins_s + if case.begins_s > 0.0 { OLD_S } else { 0.0 };
    let until_s = case.begins_s + case.lasts_s;
    let is_settled = |from_s: f64| (at_s - from_s).abs() > SLACK_S;
    let due = since_s < until_s && (since_s..until_s).contains(&at_s);
    ensure!(
        due == supply_is_old || !is_settled(since_s) || !is_settled(until_s),
        "scan {first_scan} at {at_s:.3} s says {supply_is_old}"
    );
    Ok(())
}

/// The board counts each reading that it refused, has not been reset, and sampled in time.
fn told(board: &mut Board, case: &Case, end_s: f64) -> anyhow::Result<()> {
    let status = board.line.status()?;
    ensure!(status.resets.starts == 1, "{:?}", status.resets);
    let started = status.first_with_set_ms.is_some_and(|ms| ms <= STARTED_MS);
    ensure!(started, "first values at {:?} ms", status.first_with_set_ms);
    let readings = PER_S * case.lasts_s.min(end_s - case.begins_s);
    let counted = f64::from(status.events.supply_refused.count);
    let right = match case.is_counted {
        // A reading that was under way at the begin or the end may be right.
        true => (counted - readings).abs() <= 1.0 + 0.01 * readings && counted > 0.0,
        // A reading that does not come takes longer; one that is late is right.
        false => counted <= readings + 1.0 && (counted > 0.0 || readings <= 1.0),
    };
    ensure!(
        right,
        "{readings:.1} readings were wrong, and {counted} are counted"
    );
    Ok(())
}
