//! The board goes on for years: its clock and its scan counter are preset to just before each of their wraps and far ahead,
//! and then everything that counts time or scans must go on.
//!
//! The virtual board writes both counters while the firmware waits for its crystal, before any task runs, so that the board
//! is one that has been on for so long. Within the next second the clock passes the value in question, amid a stream with
//! poses, an analyser that sums, a change and, when it has passed, another one, a noisy character and a new rate.

use std::time::Duration;

use anyhow::{Context, ensure};
use hexsense_core::harmonics::{Drive, increment};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::status::{EventCount, ResetCause};
use hexsense_core::wire::{Request, Response};
use serde_json::{Value, json};

use super::gaps::Gaps;
use super::outcome::Outcome;
use crate::bench::{Bench, Board};
use crate::key_holder::calibrate;
use crate::trial_set::Random;

/// The driver of the clock counts periods of 2^15 ticks of 10 µs.
const CLOCK: [&str; 2] = [
    "embassy_stm32::time_driver::driver::DRIVER",
    "period.v.value",
];
const PERIOD_MS: f64 = 32_768.0 * 10e-3;
const PATH: &str = "firmware::sampling::path::STATE";
const SCANS: &str = "data.value.value.value.path.progress.next_scan";
const DROPPED: &str = "data.value.value.value.path.progress.dropped";
const EVENTS: [&str; 2] = [
    "firmware::health::counters::EVENTS",
    "data.value.value.value.receiver_errors.count",
];

/// The firmware waits for its crystal then.
const PRESET_S: f64 = 0.004;
/// The clock is preset to two periods before the value that it is to pass.
const BEFORE: u64 = 2;
/// When it has passed: then comes the noisy character.
const NOISE_S: f64 = 1.2;
const END: Duration = Duration::from_millis(1_500);
/// From power-on to the start of the clock at most, ms.
const START_MS: f64 = 20.0;

const RATE_HZ: u32 = 4_000;
const YEAR_S: f64 = 365.25 * 86_400.0;
/// Poses of a second at least, of a hundred.
const POSES: usize = 80;
/// Scans that a new rate may lose.
const MAX_LOST: u64 = 50;

/// How far the clock has come when it passes the value in question, s, and what the scan counter passes.
fn cases() -> Vec<(f64, u64)> {
    let mut cases: Vec<_> = (1..32)
        .map(|bit| f64::from(1u32 << bit) * PERIOD_MS * 1e-3)
        .collect();
    // A clock of 32 bits in ms and in µs, one of 47 bits in µs, and years.
    cases.extend([(1u64 << 32) as f64 * 1e-3, (1u64 << 32) as f64 * 1e-6]);
    cases.push((1u64 << 47) as f64 * 1e-6);
    cases.extend([1.0, 5.0, 10.0, 20.0, 30.0, 40.0, 44.0].map(|years| years * YEAR_S));
    cases
        .into_iter()
        .enumerate()
        .map(|(number, passes_s)| {
            let scans = (passes_s * f64::from(RATE_HZ)) as u64;
            // Every third time a counter that has wrapped or lost digits would show.
            let power = 1 << (31 + number % 25);
            (passes_s, if number % 3 == 0 { power } else { scans })
        })
        .collect()
}

/// Tries one case in `every`, and counters at their largest value.
pub fn pass(seed: u64, every: usize) -> anyhow::Result<Outcome> {
    let cases: Vec<_> = cases().into_iter().step_by(every).collect();
    let mut outcome = Outcome::new("uptime", cases.len() as u64 + 2);
    let bench = Bench::new("faults/uptime", seed)?;
    let mut random = Random(seed as u32 | 1);
    calibrate(&mut bench.on(&[])?.line, &mut random)?;
    bench.keep("calibrated")?;
    for (passes_s, scans) in cases {
        bench.restore("calibrated")?;
        outcome.inject();
        let done = go_on(&bench, passes_s, scans, &mut random);
        let about = || format!("clock past {passes_s} s, scans past {scans}");
        outcome.settle(done.with_context(about));
    }
    for full in [dropped_stop, errors_stop] {
        outcome.inject();
        outcome.settle(full(&bench));
    }
    Ok(outcome)
}

fn preset(variable: &str, member: &str, value: u64) -> Value {
    json!({"at_s": PRESET_S, "fault": "preset", "variable": variable, "member": member, "value": value})
}

