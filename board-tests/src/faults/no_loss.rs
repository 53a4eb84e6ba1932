//! No sample is lost while coefficients are written: at 4 kHz all channels stream on through uploads, rollbacks and
//! factory resets, and the sample counter has no gap.

use super::gaps::Gaps;
use super::outcome::Outcome;
use crate::bench::Bench;
use crate::key_holder::{Account, Act, KeyHolder};
use crate::trial_set::Random;

/// One change in so many is a rollback, and one a factory reset.
const ROLLBACK_EVERY: u64 = 3;
const RESET_EVERY: u64 = 25;

/// Makes this number of changes while everything streams.
pub fn stream_through(seed: u64, changes: u64) -> anyhow::Result<Outcome> {
    let mut outcome = Outcome::new("no_loss", 100.min(changes));
    let bench = Bench::new("faults/no-loss", seed)?;
    let mut board = bench.on(&[])?;
    let line = &mut board.line;
    let mut key_holder = KeyHolder::of(line)?;
    key_holder.provision(line)?;
    let mut random = Random(seed as u32 | 1);
    line.stream_everything()?;
    let before = line.status()?;
    let mut gaps = Gaps::default();
    for change in 1..=changes {
        let account = Account::read(line)?;
        let mut oldest_first = account.history.iter().rev().map(|kept| kept.id);
        let another = oldest_first.find(|id| Some(*id) != account.active);
        let act = match another {
            Some(_) if change % RESET_EVERY == 0 => Act::FactoryReset,
            Some(id) if change % ROLLBACK_EVERY == 0 => Act::Rollback(id),
            _ => Act::Upload(Box::new(random.set(key_holder.board))),
        };
        key_holder.carry_out(line, &act)?;
        outcome.inject();
        gaps.follow(line);
    }
    let after = line.status()?;
    let lost = after.scans_lost - before.scans_lost;
    outcome.lose(lost, || format!("the board says that it lost {lost} scans"));
    outcome.lose(gaps.missing + gaps.repeated, || format!("{gaps:?}"));
    let audit = Account::read(line)?.audit();
    outcome.check(audit.is_ok(), || format!("{audit:?}"));
    outcome.figure("scans", gaps.scans);
    outcome.figure("virtual_s", line.now().as_secs());
    Ok(outcome)
}
