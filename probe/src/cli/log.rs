//! `hexsense log`: every change that the board ever made, and the volumes of its log.

#[cfg(test)]
mod tests;
mod volume;

use std::path::PathBuf;

use clap::Args;
use hexsense_client::Client;
use hexsense_core::records::SetId;
use hexsense_core::records::log::Entry;
use serde_json::{Value, json};

use super::arguments::Key;
use super::proven::Proven;
use crate::key_file::KeyFileError;
use crate::log_file::{flaws, name, time};
use crate::{files, terminal};

/// Print every change of the board's coefficients, key and firmware, oldest first; or export the log, check an export, and
/// begin the log's next volume.
///
/// Each entry has its number, the time by the clock of the computer that made the change, the kind of change, the set that
/// was active after it, the set that was active before, and the build of the firmware. Two kinds come from the board itself
/// and have no time: a fallback, when it could not read the active set any more and the newest readable one took its place,
/// and a firmware change. Each entry carries the hash of the one before, so that an entry that was altered or removed shows.
/// With its key at hand the board proves that it is the board, and how many changes it has.
///
/// A volume takes 3,720 entries. When it is nearly full, `--export FILE --new-volume` writes it with the board's signature
/// into a file and begins the next. Its first entry carries the hash of the last one in the file.
#[derive(Args)]
pub struct Log {
    /// The board's port, as in the other commands
    #[arg(long, value_name = "PORT", required_unless_present = "check")]
    port: Option<String>,
    #[command(flatten)]
    key: Key,
    /// Print one JSON document
    #[arg(long, conflicts_with_all = ["check", "export", "new_volume"])]
    json: bool,
    /// Write the volume into this file, signed by the board
    #[arg(long, value_name = "FILE")]
    export: Option<PathBuf>,
    /// Close the volume and begin the next; needs the board's key. Without --export it asks first
    #[arg(long)]
    new_volume: bool,
    /// Begin a new volume without asking
    #[arg(long, requires = "new_volume")]
    yes: bool,
    /// Check a file that --export wrote; no board is needed. With --key also the board's signature
    #[arg(long, value_name = "FILE", conflicts_with_all = ["port", "export", "new_volume"])]
    check: Option<PathBuf>,
}

impl Log {
    /// Runs the command.
    ///
    /// # Errors
    /// A file that does not hold what it claims, an answer that is not yes, what the link reports, and a board that does not
    /// have the key at hand.
    pub fn run(self) -> anyhow::Result<()> {
        if let Some(path) = &self.check {
            return volume::check(path, self.key.named.as_deref());
        }
        let mut client = Client::open(self.port.as_deref().unwrap_or_default())?;
        if self.export.is_none() && !self.new_volume {
            let proven = Proven::of(&mut client, &self.key)?;
            terminal::print(&text(&mut client, self.json, &proven)?)?;
            return proven.check();
        }
        let key = match self.key.load(&client.identity()?.board) {
            Err(KeyFileError::Missing { .. }) if self.key.named.is_none() && !self.new_volume => {
                None
            }
            loaded => Some(loaded?),
        };
        if let Some(path) = &self.export {
            volume::export(&mut client, path, key.as_ref())?;
        }
        match key.filter(|_| self.new_volume) {
            Some(key) => volume::begin(&mut client, &key, self.yes || self.export.is_some()),
            None => Ok(()),
        }
    }
}

/// What the command prints of a board.
///
/// # Errors
/// What the link reports, and a log that does not end with the change that the board proves.
pub fn text(client: &mut Client, json: bool, proven: &Proven) -> anyhow::Result<String> {
    let log = client.log(1)?;
    proven.check_changes(log.last().map_or(0, |entry| entry.counter))?;
    let flaws = flaws(&log);
    if json {
        let mut document = to_json(&log, &flaws);
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
    for flaw in flaws {
        text += &flaw;
        text.push('\n');
    }
    Ok(text + &proof + "\n")
}

fn table(log: &[Entry]) -> String {
    let mut text = format!(
        "{:>6}  {:<20}  {:<13}  {:<16}  {:<16}  firmware\n",
        "change", "time", "what", "active then", "active before"
    );
    for entry in log {
        text += &format!(
            "{:>6}  {:<20}  {:<13}  {:<16}  {:<16}  {}\n",
            entry.counter,
            time(entry).unwrap_or_else(|| "unknown".to_owned()),
            name(entry.reason),
            id(entry.id),
            id(entry.previous),
            entry.build
        );
    }
    text
}

fn id(set: Option<SetId>) -> String {
    set.map_or_else(|| "none".to_owned(), |id| id.to_string())
}

fn to_json(log: &[Entry], flaws: &[String]) -> Value {
    let entries = log.iter().map(|entry| {
        json!({
            "change": entry.counter,
            "unix_s": time(entry).map(|_| entry.unix_s),
            "utc": time(entry),
            "what": name(entry.reason),
            "id": entry.id.map(|id| id.to_string()),
            "previous_id": entry.previous.map(|id| id.to_string()),
            "build": entry.build.to_string(),
            "chain": files::hex(&entry.chain),
        })
    });
    json!({"entries": entries.collect::<Vec<_>>(), "flaws": flaws})
}
