//! The last eight coefficient sets in flash.
//!
//! Flash pages can be erased only whole and written only once, and power may go at any instant. The placing is
//! left to `sequential-storage`, a log-structured map with a checksum on every item: a set becomes visible by the
//! last word of its own write, so an interrupted write leaves the older sets as they were.
//!
//! ```text
//! slot 0 … 7 → | log entry, postcard | encoded set |      even slots: first half, odd slots: second half
//! ```
//!
//! The range is cut into two halves with a map each. An erasure that was interrupted leaves a page in which anything may
//! stand, even what looks like the start of a map; so a set always goes into the half in which the active one is *not*,
//! in the place of the oldest there. When that half does not take it, it is erased and starts anew.
//!
//! A set is stored together with the entry that its activation has in the [`super::log`]: both are there or neither.

use core::cmp::Reverse;
use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

use super::log::Entry;
use super::record::{CoefficientSet, MAX_ENCODED, RecordError, SetId};

/// Sets that are kept; an older one is overwritten.
pub const KEPT: u8 = 8;
/// Fewest pages of a half: one to write to, one that is erased, one that still holds older sets.
const HALF_PAGES: u32 = 3;
/// Longest entry in postcard, bytes: counter 5, reason 1, time 10, two identities of 9.
const MAX_ENTRY: usize = 34;
/// Key, entry and set, rounded up to the longest flash word.
const WORK_BYTES: usize = MAX_ENTRY + MAX_ENCODED + 32;

type Map<'f, F> = MapStorage<u8, &'f mut F, Cache<Uncached, Uncached, Uncached, u8>>;

/// Why the archive could not do what was asked.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum ArchiveError<E> {
    /// The flash range is not an even number of whole pages, at least six.
    #[error("the flash range is not an even number of whole pages, at least six")]
    Range,
    /// The set is not fit to be stored.
    #[error(transparent)]
    Record(RecordError),
    /// The flash, or the storage format on it, failed.
    #[error("the flash failed: {0:?}")]
    Flash(Error<E>),
    /// What was read back is not what was written, or what was erased is still there.
    #[error("what is read back is not what was written or erased; the flash may be worn out")]
    ReadBack,
}

/// Where a set is, and its place in history.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stored {
    /// How it became active.
    pub entry: Entry,
    /// Identity of the set, as the entry has it.
    pub id: SetId,
    /// Length of the encoded set, bytes.
    pub length: u16,
    /// When the campaign was, seconds since 1970-01-01 UTC.
    pub made_unix_s: u64,
    /// Its place in the archive.
    pub slot: u8,
}

impl Stored {
    /// `None` for what is no set.
    fn new(slot: u8, entry: Entry, encoded: &[u8]) -> Option<Self> {
        let set = CoefficientSet::decode(encoded).ok()?;
        Some(Self {
            entry,
            id: entry.id?,
            length: encoded.len() as u16,
            made_unix_s: set.unix_s,
            slot,
        })
    }
}

/// What is kept, newest first.
pub type History = heapless::Vec<Stored, { KEPT as usize }>;

/// The sets on one flash range; owns the flash.
pub struct Archive<F: NorFlash> {
    flash: F,
    range: Range<u32>,
}

impl<F: NorFlash> Archive<F> {
    /// Takes the flash and the byte range in it that belongs to the archive.
    ///
    /// # Errors
    /// [`ArchiveError::Range`].
    pub fn new(flash: F, range: Range<u32>) -> Result<Self, ArchiveError<F::Error>> {
        let (length, page) = (range.len() as u32, F::ERASE_SIZE as u32);
        let whole = range.start.is_multiple_of(page) && length.is_multiple_of(2 * page);
        if !whole || length < 2 * HALF_PAGES * page {
            return Err(ArchiveError::Range);
        }
        Ok(Self { flash, range })
    }

    /// The sets that decode and were activated after the entry with counter `after`, newest first.
    ///
    /// # Errors
    /// [`ArchiveError::Flash`].
    pub async fn history(&mut self, after: u32) -> Result<History, ArchiveError<F::Error>> {
        let mut history = History::new();
        for slot in 0..KEPT {
            let place = |entry, encoded: &_| Stored::new(slot, entry, encoded);
            let found = match self.fetch(slot, place).await {
                Err(error @ ArchiveError::Flash(Error::Storage { .. })) => return Err(error),
                // Any other error is what an interrupted erasure left; the newest set is in the other half.
                fetched => fetched.ok().flatten(),
            };
            if let Some(found) = found.filter(|found| found.entry.counter > after) {
                let is_older = |kept: &Stored| kept.entry.counter < found.entry.counter;
                let place = history.iter().position(is_older).unwrap_or(history.len());
                // There is room for every slot.
                let _ = history.insert(place, found);
            }
        }
        Ok(history)
    }

