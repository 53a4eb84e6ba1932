//! Never without coefficients, never with half a set: the power is cut at every single flash operation.
//!
//! Each change is carried out once to its end. Then, for every operation of it, the board starts again from the flash as
//! it was before, and the power goes in the middle of that operation, which leaves a torn double word or page, and once
//! more right after it (which is also right before the next). Switched on again, the board must sample, and give
//! exactly the account of before the change or of after it. Where the start itself writes, because it finishes what was
//! interrupted, the power goes in the middle of that too.

use serde_json::{Value, json};

use super::bench::{Bench, Board, STARTED};
use super::keeper::{Account, Act};
use super::line::is_gone;
use super::outcome::Outcome;
use crate::build::Parts;
use crate::trial_set::Random;

/// How far an operation has got when the power goes.
const FORMS: [&str; 2] = ["half", "done"];

/// How much of it is done.
pub struct Extent {
    /// Uploads, one after another.
    pub uploads: usize,
    /// One in so many operations; 1 is all.
    pub every: u64,
}

/// Sweeps all changes.
pub fn sweep(parts: &Parts, seed: u64, extent: &Extent) -> anyhow::Result<Outcome> {
    let mut outcome = Outcome::new("power_cut", 100);
    let bench = Bench::new(parts, "power-cut", seed)?;
    let mut board = bench.on(&[])?;
    let unique_id = board.line.identity()?.board;
    let mut before = Account::read(&mut board.line)?;
    drop(board);
    let mut random = Random(seed as u32 | 1);
    for _ in 0..extent.uploads {
        let act = Act::Upload(Box::new(random.set(unique_id)));
        before = sweep_act(&bench, &act, before, extent.every, &mut outcome)?;
    }
    outcome.figure("forms", json!(FORMS));
    Ok(outcome)
}

/// Cuts the power everywhere in one change, then carries it out; the account after it.
fn sweep_act(
    bench: &Bench,
    act: &Act,
    before: Account,
    every: u64,
    outcome: &mut Outcome,
) -> anyhow::Result<Account> {
    bench.keep("before")?;
    let mut board = bench.on(&[])?;
    act.carry_out(&mut board.line)?;
    let after = Account::read(&mut board.line)?;
    drop(board);
    bench.keep("after")?;
    for operation in (1..).step_by(every as usize) {
        let mut cut = false;
        for form in FORMS {
            bench.restore("before")?;
            cut = cut_at(bench, act, operation, form)?;
            if !cut {
                break;
            }
            outcome.inject();
            let place = || format!("cut {form} in operation {operation} of {act:?}");
            match start_again(bench, outcome) {
                Ok(found) => outcome.check(found == before || found == after, || {
                    format!("{}: {found:?}", place())
                }),
                Err(error) => outcome.lose(1, || format!("{}: {error:#}", place())),
            }
        }
        if !cut {
            break;
        }
    }
    bench.restore("after")?;
    Ok(after)
}

/// Carries out a change until the power goes at a flash operation; false if the change has no so many.
fn cut_at(bench: &Bench, act: &Act, operation: u64, form: &str) -> anyhow::Result<bool> {
    let done = bench
        .on(&[cut(operation, form)])
        .and_then(|mut board| act.carry_out(&mut board.line));
    match done {
        Ok(()) => Ok(false),
        Err(error) if is_gone(&error) => Ok(true),
        Err(error) => Err(error),
    }
}

fn cut(operation: u64, form: &str) -> Value {
    json!({"flash_operation": operation, "progress": form, "fault": "power_cut"})
}

/// Switches the board on, cuts the power if it writes anything, and switches it on for good; its account.
fn start_again(bench: &Bench, outcome: &mut Outcome) -> anyhow::Result<Account> {
    match bench.on(&[cut(1, "half")]).and_then(started) {
        Err(error) if is_gone(&error) => {
            outcome.inject();
            started(bench.on(&[])?)
        }
        account => account,
    }
}

/// The account of a board that must sample by now.
fn started(mut board: Board) -> anyhow::Result<Account> {
    let scans = board.line.status()?.scans;
    anyhow::ensure!(scans > 0, "no scan {STARTED:?} after the start");
    Account::read(&mut board.line)
}
