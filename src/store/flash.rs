//! The last eight coefficient sets in flash.
//!
//! Flash pages can be erased only whole and written only once, and power may go at any instant. The placing is
//! left to `sequential-storage`, a log-structured map with a checksum on every item: a set becomes visible by the
//! last word of its own write, so an interrupted write leaves the older sets as they were.
//!
//! ```text
//! key = sequence mod 8  →  | sequence u32 LE | encoded set |
//! ```
//!
//! The set with the highest sequence that decodes is the active one.

use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

use super::record::{CoefficientSet, MAX_ENCODED, RecordError, SetId};

/// Sets that are kept; an older one is overwritten.
pub const KEPT: u32 = 8;
const SEQUENCE_BYTES: usize = 4;
/// Key, sequence and set, rounded up to the longest flash word.
const WORK_BYTES: usize = MAX_ENCODED + SEQUENCE_BYTES + 32;

type Map<F> = MapStorage<u8, F, Cache<Uncached, Uncached, Uncached, u8>>;

/// Why the archive could not do what was asked.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum ArchiveError<E> {
    /// The flash range is not made of at least two whole pages.
    #[error("the flash range is not at least two whole pages")]
    Range,
    /// The set is not fit to be stored.
    #[error(transparent)]
    Record(RecordError),
    /// The flash, or the storage format on it, failed.
    #[error("the flash failed: {0:?}")]
    Flash(sequential_storage::Error<E>),
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
    map: Map<F>,
    buffer: [u8; WORK_BYTES],
}

impl<F: NorFlash> Archive<F> {
    /// Takes the flash and the byte range in it that belongs to the archive.
    ///
    /// # Errors
    /// [`ArchiveError::Range`].
    pub fn new(flash: F, range: Range<u32>) -> Result<Self, ArchiveError<F::Error>> {
        let config = MapConfig::try_new(range).map_err(|_| ArchiveError::Range)?;
        Ok(Self {
            map: MapStorage::new(flash, config, Cache::new_uncached()),
            buffer: [0; WORK_BYTES],
        })
    }

    /// The active set: the newest that decodes; `None` on an empty archive.
    ///
    /// # Errors
    /// [`ArchiveError::Flash`].
    pub async fn newest(&mut self) -> Result<Option<Stored>, ArchiveError<F::Error>> {
        let mut newest: Option<Stored> = None;
        for slot in 0..KEPT as u8 {
            if let Some(stored) = self.fetch(slot).await?
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
    /// Every variant of [`ArchiveError`]; the older sets stay as they were.
    pub async fn append(&mut self, encoded: &[u8]) -> Result<Stored, ArchiveError<F::Error>> {
        CoefficientSet::decode(encoded).map_err(ArchiveError::Record)?;
        let sequence = self
            .newest()
            .await?
            .map_or(1, |stored| stored.sequence.wrapping_add(1));
        let mut item = [0; MAX_ENCODED + SEQUENCE_BYTES];
        item[..SEQUENCE_BYTES].copy_from_slice(&sequence.to_le_bytes());
        let length = SEQUENCE_BYTES + encoded.len();
        item[SEQUENCE_BYTES..length].copy_from_slice(encoded);
        let slot = (sequence % KEPT) as u8;
        self.map
            .store_item(&mut self.buffer, &slot, &&item[..length])
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
        let item: Option<&[u8]> = self
            .map
            .fetch_item(&mut self.buffer, &slot)
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
}
