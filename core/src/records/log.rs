//! The log of changes: what became active when, why, and in place of what. Entries are only appended.
//!
//! Entries of 40 bytes, five flash words, lie one behind the other and are never erased. So a power cut can spoil only
//! the entry under way: its checksum does not match, and its place is passed over:
//!
//! ```text
//! | counter u32 | reason u8 | has id, has previous u8 | 0 u16 | time u64 | id 8 | previous id 8 | CRC-32 | 0 u32 |
//! ```
//!
//! (All little endian.) Counters rise by one from 1. When the log is full, the board takes no more changes.

use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;
use serde::{Deserialize, Serialize};

use super::record::SetId;
use crate::checksum::checksum;

/// Bytes of an entry in flash.
pub const ENTRY: usize = 40;
/// Where the checksum begins.
const CHECKED: usize = 32;
const ERASED: [u8; ENTRY] = [0xFF; ENTRY];
/// Places in a row that may fail to take an entry: after a power cut a half-programmed word may look erased and not be
/// writable.
const FAILURES: u32 = 8;

/// The kind of a change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reason {
    /// A set was uploaded.
    Upload,
    /// A kept set was made active again.
    Rollback,
    /// All sets were erased.
    FactoryReset,
    /// The board got a key.
    Provision,
    /// The active set became unreadable, and the newest readable one took its place. The time is unknown, zero.
    Fallback,
}

impl Reason {
    const ALL: [Self; 5] = [
        Self::Upload,
        Self::Rollback,
        Self::FactoryReset,
        Self::Provision,
        Self::Fallback,
    ];
}

/// One change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// Number of the change on this board, from 1.
    pub counter: u32,
    /// Its kind.
    pub reason: Reason,
    /// The host's clock at the change, seconds since 1970-01-01 UTC.
    pub unix_s: u64,
    /// The set that is active after it; `None` after a factory reset.
    pub id: Option<SetId>,
    /// The set that was active before.
    pub previous: Option<SetId>,
}

impl Entry {
    pub(super) fn encode(&self) -> [u8; ENTRY] {
        let mut bytes = [0; ENTRY];
        bytes[..4].copy_from_slice(&self.counter.to_le_bytes());
        bytes[4] = self.reason as u8;
        bytes[5] = u8::from(self.id.is_some()) | u8::from(self.previous.is_some()) << 1;
        bytes[8..16].copy_from_slice(&self.unix_s.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.id.unwrap_or_default().0);
        bytes[24..32].copy_from_slice(&self.previous.unwrap_or_default().0);
        let sum = checksum(&bytes[..CHECKED]);
        bytes[CHECKED..CHECKED + 4].copy_from_slice(&sum.to_le_bytes());
        bytes
    }

    pub(super) fn decode(bytes: &[u8; ENTRY]) -> Option<Self> {
        let (checked, rest) = bytes.split_at(CHECKED);
        let sum = checksum(checked).to_le_bytes();
        if rest.get(..4)? != sum {
            return None;
        }
        let id = |present: u8, at: usize| {
            let id = bytes.get(at..)?.first_chunk::<8>()?;
            (bytes[5] & present != 0).then_some(SetId(*id))
        };
        Some(Self {
            counter: u32::from_le_bytes(*checked.first_chunk()?),
            reason: Reason::ALL
                .into_iter()
                .find(|reason| *reason as u8 == bytes[4])?,
            unix_s: u64::from_le_bytes(*checked.get(8..)?.first_chunk()?),
            id: id(1, 16),
            previous: id(2, 24),
        })
    }
}

/// Why an entry could not be appended or read.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum LogError<E> {
    /// No place is left.
    #[error("the log is full")]
    Full,
    /// The flash failed.
    #[error("the flash failed: {0:?}")]
    Flash(E),
    /// No place took the entry: it does not read back as written.
    #[error("the entry reads back differently from what was written; the flash may be worn out")]
    ReadBack,
}

