//! Never without coefficients, never with half a set: the power is cut at every single flash operation.
//!
//! Each change is carried out once to its end. Then, for every operation of it, the board starts again from the flash as
//! it was before, and the power goes in the middle of that operation, which leaves a torn double word or page, and once
//! more right after it (which is also right before the next). Switched on again, the board must sample, and its account
//! must be that of before the change or of after it. Where the start itself writes, because it finishes what was
//! interrupted, the power goes in the middle of that too.
//!
//! Every account is audited besides: that is the promise `audit`.

use std::sync::{Mutex, PoisonError};

use anyhow::{anyhow, ensure};
use hexsense_core::wire::message::Kept;
use serde_json::{Value, json};

use super::outcome::Outcome;
use crate::bench::{Bench, Board, STARTED};
use crate::key_holder::{Account, Act, KeyHolder};
use crate::line::is_gone;
use crate::trial_set::Random;

/// How far an operation has got when the power goes.
const FORMS: [&str; 2] = ["half", "done"];

/// Changes that are swept at the same time.
const AT_ONCE: usize = 2;

/// How much of it is done.
pub struct Extent {
    /// Uploads, one after another; from the ninth on the history drops a set. The rest of the archive is filled without
    /// cuts.
    pub uploads: usize,
    /// One in so many operations; 1 is all.
    pub every: u64,
    /// How often the power must be cut at least.
    pub minimum: u64,
}

/// Sweeps all changes; the outcomes of `power_cut` and of `audit`.
pub fn sweep(seed: u64, extent: &Extent) -> anyhow::Result<[Outcome; 2]> {
    let changes = Mutex::new(changes(seed, extent.uploads)?);
    let mut found = Vec::new();
    let next = || changes.lock().unwrap_or_else(PoisonError::into_inner).pop();
    std::thread::scope(|scope| {
        let workers = [(); AT_ONCE].map(|()| {
            scope.spawn(|| -> anyhow::Result<Vec<Outcome>> {
                let mut found = Vec::new();
                while let Some(change) = next() {
                    found.extend(Sweep::of(&change)?.all(extent.every)?);
                }
                Ok(found)
            })
        });
        for worker in workers {
            let outcomes = worker.join().map_err(|_| anyhow!("a worker panicked"))?;
            found.extend(outcomes?);
        }
        anyhow::Ok(())
    })?;
    Ok(["power_cut", "audit"].map(|promise| Outcome::of(promise, extent.minimum, &mut found)))
}

/// A change, with the flash as it is before it and the accounts before and after it.
struct Change {
    bench: Bench,
    key_holder: KeyHolder,
    act: Act,
    before: Account,
    after: Account,
}

/// Carries out all kinds of changes, one after another.
fn changes(seed: u64, uploads: usize) -> anyhow::Result<Vec<Change>> {
    let mut series = Series::begin(seed)?;
    let mut random = Random(seed as u32 | 1);
    let board = series.key_holder.board;
    let mut upload = || Act::Upload(Box::new(random.set(board)));
    series.go_on(Act::Provision(series.key_holder.key.clone()))?;
    for _ in 0..uploads {
        series.go_on(upload())?;
    }
    while series.account.history.len() < KEPT {
        series.pass(&upload())?;
    }
    if let Some(oldest) = series.account.history.last().map(|kept| kept.id) {
        series.go_on(Act::Rollback(oldest))?;
        // The oldest is active now, and must not be the one that makes room.
        series.go_on(upload())?;
    }
    let last = series.account.log.last().map_or(0, |last| last.counter);
    series.go_on(Act::NewVolume(last))?;
    series.go_on(Act::FactoryReset)?;
    series.go_on(upload())?;
    Ok(series.changes)
}

/// Changes of one board.
struct Series {
    bench: Bench,
    key_holder: KeyHolder,
    account: Account,
    changes: Vec<Change>,
}

