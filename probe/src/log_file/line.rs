//! One entry as a line of the file.

use hexsense_core::records::log::{Entry, Reason};
use hexsense_core::records::{BuildId, SetId};
use serde::{Deserialize, Serialize};

use crate::date::utc;
use crate::files::{self, FileError, hex};

/// One entry.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    change: u32,
    what: String,
    unix_s: u64,
    utc: Option<String>,
    id: Option<String>,
    previous_id: Option<String>,
    build: String,
    chain: String,
    reset: u32,
    page: u16,
}

impl Line {
    /// The line of an entry.
    pub fn of(entry: &Entry) -> Self {
        Self {
            change: entry.counter,
            what: name(entry.reason).to_owned(),
            unix_s: entry.unix_s,
            utc: time(entry),
            id: entry.id.map(|id| id.to_string()),
            previous_id: entry.previous.map(|id| id.to_string()),
            build: entry.build.to_string(),
            chain: hex(&entry.chain),
            reset: entry.reset,
            page: entry.page,
        }
    }

    /// The entry of the line at `place`.
    ///
    /// # Errors
    /// [`FileError::Value`].
    pub fn entry(&self, place: &str) -> Result<Entry, FileError> {
        let set = |key: &str, id: &Option<String>| -> Result<Option<SetId>, FileError> {
            let id = id.as_deref().map(|id| digits(place, key, id));
            Ok(id.transpose()?.map(SetId))
        };
        let reason = REASONS.into_iter().find(|(_, name)| *name == self.what);
        let (reason, _) = reason.ok_or_else(|| {
            let names = REASONS.map(|(_, name)| name).join(", ");
            FileError::value(place, "what", &self.what, format!("it is one of {names}"))
        })?;
        Ok(Entry {
            counter: self.change,
            reason,
            unix_s: self.unix_s,
            id: set("id", &self.id)?,
            previous: set("previous_id", &self.previous_id)?,
            build: BuildId(digits(place, "build", &self.build)?),
            chain: digits(place, "chain", &self.chain)?,
            reset: self.reset,
            page: self.page,
        })
    }
}

const REASONS: [(Reason, &str); 7] = [
    (Reason::Upload, "upload"),
    (Reason::Rollback, "rollback"),
    (Reason::FactoryReset, "factory-reset"),
    (Reason::Provision, "provision"),
    (Reason::Fallback, "fallback"),
    (Reason::FirmwareChange, "firmware"),
    (Reason::NewVolume, "new-volume"),
];

/// The name of a kind of change.
#[must_use]
pub fn name(reason: Reason) -> &'static str {
    REASONS
        .into_iter()
        .find_map(|(known, name)| (known == reason).then_some(name))
        .unwrap_or("unknown")
}

/// The time of a change; what the board enters by itself has none.
#[must_use]
pub fn time(entry: &Entry) -> Option<String> {
    let has_time = !matches!(entry.reason, Reason::Fallback | Reason::FirmwareChange);
    has_time.then(|| utc(entry.unix_s))
}

/// The bytes that a key spells.
///
/// # Errors
/// [`FileError::Value`].
pub fn digits<const N: usize>(file: &str, key: &str, text: &str) -> Result<[u8; N], FileError> {
    files::from_hex(text).ok_or_else(|| {
        let limit = format!("it must have {} hexadecimal digits", 2 * N);
        FileError::value(file, key, text, limit)
    })
}
