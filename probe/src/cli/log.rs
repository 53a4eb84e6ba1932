//! `hexsense log`: every change that the board ever made.

use std::ops::Range;

use clap::Args;
use hexsense_core::records::SetId;
use hexsense_core::records::log::{Entry, Reason};
use serde_json::{Value, json};

use super::arguments::Port;
use crate::date::utc;

/// Print every change of the board's coefficients and key, oldest first.
///
/// Each entry has its number, the time by the clock of the computer that made the change, the kind of change, the set that
/// was active after it and the set that was active before. A fallback is a change that the board makes by itself at a
/// start: it could not read the active set any more, and the newest set that it could read took its place. The board
/// appends an entry with every change and never erases an entry; when the numbers have no gap, no entry is missing.
#[derive(Args)]
pub struct Log {
    #[command(flatten)]
    port: Port,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Log {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        let log = self.port.open()?.log(1)?;
        let missing = missing(&log);
        if self.json {
            println!("{}", to_json(&log, &missing));
            return Ok(());
        }
        if log.is_empty() {
            println!("the log is empty: nothing on this board has ever been changed");
            return Ok(());
        }
        print!("{}", table(&log));
        for Range { start, end } in missing {
            let last = end - 1;
            println!(
                "changes {start} to {last} ARE MISSING: the flash does not give their entries back any more"
            );
        }
        Ok(())
    }
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
}