impl Series {
    fn begin(seed: u64) -> anyhow::Result<Self> {
        let bench = Bench::new("faults/power-cut", seed)?;
        let mut board = bench.on(&[])?;
        let key_holder = KeyHolder::of(&mut board.line)?;
        let account = Account::read(&mut board.line)?;
        drop(board);
        Ok(Self {
            bench,
            key_holder,
            account,
            changes: Vec::new(),
        })
    }

    fn go_on(&mut self, act: Act) -> anyhow::Result<()> {
        let name = format!("faults/power-cut-{:02}", self.changes.len());
        let (bench, key_holder) = (self.bench.copy(&name)?, self.key_holder.clone());
        let before = self.account.clone();
        self.pass(&act)?;
        self.changes.push(Change {
            bench,
            key_holder,
            act,
            before,
            after: self.account.clone(),
        });
        Ok(())
    }

    /// A change that is carried out, and in which the power is not cut.
    fn pass(&mut self, act: &Act) -> anyhow::Result<()> {
        let mut board = self.bench.on(&[])?;
        self.key_holder.carry_out(&mut board.line, act)?;
        self.account = Account::read(&mut board.line)?;
        Ok(())
    }
}

/// Cuts the power everywhere in one change.
struct Sweep<'a> {
    change: &'a Change,
    outcome: Outcome,
    audit: Outcome,
}

impl<'a> Sweep<'a> {
    fn of(change: &'a Change) -> anyhow::Result<Self> {
        change.bench.keep("before")?;
        Ok(Self {
            change,
            outcome: Outcome::new("power_cut", 0),
            audit: Outcome::new("audit", 0),
        })
    }

    /// One in `every` operations.
    fn all(mut self, every: u64) -> anyhow::Result<[Outcome; 2]> {
        for operation in (1..).step_by(every as usize) {
            if !self.operation(operation)? {
                break;
            }
        }
        Ok([self.outcome, self.audit])
    }

    /// Cuts the power at one operation, in every form; false if the change has no so many.
    fn operation(&mut self, operation: u64) -> anyhow::Result<bool> {
        let Change { before, after, .. } = self.change;
        for form in FORMS {
            self.change.bench.restore("before")?;
            if !self.cut(operation, form)? {
                return Ok(false);
            }
            let act = self.change.act.name();
            let place = || format!("cut {form} in operation {operation} of {act}");
            match self.start_again() {
                Ok(found) => {
                    self.outcome.check(is_one_of(&found, before, after), || {
                        format!("{}: {found:?}", place())
                    });
                    self.audit(&found, place);
                }
                Err(error) => self.outcome.lose(1, || format!("{}: {error:#}", place())),
            }
        }
        Ok(true)
    }

    /// Carries out the change until the power goes at a flash operation; false if it does not.
    fn cut(&mut self, operation: u64, form: &str) -> anyhow::Result<bool> {
        let Change { bench, act, .. } = self.change;
        let mut key_holder = self.change.key_holder.clone();
        let done = bench
            .on(&[cut(operation, form)])
            .and_then(|mut board| key_holder.carry_out(&mut board.line, act));
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
        let bench = &self.change.bench;
        match bench.on(&[cut(1, "half")]).and_then(started) {
            Err(error) if is_gone(&error) => {
                self.outcome.inject();
                started(bench.on(&[])?)
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

/// Whether an account is that of before or of after; of the history the set that made room, the oldest but for the
/// active one, may be gone before the new one has come.
fn is_one_of(found: &Account, before: &Account, after: &Account) -> bool {
    let made_room = |before: &Account| {
        let is_oldest = |kept: &Kept| Some(kept.id) != before.active;
        let oldest = before.history.iter().rposition(is_oldest);
        let mut kept = before.history.clone();
        if let Some(oldest) = oldest {
            kept.remove(oldest);
        }
        found.history == kept && before.history.len() >= KEPT
    };
    let same = |one: &Account| {
        (found.provisioned, found.active, &found.log) == (one.provisioned, one.active, &one.log)
    };
    found == after || same(before) && (found.history == before.history || made_room(before))
}

/// Sets that the board keeps at least, once it has got so many.
const KEPT: usize = 8;
