//! Never without coefficients, never with half a set: the power is cut at every single flash operation.
//!
//! Each change is carried out once to its end. Then, for every operation of it, the board starts again from the flash as
//! it was before, and the power goes in the middle of that operation, which leaves a torn double word or page, and once
//! more right after it (which is also right before the next). Switched on again, the board must sample, and its account
//! must be that of before the change or of after it. Where the start itself writes, because it finishes what was
//! interrupted, the power goes in the middle of that too.
//!
//! Every account is audited besides: that is the promise `audit`.

use anyhow::ensure;
use serde_json::{Value, json};

use super::bench::{Bench, Board, STARTED};
use super::keeper::{Account, Act, Keeper};
use super::line::is_gone;
use super::outcome::Outcome;
use crate::build::Parts;
use crate::trial_set::Random;

/// How far an operation has got when the power goes.
const FORMS: [&str; 2] = ["half", "done"];

/// How much of it is done.
pub struct Extent {
    /// Uploads, one after another; from the ninth on the history drops a set.
    pub uploads: usize,
    /// One in so many operations; 1 is all.
    pub every: u64,
}

/// Sweeps all changes; the outcomes of `power_cut` and of `audit`.
pub fn sweep(parts: &Parts, seed: u64, extent: &Extent) -> anyhow::Result<[Outcome; 2]> {
    let bench = Bench::new(parts, "power-cut", seed)?;
    let mut board = bench.on(&[])?;
    let mut sweep = Sweep {
        keeper: Keeper::of(&mut board.line)?,
        before: Account::read(&mut board.line)?,
        bench,
        every: extent.every,
        outcome: Outcome::new("power_cut", 100),
        audit: Outcome::new("audit", 100),
    };
    drop(board);
    let mut random = Random(seed as u32 | 1);
    sweep.act(&Act::Provision(sweep.keeper.key.clone()))?;
    for _ in 0..extent.uploads {
        let set = random.set(sweep.keeper.board);
        sweep.act(&Act::Upload(Box::new(set)))?;
    }
    if let Some(oldest) = sweep.before.history.last().map(|kept| kept.id) {
        sweep.act(&Act::Rollback(oldest))?;
        // The oldest is active now, and must not be the one that makes room.
        let set = random.set(sweep.keeper.board);
        sweep.act(&Act::Upload(Box::new(set)))?;
    }
    sweep.act(&Act::FactoryReset)?;
    let set = random.set(sweep.keeper.board);
    sweep.act(&Act::Upload(Box::new(set)))?;
    Ok([sweep.outcome, sweep.audit])
}

/// A sweep under way.
struct Sweep<'a> {
    bench: Bench<'a>,
    keeper: Keeper,
    /// The account before the next change.
    before: Account,
    every: u64,
    outcome: Outcome,
    audit: Outcome,
}

impl Sweep<'_> {
    /// Cuts the power everywhere in one change, then goes on with the flash as it is after it.
    fn act(&mut self, act: &Act) -> anyhow::Result<()> {
        self.bench.keep("before")?;
        let mut board = self.bench.on(&[])?;
        self.keeper.carry_out(&mut board.line, act)?;
        let after = Account::read(&mut board.line)?;
        drop(board);
        self.audit(&after, || act.name().to_owned());
        self.bench.keep("after")?;
        for operation in (1..).step_by(self.every as usize) {
            if !self.operation(act, operation, &after)? {
                break;
            }
        }
        self.bench.restore("after")?;
        self.before = after;
        Ok(())
    }

    /// Cuts the power at one operation of a change, in every form; false if the change has no so many.
    fn operation(&mut self, act: &Act, operation: u64, after: &Account) -> anyhow::Result<bool> {
        for form in FORMS {
            self.bench.restore("before")?;
            if !self.cut(act, operation, form)? {
                return Ok(false);
            }
            let place = || format!("cut {form} in operation {operation} of {}", act.name());
            match self.start_again() {
                Ok(found) => {
                    self.outcome
                        .check(is_one_of(&found, &self.before, after), || {
                            format!("{}: {found:?}", place())
                        });
                    self.audit(&found, place);
                }
                Err(error) => self.outcome.lose(1, || format!("{}: {error:#}", place())),
            }
        }
        Ok(true)
    }

    /// Carries out a change until the power goes at a flash operation; false if it does not.
    fn cut(&mut self, act: &Act, operation: u64, form: &str) -> anyhow::Result<bool> {
        let done = self
            .bench
            .on(&[cut(operation, form)])
            .and_then(|mut board| self.keeper.carry_out(&mut board.line, act));
        match done {
            Ok(()) => Ok(false),
            Err(error) if is_gone(&error) => {
                self.outcome.inject();
                Ok(true)
            }
            Err(error) => Err(error),
        }
    }

    /// Switches the board on, cuts the power if it writes anything, and switches it on for good; its account.
    fn start_again(&mut self) -> anyhow::Result<Account> {
        match self.bench.on(&[cut(1, "half")]).and_then(started) {
            Err(error) if is_gone(&error) => {
                self.outcome.inject();
                started(self.bench.on(&[])?)
            }
            account => account,
        }
    }

    fn audit(&mut self, account: &Account, place: impl FnOnce() -> String) {
        self.audit.inject();
        let found = account.audit();
        self.audit.check(found.is_ok(), || {
            format!("{}: {}", place(), found.unwrap_err())
        });
    }
}

fn cut(operation: u64, form: &str) -> Value {
    json!({"flash_operation": operation, "progress": form, "fault": "power_cut"})
}

/// The account of a board that must sample by now.
fn started(mut board: Board) -> anyhow::Result<Account> {
    let scans = board.line.status()?.scans;
    ensure!(scans > 0, "no scan {STARTED:?} after the start");
    Account::read(&mut board.line)
}

/// Whether an account is that of before or of after; of the history the set that made room may be gone before the new
/// one has come.
fn is_one_of(found: &Account, before: &Account, after: &Account) -> bool {
    let made_room = |before: &Account| {
        let kept = &before.history[..before.history.len().saturating_sub(1)];
        found.history == kept && before.history.len() >= KEPT
    };
    let same = |one: &Account| {
        (found.provisioned, found.active, &found.log) == (one.provisioned, one.active, &one.log)
    };
    found == after || same(before) && (found.history == before.history || made_room(before))
}

/// Sets that the board keeps at least, once it has got so many.
const KEPT: usize = 8;
