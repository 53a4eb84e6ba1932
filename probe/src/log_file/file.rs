//! The whole file, to and from a volume.

use std::path::Path;

use hexsense_core::authority::log_mac;
use hexsense_core::records::{BuildId, Entry};
use hexsense_core::wire::change::{Key, Tag};
use hexsense_core::wire::log::{Nonce, Volume};
use serde::Deserialize;

use super::line::{Line, digits};
use crate::files::{self, FileError, hex};

/// Kind and version of the file.
pub const FORMAT: &str = "hexsense log, version 1";

/// The whole file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    format: String,
    board: String,
    first_change: u32,
    last_change: u32,
    head: String,
    build: String,
    nonce: String,
    mac: String,
    entries: Vec<Line>,
}

/// A volume of the log, signed.
#[derive(Debug, Clone, PartialEq)]
pub struct LogFile {
    /// Unique id of the board.
    pub board: [u8; 12],
    /// The host's number that was signed with it.
    pub nonce: Nonce,
    /// What was signed.
    pub volume: Volume,
    /// The signature.
    pub mac: Tag,
    /// The entries.
    pub entries: Vec<Entry>,
}

impl LogFile {
    /// Whether the board, or somebody else with its key, signed this volume.
    #[must_use]
    pub fn is_signed(&self, key: &Key) -> bool {
        log_mac(key, &self.nonce, &self.board, &self.volume) == self.mac
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn save(&self, path: &Path) -> Result<(), FileError> {
        files::replace(path, &self.to_text())
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`FileError`], also for a file that says the same in other characters than hexsense: what people read in it must
    /// be what is checked.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        Self::parse(&path.display().to_string(), &files::read(path, files::LOG)?)
    }

    /// Reads `text`, which came from `file`.
    ///
    /// # Errors
    /// Those of [`LogFile::load`].
    pub fn parse(file: &str, text: &str) -> Result<Self, FileError> {
        let found = read(file, text)?;
        let own = found.to_text();
        let differs = |(own, line): (&str, &str)| own != line;
        let line = own.lines().zip(text.lines()).position(differs);
        if own != text {
            return Err(FileError::Line {
                file: file.to_owned(),
                line: line.unwrap_or(own.lines().count()) + 1,
                problem: "is not as hexsense writes it; the file was edited or damaged".to_owned(),
            });
        }
        Ok(found)
    }

    fn to_text(&self) -> String {
        let volume = &self.volume;
        let (first, last) = (volume.first.to_string(), volume.last.to_string());
        let quoted = |text: &str| format!("\"{text}\"");
        let head = [
            ("format", quoted(FORMAT)),
            ("board", quoted(&hex(&self.board))),
            ("first_change", first),
            ("last_change", last),
            ("head", quoted(&hex(&volume.head))),
            ("build", quoted(&hex(&volume.build.0))),
            ("nonce", quoted(&hex(&self.nonce))),
            ("mac", quoted(&hex(&self.mac))),
        ];
        let head: String = head
            .iter()
            .map(|(key, value)| format!("\"{key}\": {value},\n"))
            .collect();
        let lines: Vec<String> = self
            .entries
            .iter()
            .map(|entry| {
                serde_json::to_string(&Line::of(entry)).expect("an entry is of strings and numbers")
            })
            .collect();
        format!("{{\n{head}\"entries\": [\n{}\n]\n}}\n", lines.join(",\n"))
    }
}

/// The volume in a file.
fn read(file: &str, text: &str) -> Result<LogFile, FileError> {
    let keys: Keys = serde_json::from_str(text).map_err(|error| FileError::Syntax {
        file: file.to_owned(),
        problem: format!("is not a log that `hexsense log --export` wrote: {error}"),
    })?;
    if keys.format != FORMAT {
        let limit = format!("this hexsense reads \"{FORMAT}\"");
        return Err(FileError::value(file, "format", keys.format, limit));
    }
    let entries = keys.entries.iter().enumerate();
    let entries = entries.map(|(index, line)| line.entry(&format!("{file}, entry {}", index + 1)));
    Ok(LogFile {
        board: digits(file, "board", &keys.board)?,
        nonce: digits(file, "nonce", &keys.nonce)?,
        volume: Volume {
            first: keys.first_change,
            last: keys.last_change,
            head: digits(file, "head", &keys.head)?,
            build: BuildId(digits(file, "build", &keys.build)?),
        },
        mac: digits(file, "mac", &keys.mac)?,
        entries: entries.collect::<Result<_, _>>()?,
    })
}
