//! A board whose crystal fails comes back on its internal oscillator with its coefficients, at once, and says so.
//!
//! The crystal dies at many moments: before the power comes on, in every part of the start, while the board samples and
//! streams, and while an operation of the flash is under way. The PLL then drifts to any fraction of its frequency. A
//! board that does not notice would sample on, several times too slowly.

use std::time::Duration;

use anyhow::{Context, ensure};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::status::ResetCause;
use hexsense_core::wire::{Drive, Refusal, Request};
use serde_json::{Value, json};

use super::outcome::Outcome;
use crate::bench::{Bench, Board};
use crate::key_holder::{Account, Act, KeyHolder, calibrate};
use crate::line::Line;
use crate::trial_set::Random;

/// The PLL drifts to 1 / 2 to 1 / 12 of its frequency.
const DRIFTS: std::ops::RangeInclusive<u64> = 2..=12;
/// The chip watches the crystal from this time on, s; before, only the watchdog may notice.
const WATCHED_S: f64 = 0.01;
/// The crystal gets ready after this time and is taken into use within that, s.
const FIRST_USE_S: f64 = 5.2e-3;
const FIRST_USE_TAKES_S: f64 = 0.7e-3;
/// From the failure to a board that samples with its set, s: at once, or after the watchdog has bitten.
const AT_ONCE_S: f64 = 0.1;
const BITTEN_S: f64 = 1.3;
/// Error of the internal oscillator.
const INTERNAL: f64 = 0.011;

/// How much is tried.
pub struct Extent {
    /// Moments in the whole start, and twice as many while the crystal is taken into use.
    pub starting: u32,
    /// Moments while the board streams.
    pub streaming: u32,
    /// Flash operations of an upload.
    pub writing: u32,
}

/// Lets the crystal die at all these moments.
pub fn fail(seed: u64, extent: &Extent) -> anyhow::Result<Outcome> {
    let mut outcome = Outcome::new("clock", 20);
    let bench = Bench::new("faults/clock", seed)?;
    let mut random = Random(seed as u32 | 1);
    let mut board = bench.on(&[])?;
    let (key_holder, _) = calibrate(&mut board.line, &mut random)?;
    let account = Account::read(&mut board.line)?;
    drop(board);
    bench.keep("before")?;
    let mut drifts = DRIFTS.cycle();
    let part = |number| f64::from(number) / f64::from(extent.starting);
    let whole_start = (0..extent.starting).map(|number| WATCHED_S * part(number));
    let first_use =
        (0..extent.starting).map(|number| FIRST_USE_S + 0.5 * FIRST_USE_TAKES_S * part(number));
    let streaming = (0..extent.streaming).map(|_| 0.3 + 0.1 * f64::from(random.share()));
    for at_s in whole_start.chain(first_use).chain(streaming) {
        let drift = drifts.next();
        outcome.inject();
        let done = failure(&bench, at_s, drift, &account);
        outcome.settle(done.map_err(|error| error.context(format!("{at_s:.5} s, 1 / {drift:?}"))));
    }
    let set = random.set(key_holder.board);
    for part in 0..extent.writing {
        let (operation, drift) = (1 + 3 * part, drifts.next());
        bench.restore("before")?;
        outcome.inject();
        let done = while_writing(
            &bench,
            &key_holder,
            &Act::Upload(Box::new(set.clone())),
            operation,
            drift,
            &account,
        );
        let place = || format!("flash operation {operation}, 1 / {drift:?}");
        outcome.settle(done.map_err(|error| error.context(place())));
    }
    Ok(outcome)
}

/// The crystal dies at this time since power-on, s.
fn failure(bench: &Bench, at_s: f64, drift: Option<u64>, account: &Account) -> anyhow::Result<()> {
    let mut board = bench.on(&[json!({"at_s": at_s, "fault": "crystal", "drift": drift})])?;
    let watched = at_s >= WATCHED_S;
    if watched {
        board.line.stream_everything()?;
    }
    let patience_s = if watched {
        AT_ONCE_S
    } else {
        BITTEN_S + AT_ONCE_S
    };
    let line = &mut board.line;
    line.run_until(Duration::from_secs_f64(at_s + patience_s))?;
    on_internal_oscillator(line, at_s + patience_s)?;
    let cause = line.identity()?.reset;
    let right = match cause {
        ResetCause::Crystal => true,
        // It never started, or died before it was watched.
        ResetCause::PowerOn | ResetCause::Watchdog => !watched,
        _ => false,
    };
    ensure!(right, "it says {cause:?}");
    let found = Account::read(line)?;
    ensure!(found == *account, "its account is {found:?} now");
    Ok(())
}

/// The board samples with its set since `latest_s` at the latest, at the true rate but for the error of its oscillator,
/// and refuses to calibrate.
fn on_internal_oscillator(line: &mut Line, latest_s: f64) -> anyhow::Result<()> {
    // The reset cut off a frame of the stream, and the first answer may be lost with it.
    let before = line.status().or_else(|_| line.status())?;
    ensure!(!before.crystal, "it says that its crystal runs");
    let first_ms = before
        .first_with_set_ms
        .context("no block had coefficients")?;
    let started_s = line.now().as_secs_f64() - before.uptime_ms as f64 * 1e-3;
    let first_s = started_s + first_ms as f64 * 1e-3;
    ensure!(
        first_s <= latest_s,
        "it sampled with its set at {first_s:.3} s only"
    );
    let begun = line.now();
    line.run_s(1.0)?;
    let after = line.status()?;
    let true_s = (line.now() - begun).as_secs_f64();
    let counted_s = (after.uptime_ms - before.uptime_ms) as f64 * 1e-3;
    let error = counted_s / true_s - 1.0;
    ensure!(
        error.abs() < INTERNAL,
        "its clock is {:.1} % off",
        100.0 * error
    );
    let drive = Drive {
        increment: 1 << 52,
        block: BlockSize::default(),
        settle_blocks: 1,
        blocks: 256,
    };
    let refused = line.ask(&Request::Drive { analyser: 0, drive })?;
    ensure!(
        refused == hexsense_core::wire::Response::Refused(Refusal::NoCrystal),
        "it calibrates: {refused:?}"
    );
    Ok(())
}

/// The crystal dies in a flash operation of an upload: what the board keeps is as before it, or as after it.
fn while_writing(
    bench: &Bench,
    key_holder: &KeyHolder,
    act: &Act,
    operation: u32,
    drift: Option<u64>,
    before: &Account,
) -> anyhow::Result<()> {
    let fault: Value = json!({"flash_operation": operation, "progress": "half", "fault": "crystal", "drift": drift});
    let mut board: Board = bench.on(&[fault])?;
    let line = &mut board.line;
    let uploaded = key_holder.clone().carry_out(line, act);
    ensure!(uploaded.is_err(), "the crystal did not die in the upload");
    let now_s = line.now().as_secs_f64();
    on_internal_oscillator(line, now_s)?;
    ensure!(
        line.identity()?.reset == ResetCause::Crystal,
        "it does not say why it started"
    );
    let found = Account::read(line)?;
    found.audit().map_err(anyhow::Error::msg)?;
    let whole = found == *before || found.log.len() == before.log.len() + 1;
    ensure!(whole, "its account is {found:?} now");
    Ok(())
}
