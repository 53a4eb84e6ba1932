//! The last eight coefficient sets in flash, one to a page.
//!
//! ```text
//! | log entry 64 | length of the set u64 | set, which ends with its checksum | erased |        page 0 … page 7
//! ```
//!
//! Pages can be erased only whole, double words written only once, and power may go at any instant. A new set goes into
//! an empty page, or into that of the oldest set, and never into that of the active one: an interrupted erasure or
//! write damages no other set. A page holds a set once its last word is written, because only then both checksums are
//! right.
//!
//! A set is stored together with the entry of its activation in the [`super::log`]: both are there, or neither.

use core::cmp::Reverse;

use embedded_storage_async::nor_flash::NorFlash;

use super::log::{ENTRY, Entry, Reason};
use super::reading::read;
use super::record::{CoefficientSet, MAX_ENCODED, RecordError, SetId};

/// Sets that are kept, and pages; an older one is overwritten.
pub const KEPT: u8 = 8;
/// Where the set begins in its page.
const SET: usize = ENTRY + 8;
/// Longest record, a multiple of every flash word.
const RECORD: usize = (SET + MAX_ENCODED).next_multiple_of(32);

/// Why the archive refuses or fails.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum ArchiveError<E> {
    /// The set is not fit to be stored.
    #[error(transparent)]
    Record(RecordError),
    /// The set was made for another board.
    #[error("the set was made for another board; calibrate this one")]
    OtherBoard,
    /// The flash failed.
    #[error("the flash failed: {0:?}")]
    Flash(E),
    /// The flash could not be read.
    #[error("the flash cannot be read")]
    Read,
    /// The flash does not read back as written, or an erased set is still there.
    #[error("what is read back is not what was written or erased; the flash may be worn out")]
    ReadBack,
}

/// The place of a set, and its place in history.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stored {
    /// The entry that made it active.
    pub entry: Entry,
    /// Identity of the set, from the entry.
    pub id: SetId,
    /// Length of the encoded set, bytes.
    pub length: u16,
    /// End of the campaign, seconds since 1970-01-01 UTC.
    pub made_unix_s: u64,
    /// Its page in the archive.
    pub slot: u8,
}

impl Stored {
    /// The place of an uploaded set, and the set; `None` for anything else.
    fn new(slot: u8, entry: Entry, encoded: &[u8]) -> Option<(Self, CoefficientSet)> {
        let set = CoefficientSet::decode(encoded).ok()?;
        let stored = Self {
            entry,
            id: entry.id.filter(|_| entry.reason == Reason::Upload)?,
            length: encoded.len() as u16,
            made_unix_s: set.unix_s,
            slot,
        };
        Some((stored, set))
    }
}

/// The kept sets, newest first.
pub type History = heapless::Vec<Stored, { KEPT as usize }>;

/// The sets on eight pages of flash.
pub struct Archive<F: NorFlash> {
    flash: F,
    start: u32,
}

impl<F: NorFlash> Archive<F> {
    const PAGE: u32 = {
        assert!(F::ERASE_SIZE >= RECORD, "a set needs a page that holds it");
        F::ERASE_SIZE as u32
    };

    /// Takes the flash and the eight pages behind `start`, a multiple of the page.
    pub const fn new(flash: F, start: u32) -> Self {
        Self { flash, start }
    }

    /// The sets that decode and were activated after the entry with counter `after`, newest first.
    ///
    /// # Errors
    /// [`ArchiveError::Read`].
    pub fn history(&mut self, after: u32) -> Result<History, ArchiveError<F::Error>> {
        let mut history = History::new();
        for slot in 0..KEPT {
            let place = |entry, encoded: &_| Some(Stored::new(slot, entry, encoded)?.0);
            let found = self.fetch(slot, place)?;
            if let Some(found) = found.filter(|found| found.entry.counter > after) {
                let is_older = |kept: &Stored| kept.entry.counter < found.entry.counter;
                let place = history.iter().position(is_older).unwrap_or(history.len());
                // There is room for every slot.
                let _ = history.insert(place, found);
            }
        }
        Ok(history)
    }

    /// The set of this identity in a slot; `None` when it is not there or does not decode.
    ///
    /// # Errors
    /// [`ArchiveError::Read`].
    pub fn read(
        &mut self,
        slot: u8,
        id: SetId,
    ) -> Result<Option<CoefficientSet>, ArchiveError<F::Error>> {
        self.fetch(slot, |entry, encoded| {
            CoefficientSet::decode(encoded)
                .ok()
                .filter(|_| entry.id == Some(id))
        })
    }

