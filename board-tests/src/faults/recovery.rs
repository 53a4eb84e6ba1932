//! The board comes back by itself: after any reset it samples with its coefficients within 100 ms, and it reports the cause
//! of the reset.

use std::time::Duration;

use anyhow::Context;
use hexsense_core::wire::status::{ResetCause, Resets};
use serde_json::{Value, json};

use super::outcome::Outcome;
use crate::bench::{Bench, Board};
use crate::key_holder::{Account, calibrate};
use crate::symbols;
use crate::trial_set::Random;

/// Within this time of a reset the board samples with its coefficients.
const LIMIT_S: f64 = 0.1;
/// The watchdog bites within a second, after it is fed at most once more.
const MAX_HANG: Duration = Duration::from_millis(1_250);
/// Exceptions by number: interrupts follow after 16 of the core's own.
const SAMPLE_PATH: u32 = 16 + 11;
const SAMPLING_TASK: u32 = 16 + 82;
const LINK_TASK: u32 = 16 + 83;

/// A way to reset the board.
struct Way {
    name: &'static str,
    fault: Value,
    cause: ResetCause,
    /// The counter that must count it.
    counted: fn(&Resets) -> u32,
    /// What the message of the panic must say.
    says: Option<&'static str>,
}

/// Tasks of thread mode, by a part of the symbols of their memory.
const TASKS: [(&str, &str); 4] = [
    ("pose task that is never woken again", "pose4find4POOL"),
    (
        "harmonics task that is never woken again",
        "harmonics5solve4POOL",
    ),
    (
        "supply task that is never woken again",
        "supply7measure4POOL",
    ),
    (
        "storage task that is never woken again",
        "storage5store4POOL",
    ),
];
/// Where in the head of a task the executor notes that the task is in its queue already. Such a task is not put there.
const IN_QUEUE: (u64, &str) = (24, "0x00000100");

fn ways() -> anyhow::Result<Vec<Way>> {
    let way = |name, fault, cause, counted: fn(&Resets) -> u32| Way {
        name,
        fault,
        cause,
        counted,
        says: None,
    };
    let hang = |name, fault| way(name, fault, ResetCause::Watchdog, |resets| resets.watchdog);
    let panic = |name, fault, says| Way {
        says: Some(says),
        ..way(name, fault, ResetCause::Panic, |resets| resets.panics)
    };
    let mut ways = vec![
        way(
            "pin",
            json!({"fault": "pin_reset"}),
            ResetCause::Pin,
            |resets| resets.pin,
        ),
        way(
            "brown-out",
            json!({"fault": "brown_out", "ram_kept": true}),
            ResetCause::BrownOut,
            |resets| resets.brown_outs,
        ),
        way(
            "brown-out with loss of RAM",
            json!({"fault": "brown_out", "ram_kept": false}),
            ResetCause::PowerOn,
            |resets| resets.starts,
        ),
        hang("dead core", json!({"fault": "hang"})),
        hang(
            "hang of a background task",
            json!({"fault": "hang", "exception": 0}),
        ),
        hang(
            "hang of the link",
            json!({"fault": "hang", "exception": LINK_TASK}),
        ),
        hang(
            "hang of the sampling task",
            json!({"fault": "hang", "exception": SAMPLING_TASK}),
        ),
        hang(
            "hang of the sample path",
            json!({"fault": "hang", "exception": SAMPLE_PATH}),
        ),
        hang(
            "link that waits for its transmitter",
            json!({"fault": "dma_stall", "of": "transmitter", "duration_us": 1_200_000}),
        ),
        panic(
            "jump into nothing",
            json!({"fault": "jump", "address": "0xf0000000"}),
            "hard fault",
        ),
        panic(
            "stack overflow",
            json!({"fault": "stack_pointer", "address": "0x20000008"}),
            "stack overflow",
        ),
    ];
    for (name, symbol) in TASKS {
        let (offset, mask) = IN_QUEUE;
        let address = format!("{:#010x}", symbols::address(symbol)? + offset);
        let fault = json!({"fault": "ram_bits", "address": address, "mask": mask});
        ways.push(hang(name, fault));
    }
    Ok(ways)
}

/// Resets the board `rounds` times in every way, at instants drawn from the seed.
pub fn resets(seed: u64, rounds: u64) -> anyhow::Result<Outcome> {
    let ways = ways()?;
    let mut outcome = Outcome::new("recovery", 100.min(rounds * ways.len() as u64));
    let bench = Bench::new("faults/recovery", seed)?;
    let mut random = Random(seed as u32 | 1);
    let mut board = bench.on(&[])?;
    calibrate(&mut board.line, &mut random)?;
    let account = Account::read(&mut board.line)?;
    drop(board);
    let mut slowest_s: f64 = 0.0;
    for _ in 0..rounds {
        for way in &ways {
            let at_s = 0.5 + 0.1 * f64::from(random.share());
            outcome.inject();
            match reset(&bench, way, at_s, &account) {
                Ok(took_s) => slowest_s = slowest_s.max(took_s),
                Err(error) => outcome.lose(1, || format!("{} at {at_s:.4} s: {error:#}", way.name)),
            }
        }
    }
    outcome.figure("slowest_ms", (slowest_s * 1e3).ceil());
    Ok(outcome)
}

/// Resets the board once; how long it took from the reset to the first block with coefficients, s.
fn reset(bench: &Bench, way: &Way, at_s: f64, account: &Account) -> anyhow::Result<f64> {
    let mut fault = way.fault.clone();
    fault["at_s"] = json!(at_s);
    let mut board = bench.on(&[fault])?;
    board.line.stream_everything()?;
    board
        .line
        .run_until(Duration::from_secs_f64(at_s) + MAX_HANG)?;
    let took_s = first_block_s(bench, &mut board)?;
    anyhow::ensure!(
        took_s <= LIMIT_S,
        "it sampled with coefficients after {took_s:.3} s only"
    );
    let cause = board.line.identity()?.reset;
    anyhow::ensure!(
        cause == way.cause,
        "it says {cause:?} instead of {:?}",
        way.cause
    );
    let status = board.line.status()?;
    anyhow::ensure!(
        (way.counted)(&status.resets) == 1,
        "it counts {:?}",
        status.resets
    );
    let said = status.panic.unwrap_or_default();
    let right = way.says.map_or(said.is_empty(), |says| said.contains(says));
    anyhow::ensure!(right, "it says \"{said}\" instead of {:?}", way.says);
    let found = Account::read(&mut board.line)?;
    anyhow::ensure!(found == *account, "its account is {found:?} now");
    Ok(took_s)
}

/// Time from the reset, which the virtual board logs, to the first block with coefficients, which the firmware reports, s.
fn first_block_s(bench: &Bench, board: &mut Board) -> anyhow::Result<f64> {
    let log = bench.log();
    let line = log.lines().rfind(|line| line.contains("board: reset:"));
    let at = line.and_then(|line| line.strip_prefix('[')?.split_once(']'));
    let (reset_s, _) = at.context("the board was never reset")?;
    let reset_s: f64 = reset_s.trim().parse()?;
    // The reset cut off a frame of the stream, and the first answer is lost with it.
    let status = board.line.status().or_else(|_| board.line.status())?;
    let first_ms = status
        .first_with_set_ms
        .context("no block had coefficients")?;
    let started_s = board.line.now().as_secs_f64() - status.uptime_ms as f64 * 1e-3;
    Ok(started_s - reset_s + first_ms as f64 * 1e-3)
}
