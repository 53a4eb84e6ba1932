//! `hexsense log`: every change that the board ever made.

use std::path::{Path, PathBuf};

use anyhow::{anyhow, ensure};
use clap::Args;
use hexsense_client::Client;
use hexsense_core::records::SetId;
use hexsense_core::records::log::Entry;
use hexsense_core::wire::change::Key;
use hexsense_core::wire::log::Volume;
use serde_json::{Value, json};

use super::confirm::confirm;
use crate::log_file::{LogFile, flaws, name, time, volume_flaws};
use crate::{files, key_file};

/// Print every change of the board's coefficients, key and firmware, oldest first; or export the log, check an export, and
/// begin the log's next volume.
///
/// Each entry has its number, the time by the clock of the computer that made the change, the kind of change, the set that
/// was active after it, the set that was active before, and the build of the firmware. Two kinds come from the board itself
/// and have no time: a fallback, when it could not read the active set any more and the newest readable one took its place,
/// and a firmware change. Each entry carries the hash of the one before, so that an entry that was altered or removed shows.
///
/// A volume takes 3,720 entries. When it is nearly full, `--export FILE --new-volume` writes it with the board's signature
/// into a file and begins the next. Its first entry carries the hash of the last one in the file.
#[derive(Args)]
pub struct Log {
    /// The board's port, as in the other commands
    #[arg(long, value_name = "PORT", required_unless_present = "check")]
    port: Option<String>,
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
    /// File with the board's key
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
}

impl Log {
    /// Runs the command.
    ///
    /// # Errors
    /// A file that does not hold what it claims, an answer that is not yes, and what the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        if let Some(path) = &self.check {
            return check(path, self.key.as_deref());
        }
        let mut client = Client::open(&self.port.unwrap_or_default())?;
        let key = match (&self.key, self.new_volume) {
            (None, false) => None,
            (file, _) => Some(key_file::load(
                file.as_deref().unwrap_or(Path::new(key_file::DEFAULT)),
            )?),
        };
        if let Some(path) = &self.export {
            export(&mut client, path, key.as_ref())?;
        }
        if let Some(key) = key.filter(|_| self.new_volume) {
            return new_volume(&mut client, &key, self.yes || self.export.is_some());
        }
        if self.export.is_some() {
            return Ok(());
        }
        let log = client.log(1)?;
        let flaws = flaws(&log);
        if self.json {
            println!("{}", to_json(&log, &flaws));
            return Ok(());
        }
        if log.is_empty() {
            println!("the log is empty: nothing on this board has ever been changed");
            return Ok(());
        }
        print!("{}", table(&log));
        for flaw in flaws {
            println!("{flaw}");
        }
        Ok(())
    }
}

/// Writes the log's volume into a file, signed by the board.
fn export(client: &mut Client, path: &Path, key: Option<&Key>) -> anyhow::Result<()> {
    let file = path.display();
    ensure!(
        !path.exists(),
        "{file}: is there already, and exports are never overwritten; name another file"
    );
    let mut nonce = [0; 32];
    getrandom::fill(&mut nonce)
        .map_err(|reason| anyhow!("the system gives no random numbers: {reason}"))?;
    let board = client.identity()?.board;
    let (volume, mac) = client.log_proof(nonce)?;
    let mut entries = client.log(1)?;
    entries.retain(|entry| entry.counter <= volume.last);
    let log = LogFile {
        board,
        nonce,
        volume,
        mac,
        entries,
    };
    let flaws = volume_flaws(&log.entries, &volume);
    if let Some(key) = key {
        ensure!(
            log.is_signed(key),
            "the log was not signed with the key in this file; nothing was written"
        );
    }
    log.save(path)?;
    println!(
        "written: {file}, {} entries, changes {} to {} of board {}",
        log.entries.len(),
        volume.first,
        volume.last,
        files::hex(&board)
    );
    for flaw in flaws {
        println!("{flaw}");
    }
    Ok(())
}

/// Begins the next volume.
fn new_volume(client: &mut Client, key: &Key, is_sure: bool) -> anyhow::Result<()> {
    let log = client.log(1)?;
    let last = log
        .last()
        .ok_or_else(|| anyhow!("the log is empty; there is nothing to close"))?;
    if !is_sure {
        eprintln!(
            "the board will overwrite the {} entries up to change {} in time; --export FILE keeps them",
            log.len(),
            last.counter
        );
        confirm(
            "Begin a new volume without an export?",
            "the volume stays open",
        )?;
    }
    client.new_volume(key, last.counter)?;
    println!(
        "change {} begins a new volume of the log and carries the hash of change {}",
        last.counter + 1,
        last.counter
    );
    Ok(())
}

/// Checks a file, and says what that proves.
fn check(path: &Path, key: Option<&Path>) -> anyhow::Result<()> {
    let log = LogFile::load(path)?;
    let file = path.display();
    let flaws = volume_flaws(&log.entries, &log.volume);
    ensure!(flaws.is_empty(), "{file}: {}", flaws.join("; "));
    let Volume { first, last, .. } = log.volume;
    println!(
        "{file}: board {}, changes {first} to {last}; no entry is missing or altered",
        files::hex(&log.board)
    );
    if let Some(first) = log.entries.first().filter(|entry| entry.counter > 1) {
        println!(
            "it continues the volume whose head is {}",
            files::hex(&first.chain)
        );
    }
    println!("its head is {}", files::hex(&log.volume.head));
    match key {
        None => println!(
            "not proven without the key: that the board wrote it. Whoever makes up all entries can compute all hashes; \
             give --key FILE"
        ),
        Some(key) => {
            ensure!(
                log.is_signed(&key_file::load(key)?),
                "{file}: the signature is NOT that of this board with this key: another key was given, or the file is forged"
            );
            println!("proven with the key: the board signed it, or somebody else who has the key");
        }
    }
    Ok(())
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