    /// Stores an encoded set of `board`, which `entry` makes active in place of the set in slot `active`. Returns its place
    /// and the set as read back. If a page does not take it, one other page is tried.
    ///
    /// # Errors
    /// Every variant of [`ArchiveError`]; the active set stays as it was.
    pub async fn append(
        &mut self,
        entry: &Entry,
        encoded: &[u8],
        active: Option<u8>,
        board: &[u8; 12],
    ) -> Result<(Stored, CoefficientSet), ArchiveError<F::Error>> {
        let set = CoefficientSet::decode(encoded).map_err(ArchiveError::Record);
        if set.map(|set| set.board != *board)? {
            return Err(ArchiveError::OtherBoard);
        }
        let [first, second] = slots_for_next(active, &self.history(0)?);
        // No set lives across a wait, where it would take 600 bytes of RAM: the first result ends with its block.
        {
            let stored = self.store(first, entry, encoded).await;
            if stored.is_ok() {
                return stored;
            }
        }
        self.store(second, entry, encoded).await
    }

    /// Erases all sets and checks that none is left.
    ///
    /// # Errors
    /// [`ArchiveError::Flash`], [`ArchiveError::Read`], [`ArchiveError::ReadBack`].
    pub async fn erase(&mut self) -> Result<(), ArchiveError<F::Error>> {
        let end = self.start + u32::from(KEPT) * Self::PAGE;
        let erased = self.flash.erase(self.start, end).await;
        erased.map_err(ArchiveError::Flash)?;
        if self.history(0)?.is_empty() {
            Ok(())
        } else {
            Err(ArchiveError::ReadBack)
        }
    }

    /// Writes a set into an erased page and reads it back.
    async fn store(
        &mut self,
        slot: u8,
        entry: &Entry,
        encoded: &[u8],
    ) -> Result<(Stored, CoefficientSet), ArchiveError<F::Error>> {
        let at = self.offset(slot);
        let erased = self.flash.erase(at, at + Self::PAGE).await;
        erased.map_err(ArchiveError::Flash)?;
        self.write(at, entry, encoded).await?;
        let as_written = |found, bytes: &_| {
            (found == *entry && bytes == encoded).then(|| Stored::new(slot, found, bytes))?
        };
        let stored = self.fetch(slot, as_written)?;
        stored.ok_or(ArchiveError::ReadBack)
    }

    async fn write(
        &mut self,
        at: u32,
        entry: &Entry,
        encoded: &[u8],
    ) -> Result<(), ArchiveError<F::Error>> {
        let mut record = [0xFF; RECORD];
        let length = (SET + encoded.len()).next_multiple_of(F::WRITE_SIZE);
        record[..ENTRY].copy_from_slice(&entry.encode());
        record[ENTRY..SET].copy_from_slice(&(encoded.len() as u64).to_le_bytes());
        // A set that decodes always fits.
        let place = record.get_mut(SET..SET + encoded.len());
        place
            .ok_or(ArchiveError::ReadBack)?
            .copy_from_slice(encoded);
        let record = record.get(..length).ok_or(ArchiveError::ReadBack)?;
        // A failed write shows when it is read back; some drivers lose its error.
        let _ = self.flash.write(at, record).await;
        Ok(())
    }

    /// Reads one slot and applies `take` to its entry and its encoded set.
    fn fetch<T>(
        &mut self,
        slot: u8,
        take: impl Fn(Entry, &[u8]) -> Option<T>,
    ) -> Result<Option<T>, ArchiveError<F::Error>> {
        let at = self.offset(slot);
        let record = read(&mut self.flash, at).ok_or(ArchiveError::Read)?;
        Ok(parts(&record).and_then(|(entry, encoded)| take(entry, encoded)))
    }

    fn offset(&self, slot: u8) -> u32 {
        self.start + u32::from(slot) * Self::PAGE
    }
}

/// Entry and encoded set in a page, if it has the right shape.
fn parts(record: &[u8; RECORD]) -> Option<(Entry, &[u8])> {
    let (entry, rest) = record.split_first_chunk()?;
    let (length, rest) = rest.split_first_chunk()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    Some((Entry::decode(entry)?, rest.get(..length)?))
}

/// The slot for the next set, and a second one in case that fails: empty slots before those of old sets, and never the
/// `active` one.
fn slots_for_next(active: Option<u8>, history: &History) -> [u8; 2] {
    let age = |slot: u8| history.iter().position(|stored| stored.slot == slot);
    let oldest_beside = |first: Option<u8>| {
        (0..KEPT)
            .filter(|slot| Some(*slot) != active && Some(*slot) != first)
            .max_by_key(|slot| (age(*slot).unwrap_or(usize::MAX), Reverse(*slot)))
            .unwrap_or_default()
    };
    let first = oldest_beside(None);
    [first, oldest_beside(Some(first))]
}
