//! The last eight coefficient sets in flash.
//!
//! Flash pages can be erased only whole and written only once, and power may go at any instant. The placing is
//! left to `sequential-storage`, a log-structured map with a checksum on every item: a set becomes visible by the
//! last word of its own write, so an interrupted write leaves the older sets as they were.
//!
//! ```text
//! slot = sequence mod 8 → | sequence u32 LE | encoded set |      even slots: first half, odd slots: second half
//! ```
//!
//! The range is cut into two halves with a map each, used in turn. An erasure that was interrupted leaves a page in
//! which anything may stand, even what looks like the start of a map. It can only have hit the half that does not
//! hold the newest set; when that half does not take the next set, it is erased and starts anew.
//!
//! The set with the highest sequence that decodes is the active one.

use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

use super::record::{CoefficientSet, MAX_ENCODED, RecordError, SetId};

/// Sets that are kept; an older one is overwritten.
pub const KEPT: u32 = 8;
/// Fewest pages of a half: one to write to, one that is erased, one that still holds older sets.
const HALF_PAGES: u32 = 3;
const SEQUENCE_BYTES: usize = 4;
/// Key, sequence and set, rounded up to the longest flash word.
const WORK_BYTES: usize = MAX_ENCODED + SEQUENCE_BYTES + 32;

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
    /// What was read back is not what was written.
    #[error("the set reads back differently from what was written; the flash may be worn out")]
    ReadBack,
}

/// A stored set with its place in history.
#[derive(Debug, Clone, PartialEq)]
pub struct Stored {
    /// Counts every commit on this board, from 1.
    pub sequence: u32,
    /// Identity of the set.
    pub id: SetId,
    /// The set.
    pub set: CoefficientSet,
}

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

    /// The active set: the newest that decodes; `None` on an empty archive.
    ///
    /// # Errors
    /// [`ArchiveError::Flash`].
    pub async fn newest(&mut self) -> Result<Option<Stored>, ArchiveError<F::Error>> {
        let mut newest: Option<Stored> = None;
        for slot in 0..KEPT as u8 {
            let stored = match self.fetch(slot).await {
                Err(error @ ArchiveError::Flash(Error::Storage { .. })) => return Err(error),
                // Any other error is what an interrupted erasure left; the newest set is in the other half.
                fetched => fetched.ok().flatten(),
            };
            if let Some(stored) = stored
                && newest
                    .as_ref()
                    .is_none_or(|best| stored.sequence > best.sequence)
            {
                newest = Some(stored);
            }
        }
        Ok(newest)
    }

    /// Appends an encoded set, reads it back and returns it as stored; from then on it is the newest.
    ///
    /// # Errors
    /// Every variant of [`ArchiveError`]; the newest set stays as it was.
    pub async fn append(&mut self, encoded: &[u8]) -> Result<Stored, ArchiveError<F::Error>> {
        CoefficientSet::decode(encoded).map_err(ArchiveError::Record)?;
        let sequence = self
            .newest()
            .await?
            .map_or(1, |stored| stored.sequence.wrapping_add(1));
        if let Ok(stored) = self.store(sequence, encoded).await {
            return Ok(stored);
        }
        let mut map = self.map(slot(sequence))?;
        map.erase_all().await.map_err(ArchiveError::Flash)?;
        self.store(sequence, encoded).await
    }

    /// Writes a set and reads it back.
    async fn store(
        &mut self,
        sequence: u32,
        encoded: &[u8],
    ) -> Result<Stored, ArchiveError<F::Error>> {
        let mut item = [0; MAX_ENCODED + SEQUENCE_BYTES];
        item[..SEQUENCE_BYTES].copy_from_slice(&sequence.to_le_bytes());
        let length = SEQUENCE_BYTES + encoded.len();
        item[SEQUENCE_BYTES..length].copy_from_slice(encoded);
        let slot = slot(sequence);
        let mut buffer = [0; WORK_BYTES];
        self.map(slot)?
            .store_item(&mut buffer, &slot, &&item[..length])
            .await
            .map_err(ArchiveError::Flash)?;
        let stored = self.fetch(slot).await?.ok_or(ArchiveError::ReadBack)?;
        if stored.sequence == sequence && stored.id == CoefficientSet::id_of(encoded) {
            Ok(stored)
        } else {
            Err(ArchiveError::ReadBack)
        }
    }

    /// The set in one slot; a slot whose content does not decode counts as empty.
    async fn fetch(&mut self, slot: u8) -> Result<Option<Stored>, ArchiveError<F::Error>> {
        let mut buffer = [0; WORK_BYTES];
        let item: Option<&[u8]> = self
            .map(slot)?
            .fetch_item(&mut buffer, &slot)
            .await
            .map_err(ArchiveError::Flash)?;
        Ok(item.and_then(|item| {
            let (sequence, encoded) = item.split_first_chunk::<SEQUENCE_BYTES>()?;
            let set = CoefficientSet::decode(encoded).ok()?;
            Some(Stored {
                sequence: u32::from_le_bytes(*sequence),
                id: CoefficientSet::id_of(encoded),
                set,
            })
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

fn slot(sequence: u32) -> u8 {
    (sequence % KEPT) as u8
}
