//! `hexsense log`: every change that the board ever made, and the volumes of its log.

use std::path::PathBuf;

use clap::Args;
use hexsense_client::Client;
use hexsense_core::records::SetId;
use hexsense_core::records::log::Entry;
use serde_json::{Value, json};

use super::arguments::Key;
use super::proven::Proven;
use super::volume;
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

#[cfg(test)]
mod tests {
    use super::*;
    use hexsense_core::records::BuildId;
    use hexsense_core::records::log::Reason;

    const SETS: [SetId; 2] = [SetId([0x0a; 8]), SetId([1, 2, 3, 4, 5, 6, 7, 0xab])];

    /// A new key, two uploads, a fallback and a firmware change, which have no time, and a reset; the fourth change is missing.
    fn entries() -> [Entry; 6] {
        let entry = |counter, reason, unix_s, id: Option<usize>, previous: Option<usize>| Entry {
            counter,
            reason,
            unix_s,
            id: id.map(|set| SETS[set]),
            previous: previous.map(|set| SETS[set]),
            build: BuildId([0xb0 + counter as u8; 8]),
            chain: [counter as u8; 16],
            reset: 0,
            page: 0,
        };
        [
            entry(1, Reason::Provision, 1_780_000_000, None, None),
            entry(2, Reason::Upload, 1_780_000_061, Some(0), None),
            entry(3, Reason::Upload, 1_780_003_600, Some(1), Some(0)),
            entry(5, Reason::Fallback, 99, Some(0), Some(1)),
            entry(6, Reason::FirmwareChange, 98, Some(0), Some(0)),
            entry(7, Reason::FactoryReset, 1_780_086_400, None, Some(0)),
        ]
    }

    #[test]
    fn every_change_has_its_time_kind_and_both_sets_in_their_columns() {
        let expected = "\
change  time                  what           active then       active before     firmware
     1  2026-05-28T20:26:40Z  provision      none              none              b1b1b1b1b1b1b1b1
     2  2026-05-28T20:27:41Z  upload         0a0a0a0a0a0a0a0a  none              b2b2b2b2b2b2b2b2
     3  2026-05-28T21:26:40Z  upload         01020304050607ab  0a0a0a0a0a0a0a0a  b3b3b3b3b3b3b3b3
     5  unknown               fallback       0a0a0a0a0a0a0a0a  01020304050607ab  b5b5b5b5b5b5b5b5
     6  unknown               firmware       0a0a0a0a0a0a0a0a  0a0a0a0a0a0a0a0a  b6b6b6b6b6b6b6b6
     7  2026-05-29T20:26:40Z  factory-reset  none              0a0a0a0a0a0a0a0a  b7b7b7b7b7b7b7b7
";
        assert_eq!(table(&entries()), expected);
    }

    #[test]
    fn the_document_has_every_change_and_every_gap() {
        let entry = |change: u8,
                     utc: Option<(u64, &str)>,
                     what,
                     id: Option<&str>,
                     previous: Option<&str>| {
            json!({
                "change": change,
                "unix_s": utc.map(|utc| utc.0),
                "utc": utc.map(|utc| utc.1),
                "what": what,
                "id": id,
                "previous_id": previous,
                "build": format!("b{change}").repeat(8),
                "chain": format!("0{change}").repeat(16),
            })
        };
        let [first, second] = ["0a0a0a0a0a0a0a0a", "01020304050607ab"].map(Some);
        let expected = json!({
            "entries": [
                entry(1, Some((1_780_000_000, "2026-05-28T20:26:40Z")), "provision", None, None),
                entry(2, Some((1_780_000_061, "2026-05-28T20:27:41Z")), "upload", first, None),
                entry(3, Some((1_780_003_600, "2026-05-28T21:26:40Z")), "upload", second, first),
                entry(5, None, "fallback", first, second),
                entry(6, None, "firmware", first, first),
                entry(7, Some((1_780_086_400, "2026-05-29T20:26:40Z")), "factory-reset", None, first),
            ],
            "flaws": ["one"],
        });
        assert_eq!(to_json(&entries(), &["one".to_owned()]), expected);
    }
}