/// Passes the time `passes_s` and this number of scans.
fn go_on(bench: &Bench, passes_s: f64, scans: u64, random: &mut Random) -> anyhow::Result<()> {
    // An even number: the timer is in the first half of its range.
    let periods = (passes_s * 1e3 / PERIOD_MS) as u64 / 2 * 2 - BEFORE;
    let first_scan = scans.saturating_sub(u64::from(RATE_HZ) / 2);
    let mut board = bench.on(&[
        preset(CLOCK[0], CLOCK[1], periods),
        preset(PATH, SCANS, first_scan),
        json!({"at_s": NOISE_S, "fault": "line", "towards": "board", "effect": "noise", "characters": 1}),
    ])?;
    let began_ms = periods as f64 * PERIOD_MS;
    let drive = Drive {
        increment: increment(8.0, RATE_HZ).context("a drive that the board takes")?,
        block: BlockSize::Sixteen,
        settle_blocks: 0,
        blocks: RATE_HZ / 16,
    };
    let line = &mut board.line;
    line.order(&Request::Rate(RATE_HZ))?;
    line.order(&Request::Drive { analyser: 0, drive })?;
    line.blocks.clear();
    line.stream(false, true)?;
    line.run_until(Duration::from_secs_f64(0.6))?;
    calibrate(line, random)?;
    line.run_until(Duration::from_secs_f64(NOISE_S))?;
    check_stream(&mut board, first_scan)?;
    board.line.send(&Request::Status)?;
    board.line.run_until(END)?;
    check_status(&mut board, began_ms)?;
    let line = &mut board.line;
    match line.ask(&Request::Harmonics {
        analyser: 0,
        channel: 0,
    })? {
        Response::Harmonics { first_scan: at, .. } => ensure!(
            (first_scan..first_scan + u64::from(RATE_HZ)).contains(&at),
            "an analyser began at scan {at}, the board at {first_scan}"
        ),
        other => anyhow::bail!("the harmonics: {other:?}"),
    }
    calibrate(line, random)?;
    let lost = line.status()?.scans_lost;
    line.order(&Request::Rate(2_000))?;
    let lost = line.status()?.scans_lost - lost;
    ensure!(
        lost <= MAX_LOST,
        "{lost} scans were lost when the rate changed"
    );
    Ok(())
}

/// Every scan of the last second arrived, and so did the poses.
fn check_stream(board: &mut Board, first_scan: u64) -> anyhow::Result<()> {
    let mut gaps = Gaps::default();
    let first = board.line.blocks.front();
    let first = first.context("no block arrived")?.block.header.first_scan;
    ensure!(
        (first_scan..first_scan + u64::from(RATE_HZ)).contains(&first),
        "the stream began at scan {first}, the board at {first_scan}"
    );
    gaps.follow(&mut board.line);
    ensure!(
        gaps.scans >= u64::from(RATE_HZ) && gaps.missing + gaps.repeated == 0,
        "the stream: {gaps:?}"
    );
    let poses = std::mem::take(&mut board.line.poses);
    ensure!(poses.len() >= POSES, "{} poses arrived", poses.len());
    Ok(())
}

/// The clock is right, nothing was reset, and the only event has its time.
fn check_status(board: &mut Board, began_ms: f64) -> anyhow::Result<()> {
    let now_ms = board.line.now().as_secs_f64() * 1e3;
    let status = board.line.status()?;
    let uptime_ms = status.uptime_ms as f64 - began_ms;
    ensure!(
        (now_ms - START_MS..now_ms + 2.0).contains(&uptime_ms),
        "after {now_ms} ms the clock has gone on by {uptime_ms} ms"
    );
    let reset = board.line.identity()?.reset;
    ensure!(
        status.resets.starts == 1 && reset == ResetCause::PowerOn,
        "{:?}, {reset:?}",
        status.resets
    );
    let events = status.events;
    let EventCount { count, last_ms } = events.receiver_errors;
    let at_ms = last_ms as f64 - began_ms;
    let noise_ms = NOISE_S * 1e3;
    ensure!(
        count == 1 && (noise_ms - START_MS..noise_ms + 5.0).contains(&at_ms),
        "noise after {noise_ms} ms was counted {count} times, after {at_ms} ms"
    );
    ensure!(
        events.converter_faults() + events.blocks_dropped.count == 0,
        "{events:?}"
    );
    Ok(())
}

/// Blocks that the link drops are counted up to the largest count, which then stays.
fn dropped_stop(bench: &Bench) -> anyhow::Result<()> {
    bench.restore("calibrated")?;
    let mut board = bench.on(&[
        preset(PATH, DROPPED, u64::from(u32::MAX) - 1),
        json!({"at_s": 0.5, "fault": "dma_stall", "of": "transmitter", "duration_us": 100_000}),
    ])?;
    let line = &mut board.line;
    line.stream_everything()?;
    line.run_s(1.0)?;
    let mut gaps = Gaps::default();
    gaps.follow(line);
    let count = line.status()?.events.blocks_dropped.count;
    ensure!(
        count == u32::MAX && gaps.missing > 64,
        "a count of dropped blocks went on to {count}, while {gaps:?}"
    );
    Ok(())
}

/// The same for an error of the receiver; its last time goes on.
fn errors_stop(bench: &Bench) -> anyhow::Result<()> {
    bench.restore("calibrated")?;
    let noise = |at_s: f64| json!({"at_s": at_s, "fault": "line", "towards": "board", "effect": "noise", "characters": 1});
    let mut board = bench.on(&[
        preset(EVENTS[0], EVENTS[1], u64::from(u32::MAX) - 1),
        noise(0.2),
        noise(0.3),
    ])?;
    for at_ms in [200, 300] {
        board.line.run_until(Duration::from_millis(at_ms))?;
        board.line.send(&Request::Status)?;
    }
    board.line.run_s(0.1)?;
    let EventCount { count, last_ms } = board.line.status()?.events.receiver_errors;
    ensure!(
        count == u32::MAX && last_ms > 250,
        "a count of errors went on to {count}, at {last_ms} ms"
    );
    Ok(())
}