    /// The set in a slot; `None` when there is none that decodes.
    ///
    /// # Errors
    /// [`ArchiveError::Flash`].
    pub async fn read(
        &mut self,
        slot: u8,
    ) -> Result<Option<CoefficientSet>, ArchiveError<F::Error>> {
        self.fetch(slot, |_, encoded| CoefficientSet::decode(encoded).ok())
            .await
    }

    /// Appends an encoded set that becomes active as `entry` says in place of the set in slot `active`, reads it back
    /// and returns it as stored.
    ///
    /// # Errors
    /// Every variant of [`ArchiveError`]; the active set stays as it was.
    pub async fn append(
        &mut self,
        entry: &Entry,
        encoded: &[u8],
        active: Option<u8>,
    ) -> Result<Stored, ArchiveError<F::Error>> {
        CoefficientSet::decode(encoded).map_err(ArchiveError::Record)?;
        let slot = slot_beside(active, &self.history(0).await?);
        if let Ok(stored) = self.store(slot, entry, encoded).await {
            return Ok(stored);
        }
        let mut map = self.map(slot)?;
        map.erase_all().await.map_err(ArchiveError::Flash)?;
        self.store(slot, entry, encoded).await
    }

    /// Erases all sets, and looks whether any is left.
    ///
    /// # Errors
    /// [`ArchiveError::Flash`], [`ArchiveError::ReadBack`].
    pub async fn erase(&mut self) -> Result<(), ArchiveError<F::Error>> {
        for slot in 0..2 {
            let mut map = self.map(slot)?;
            map.erase_all().await.map_err(ArchiveError::Flash)?;
        }
        if self.history(0).await?.is_empty() {
            Ok(())
        } else {
            Err(ArchiveError::ReadBack)
        }
    }

    /// Writes a set and reads it back.
    async fn store(
        &mut self,
        slot: u8,
        entry: &Entry,
        encoded: &[u8],
    ) -> Result<Stored, ArchiveError<F::Error>> {
        self.write(slot, entry, encoded).await?;
        let as_written = |found, bytes: &_| {
            (found == *entry && bytes == encoded).then(|| Stored::new(slot, found, bytes))?
        };
        let stored = self.fetch(slot, as_written).await?;
        stored.ok_or(ArchiveError::ReadBack)
    }

    async fn write(
        &mut self,
        slot: u8,
        entry: &Entry,
        encoded: &[u8],
    ) -> Result<(), ArchiveError<F::Error>> {
        let mut item = [0; MAX_ENTRY + MAX_ENCODED];
        let written = postcard::to_slice(entry, &mut item).map_or(0, |written| written.len());
        let length = written + encoded.len();
        // A set that decodes and an entry always fit.
        let place = item
            .get_mut(written..length)
            .ok_or(ArchiveError::ReadBack)?;
        place.copy_from_slice(encoded);
        let mut buffer = [0; WORK_BYTES];
        self.map(slot)?
            .store_item(&mut buffer, &slot, &&item[..length])
            .await
            .map_err(ArchiveError::Flash)
    }

    /// What `take` makes of the entry and the encoded set in one slot.
    async fn fetch<T>(
        &mut self,
        slot: u8,
        take: impl Fn(Entry, &[u8]) -> Option<T>,
    ) -> Result<Option<T>, ArchiveError<F::Error>> {
        let mut buffer = [0; WORK_BYTES];
        let item: Option<&[u8]> = self
            .map(slot)?
            .fetch_item(&mut buffer, &slot)
            .await
            .map_err(ArchiveError::Flash)?;
        Ok(item.and_then(|item| {
            let (entry, encoded) = postcard::take_from_bytes::<Entry>(item).ok()?;
            take(entry, encoded)
        }))
    }

    /// The map in the half of the range that a slot belongs to.
    fn map(&mut self, slot: u8) -> Result<Map<'_, F>, ArchiveError<F::Error>> {
        let middle = self.range.start + self.range.len() as u32 / 2;
        let half = if slot.is_multiple_of(2) {
            self.range.start..middle
        } else {
            middle..self.range.end
        };
        let config = MapConfig::try_new(half).map_err(|_| ArchiveError::Range)?;
        Ok(MapStorage::new(
            &mut self.flash,
            config,
            Cache::new_uncached(),
        ))
    }
}

/// The oldest slot, or one that is empty, in the half that does not hold slot `active`.
fn slot_beside(active: Option<u8>, history: &History) -> u8 {
    let first = active.map_or(0, |active| (active + 1) % 2);
    let age = |slot: &u8| history.iter().position(|stored| stored.slot == *slot);
    (first..KEPT)
        .step_by(2)
        .max_by_key(|slot| (age(slot).unwrap_or(usize::MAX), Reverse(*slot)))
        .unwrap_or(first)
}
