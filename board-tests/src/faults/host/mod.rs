//! The host withstands boards that lie and files that are hostile: each command ends in bounded time and memory, with what
//! was asked for or with an error that says what is wrong, without a panic, and it prints nothing that a terminal obeys.
//!
//! - [`boards`]: what boards say; [`server`] puts each behind a socket.
//! - [`files`]: what lies in files, and what becomes of the output.
//! - [`command`]: a command of `hexsense` with its time and memory.

mod boards;
mod command;
mod files;
mod server;

use std::time::Duration;

use self::command::{Ended, MOST_TIME};
use super::outcome::Outcome;
use crate::folders;

/// Most memory of a command, KiB: it takes 12,000 to do its work, and a file of settings may add some.
const MOST_KIB: u64 = 65_536;

/// Tries every lie and every file; boards that never end what they say do so for `flood_s` seconds.
pub fn attack(flood_s: u64) -> anyhow::Result<Outcome> {
    let boards = boards::all(flood_s);
    let files = files::all();
    let mut account = Account {
        outcome: Outcome::new("host", (boards.len() + files.len()) as u64),
        slowest: Duration::ZERO,
        peak_kib: 0,
    };
    for (number, lie) in boards.into_iter().enumerate() {
        let folder = folders::emptied(&format!("faults/host/board-{number}"))?;
        let (arguments, told) = (lie.arguments.clone(), lie.told);
        let ended = server::answer_with(lie, &folder)?;
        account.judge(&arguments.join(" "), told, &ended);
    }
    for (number, file) in files.into_iter().enumerate() {
        let folder = folders::emptied(&format!("faults/host/file-{number}"))?;
        match (file.carry_out)(&folder) {
            Ok(ended) => account.judge(file.name, file.told, &ended),
            Err(error) => account.outcome.settle(Err(error.context(file.name))),
        }
    }
    let Account {
        mut outcome,
        slowest,
        peak_kib,
    } = account;
    outcome.figure("slowest_s", slowest.as_secs_f64());
    outcome.figure("peak_kib", peak_kib);
    Ok(outcome)
}

struct Account {
    outcome: Outcome,
    slowest: Duration,
    peak_kib: u64,
}

impl Account {
    /// Judges how one command ended; `told` must be among what it said.
    fn judge(&mut self, what: &str, told: &str, ended: &Ended) {
        self.outcome.inject();
        self.slowest = self.slowest.max(ended.took);
        self.peak_kib = self.peak_kib.max(ended.peak_kib);
        let said = &ended.said;
        let obeyed = |letter: char| letter.is_control() && !matches!(letter, '\n' | '\t');
        for (held, promise) in [
            (matches!(ended.code, Some(0..=100)), "it ends by itself"),
            (!said.contains("panicked"), "it does not panic"),
            (ended.took < MOST_TIME, "it ends in time"),
            (ended.peak_kib < MOST_KIB, "its memory is bounded"),
            (!said.contains(obeyed), "it prints no control character"),
            (said.contains(told), "it says what is wrong"),
        ] {
            self.outcome.check(held, || {
                let head: String = said.chars().take(400).collect();
                format!(
                    "{what}: not true that {promise} ({told:?}): status {:?}, {:.1} s, {} KiB, {head:?}",
                    ended.code,
                    ended.took.as_secs_f64(),
                    ended.peak_kib
                )
            });
        }
    }
}
