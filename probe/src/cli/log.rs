//! `hexsense log`: every change that the board ever made.

use std::ops::Range;

use clap::Args;
use hexsense_core::records::SetId;
use hexsense_core::records::log::{Entry, Reason};
use serde_json::{Value, json};

use super::arguments::{Key, Port};
use super::proven::Proven;
use crate::date::utc;
use crate::terminal;
use hexsense_client::Client;

/// Print every change of the board's coefficients and key, oldest first.
///
/// Each entry has its number, the time by the clock of the computer that made the change, the kind of change, the set that
/// was active after it and the set that was active before. A fallback is a change that the board makes by itself at a
/// start: it could not read the active set any more, and the newest set that it could read took its place. The board
/// appends an entry with every change and never erases an entry; when the numbers have no gap, no entry is missing. With its
/// key at hand the board proves that it is the board, and how many changes it has.
#[derive(Args)]
pub struct Log {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    key: Key,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Log {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports, and a board that does not have the key at hand.
    pub fn run(self) -> anyhow::Result<()> {
        let mut client = self.port.open()?;
        let proven = Proven::of(&mut client, &self.key)?;
        terminal::print(&text(&mut client, self.json, &proven)?)?;
        proven.check()
    }
}

/// What the command prints of a board.
///
/// # Errors
/// What the link reports, and a log that does not end with the change that the board proves.
pub fn text(client: &mut Client, json: bool, proven: &Proven) -> anyhow::Result<String> {
    let log = client.log(1)?;
    proven.check_changes(log.last().map_or(0, |entry| entry.counter))?;
    let missing = missing(&log);
    if json {
        let mut document = to_json(&log, &missing);
        document["proven"] = proven.is_proven().into();
        return Ok(format!("{document}\n"));
    }
    let proof = proven.line();
    if log.is_empty() {
        return Ok(format!(
            "the log is empty: nothing on this board has ever been changed\n{proof}\n"
        ));
    }
    let mut text = table(&log);
    for Range { start, end } in missing {
        let last = end - 1;
        text += &format!(
            "changes {start} to {last} ARE MISSING: the flash does not give their entries back any more\n"
        );
    }
    Ok(text + &proof + "\n")
}

fn table(log: &[Entry]) -> String {
    let mut text = format!(
        "{:>6}  {:<20}  {:<13}  {:<16}  active before\n",
        "change", "time", "what", "active then"
    );
    for entry in log {
        text += &format!(
            "{:>6}  {:<20}  {:<13}  {:<16}  {}\n",
            entry.counter,
            time(entry).unwrap_or_else(|| "unknown".to_owned()),
            name(entry.reason),
            id(entry.id),
            id(entry.previous)
        );
    }
    text
}

/// The time of a change; a change that the board made by itself has no time.
fn time(entry: &Entry) -> Option<String> {
    (entry.reason != Reason::Fallback).then(|| utc(entry.unix_s))
}

fn id(set: Option<SetId>) -> String {
    set.map_or_else(|| "none".to_owned(), |id| id.to_string())
}

/// The numbers below the last one that are missing.
fn missing(log: &[Entry]) -> Vec<Range<u32>> {
    let before = log.iter().map(|entry| entry.counter);
    let before = std::iter::once(0).chain(before);
    let gaps = before.zip(log).map(|(last, next)| last + 1..next.counter);
    gaps.filter(|gap| !gap.is_empty()).collect()
}

fn name(reason: Reason) -> &'static str {
    match reason {
        Reason::Upload => "upload",
        Reason::Rollback => "rollback",
        Reason::FactoryReset => "factory-reset",
        Reason::Provision => "provision",
        Reason::Fallback => "fallback",
    }
}

fn to_json(log: &[Entry], missing: &[Range<u32>]) -> Value {
    let entries = log.iter().map(|entry| {
        json!({
            "change": entry.counter,
            "unix_s": time(entry).map(|_| entry.unix_s),
            "utc": time(entry),
            "what": name(entry.reason),
            "id": entry.id.map(|id| id.to_string()),
            "previous_id": entry.previous.map(|id| id.to_string()),
        })
    });
    let missing = missing.iter().map(|gap| [gap.start, gap.end - 1]);
    json!({"entries": entries.collect::<Vec<_>>(), "missing": missing.collect::<Vec<_>>()})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_in_the_numbers_is_told() {
        let entry = |counter| Entry {
            counter,
            reason: Reason::Provision,
            unix_s: 0,
            id: None,
            previous: None,
        };
        assert_eq!(missing(&[]), []);
        assert_eq!(missing(&[1, 2, 3].map(entry)), []);
        assert_eq!(missing(&[2, 3, 6].map(entry)), [1..2, 4..6]);
    }

    const SETS: [SetId; 2] = [SetId([0x0a; 8]), SetId([1, 2, 3, 4, 5, 6, 7, 0xab])];

    /// A new key, two uploads, a fallback that has no time, and a reset; the fourth change is missing.
    fn entries() -> [Entry; 5] {
        let entry = |counter, reason, unix_s, id: Option<usize>, previous: Option<usize>| Entry {
            counter,
            reason,
            unix_s,
            id: id.map(|set| SETS[set]),
            previous: previous.map(|set| SETS[set]),
        };
        [
            entry(1, Reason::Provision, 1_780_000_000, None, None),
            entry(2, Reason::Upload, 1_780_000_061, Some(0), None),
            entry(3, Reason::Upload, 1_780_003_600, Some(1), Some(0)),
            entry(5, Reason::Fallback, 99, Some(0), Some(1)),
            entry(6, Reason::FactoryReset, 1_780_086_400, None, Some(0)),
        ]
    }

    #[test]
    fn every_change_has_its_time_kind_and_both_sets_in_their_columns() {
        let expected = "\
change  time                  what           active then       active before
     1  2026-05-28T20:26:40Z  provision      none              none
     2  2026-05-28T20:27:41Z  upload         0a0a0a0a0a0a0a0a  none
     3  2026-05-28T21:26:40Z  upload         01020304050607ab  0a0a0a0a0a0a0a0a
     5  unknown               fallback       0a0a0a0a0a0a0a0a  01020304050607ab
     6  2026-05-29T20:26:40Z  factory-reset  none              0a0a0a0a0a0a0a0a
";
        assert_eq!(table(&entries()), expected);
    }

    #[test]
    fn the_document_has_every_change_and_every_gap() {
        let entry =
            |change, utc: Option<(u64, &str)>, what, id: Option<&str>, previous: Option<&str>| {
                json!({
                    "change": change,
                    "unix_s": utc.map(|utc| utc.0),
                    "utc": utc.map(|utc| utc.1),
                    "what": what,
                    "id": id,
                    "previous_id": previous,
                })
            };
        let [first, second] = ["0a0a0a0a0a0a0a0a", "01020304050607ab"].map(Some);
        let expected = json!({
            "entries": [
                entry(1, Some((1_780_000_000, "2026-05-28T20:26:40Z")), "provision", None, None),
                entry(2, Some((1_780_000_061, "2026-05-28T20:27:41Z")), "upload", first, None),
                entry(3, Some((1_780_003_600, "2026-05-28T21:26:40Z")), "upload", second, first),
                entry(5, None, "fallback", first, second),
                entry(6, Some((1_780_086_400, "2026-05-29T20:26:40Z")), "factory-reset", None, first),
            ],
            "missing": [[4, 4]],
        });
        assert_eq!(to_json(&entries(), &missing(&entries())), expected);
    }
}