/// The end of the log.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct End {
    /// The last entry.
    pub last: Option<Entry>,
    /// Counter of the last factory reset, zero without one: sets from before it are not used.
    pub reset: u32,
    /// Number of the first place behind the used ones.
    place: u32,
}

impl End {
    /// Counter of the next entry.
    #[must_use]
    pub fn next_counter(&self) -> u32 {
        self.last_counter().saturating_add(1)
    }

    /// Counter of the last entry, zero without one.
    #[must_use]
    pub fn last_counter(&self) -> u32 {
        self.last.map_or(0, |entry| entry.counter)
    }

    /// Moves behind an entry at `place`.
    fn pass(&mut self, place: u32, entry: &Entry) {
        if entry.reason == Reason::FactoryReset {
            self.reset = entry.counter;
        }
        self.last = Some(*entry);
        self.place = place + 1;
    }
}

/// The log on a range of flash.
pub struct Log<F: NorFlash> {
    flash: F,
    range: Range<u32>,
}

impl<F: NorFlash> Log<F> {
    /// Takes the flash and the byte range in it that belongs to the log, which begins with a flash word.
    pub const fn new(flash: F, range: Range<u32>) -> Self {
        Self { flash, range }
    }

    fn places(&self) -> u32 {
        self.range.len() as u32 / ENTRY as u32
    }

    /// Finds the end, from the beginning.
    ///
    /// # Errors
    /// [`LogError::Flash`].
    pub async fn end(&mut self) -> Result<End, LogError<F::Error>> {
        let mut end = End::default();
        for place in 0..self.places() {
            let bytes = self.read(place).await?;
            if let Some(entry) = Entry::decode(&bytes) {
                end.pass(place, &entry);
            } else if bytes != ERASED {
                end.place = place + 1;
            } else if place > end.place + FAILURES {
                break;
            }
        }
        Ok(end)
    }

    /// Whether an entry can still be appended behind `end`: the last eight places stay in reserve for places that fail.
    #[must_use]
    pub fn has_room(&self, end: &End) -> bool {
        end.place + FAILURES < self.places()
    }

    /// Appends an entry behind `end`, which moves on.
    ///
    /// # Errors
    /// Every variant of [`LogError`].
    pub async fn append(&mut self, end: &mut End, entry: &Entry) -> Result<(), LogError<F::Error>> {
        if !self.has_room(end) {
            return Err(LogError::Full);
        }
        let bytes = entry.encode();
        for place in end.place..=end.place + FAILURES {
            // A failed write shows when it is read back; some drivers lose its error.
            let _ = self.flash.write(self.offset(place), &bytes).await;
            if self.read(place).await? == bytes {
                end.pass(place, entry);
                return Ok(());
            }
        }
        Err(LogError::ReadBack)
    }

    /// The entries from `counter` on, at most `N`.
    ///
    /// # Errors
    /// [`LogError::Flash`].
    pub async fn entries<const N: usize>(
        &mut self,
        end: &End,
        counter: u32,
    ) -> Result<heapless::Vec<Entry, N>, LogError<F::Error>> {
        let mut entries = heapless::Vec::new();
        // No entry stands before the place of its counter.
        for place in counter.saturating_sub(1)..end.place {
            let entry = Entry::decode(&self.read(place).await?);
            if let Some(entry) = entry.filter(|entry| entry.counter >= counter)
                && entries.push(entry).is_err()
            {
                break;
            }
        }
        Ok(entries)
    }

    fn offset(&self, place: u32) -> u32 {
        self.range.start + place * ENTRY as u32
    }

    async fn read(&mut self, place: u32) -> Result<[u8; ENTRY], LogError<F::Error>> {
        let mut bytes = [0; ENTRY];
        let at = self.offset(place);
        self.flash
            .read(at, &mut bytes)
            .await
            .map_err(LogError::Flash)?;
        Ok(bytes)
    }
}
