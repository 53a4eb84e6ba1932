//! The generator of random numbers fails: the board measures on and refuses challenges only, and when the generator comes
//! back, so do the changes.

use std::time::Duration;

use anyhow::{bail, ensure};
use hexsense_core::wire::{Refusal, Request, Response};
use serde_json::{Value, json};

use super::outcome::Outcome;
use crate::bench::{Bench, Board};
use crate::key_holder::{Account, Act, KeyHolder, calibrate};
use crate::line::Line;
use crate::trial_set::Random;

const DEFECTS: [&str; 5] = ["not_ready", "zeros", "same_word", "seed", "clock"];
/// Within this time of its start a board samples with its set, ms.
const STARTED_MS: u64 = 100;
/// A board without challenges is looked at for so long: a watchdog would have bitten.
const LOOK: Duration = Duration::from_millis(1_500);
/// A challenge is given or refused within this time.
const ANSWER: Duration = Duration::from_millis(20);
/// A defect that passes lasts so long, µs; a change is tried until so long after it.
const PASSES_US: u64 = 150_000;
const PATIENCE: Duration = Duration::from_millis(500);
/// From one try to the next.
const PAUSE: Duration = Duration::from_millis(3);

/// Breaks the generator for good in every way, then for a while in every way at `times` drawn instants of a first
/// provisioning and upload.
pub fn break_down(seed: u64, times: u64) -> anyhow::Result<Outcome> {
    let for_good = DEFECTS.len() as u64 + 1;
    let minimum = for_good + times * DEFECTS.len() as u64;
    let mut outcome = Outcome::new("random", minimum);
    let mut random = Random(seed as u32 | 1);
    let bench = Bench::new("faults/random", seed)?;
    bench.keep("erased")?;
    calibrate(&mut bench.on(&[])?.line, &mut random)?;
    let defects = DEFECTS.map(
        |defect| json!({"fault": "random", "defect": defect, "duration_us": 100_000_000, "at_s": 0}),
    );
    for fault in defects
        .into_iter()
        .chain([json!({"fault": "hsi48", "at_s": 0})])
    {
        outcome.inject();
        let done = without(&bench, &fault);
        outcome.settle(done.map_err(|error| error.context(fault.to_string())));
    }
    for _ in 0..times {
        for defect in DEFECTS {
            // Key and set take the first third of a second.
            let at_s = 0.1 + 0.15 * f64::from(1.0 + random.share());
            let fault = json!({"fault": "random", "defect": defect, "duration_us": PASSES_US, "at_s": at_s});
            bench.restore("erased")?;
            outcome.inject();
            let done = meanwhile(&bench, &fault, &mut random);
            outcome.settle(done.map_err(|error| error.context(fault.to_string())));
        }
    }
    Ok(outcome)
}

/// A board whose generator never works.
fn without(bench: &Bench, fault: &Value) -> anyhow::Result<()> {
    let mut board = bench.on(std::slice::from_ref(fault))?;
    let line = &mut board.line;
    let before = line.status()?;
    let started = before.first_with_set_ms.is_some_and(|ms| ms <= STARTED_MS);
    ensure!(started, "first values at {:?} ms", before.first_with_set_ms);
    let asked = line.now();
    for _ in 0..3 {
        let answer = line.ask(&Request::Challenge)?;
        let refused = matches!(answer, Response::Refused(Refusal::Random));
        ensure!(refused, "a challenge was answered by {answer:?}");
    }
    let took = line.now() - asked;
    ensure!(took < 3 * ANSWER, "three refusals took {took:?}");
    ensure!(Account::read(line)?.active.is_some(), "its set is gone");
    line.run(LOOK)?;
    whole(line)
}

/// A board whose generator fails while it gets its key and its first set.
fn meanwhile(bench: &Bench, fault: &Value, random: &mut Random) -> anyhow::Result<()> {
    let mut board: Board = bench.on(std::slice::from_ref(fault))?;
    let line = &mut board.line;
    let mut key_holder = KeyHolder::of(line)?;
    let set = random.set(key_holder.board);
    let until = line.now() + Duration::from_micros(PASSES_US) + PATIENCE;
    for act in [
        Act::Provision(key_holder.key.clone()),
        Act::Upload(Box::new(set)),
        Act::Upload(Box::new(random.set(key_holder.board))),
    ] {
        while let Err(error) = key_holder.carry_out(line, &act) {
            // Only a challenge may fail, and only for this reason.
            let refused = format!("no challenge but {:?}", Response::Refused(Refusal::Random));
            if error.to_string() != refused || line.now() > until {
                bail!("{}: {error:#}", act.name());
            }
            line.run(PAUSE)?;
        }
    }
    let account = Account::read(line)?;
    account.audit().map_err(anyhow::Error::msg)?;
    ensure!(account.log.len() == 3, "{:?}", account.log);
    whole(line)
}

/// Sampled without a loss, in one life.
fn whole(line: &mut Line) -> anyhow::Result<()> {
    let status = line.status()?;
    ensure!(status.resets.starts == 1, "{:?}", status.resets);
    ensure!(status.scans_lost == 0, "{} scans lost", status.scans_lost);
    let due = line.now().as_secs_f64() * 1_000.0;
    let scans = status.scans as f64;
    ensure!(
        (due - 120.0..due).contains(&scans),
        "{scans} scans instead of {due}"
    );
    Ok(())
}
