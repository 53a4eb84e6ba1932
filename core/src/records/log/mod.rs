//! The log of changes: what became active when, why, by which firmware, and in place of what. Entries are only appended.
//!
//! Each entry carries the hash of the one before ([`entry`]), so that one that is altered, removed or put in shows. Entries
//! lie one behind the other in a ring of pages. A volume begins with a page of its own, and its pages are never erased
//! while it lasts: a power cut can spoil only the entry under way, whose place is passed over.
//!
//! ```text
//! page   0      1      2      3      4      5      6      7
//!      older  older │ volume that is written … ▲ │ free │ older volume, erased page by page when the end comes to it
//! ```
//!
//! A page is erased when the end comes to it. One page always stays free for the first entry of the next volume, which is
//! the one step that closes a volume. Counters rise by one from 1, through all volumes.

pub mod entry;
mod search;

use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;

pub use entry::{Chain, ENTRY, Entry, Reason};

use super::reading::read;
use crate::facts::FlashLayout;

const ERASED: [u8; ENTRY] = [0xFF; ENTRY];
/// Places in a row that may fail to take an entry: after a power cut a half-programmed word may look erased and not be
/// writable.
const FAILURES: u32 = 8;
/// Last places of a volume that are for new keys only, so that a key that has leaked can always be replaced. Half of them
/// may also take what the board itself enters.
const KEPT: u32 = 16;

/// Entries that a volume of the log takes before ordinary changes are refused, because one page stays free: 3,720 in 118
/// pages of 2 KiB.
#[must_use]
pub const fn capacity(flash: &FlashLayout) -> u32 {
    let Range { start, end } = flash.log();
    (end - start - flash.page_bytes) / ENTRY as u32 - FAILURES - KEPT
}

/// Why an entry could not be appended or read.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum LogError {
    /// No place is left for an entry of this kind.
    #[error("the log is full")]
    Full,
    /// The flash could not be read.
    #[error("the flash cannot be read")]
    Read,
    /// No place took the entry: it does not read back as written.
    #[error("the entry reads back differently from what was written; the flash may be worn out")]
    ReadBack,
}

/// The end of the log.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct End {
    /// The last entry.
    pub last: Option<Entry>,
    /// Counter of the first entry of its volume that can be read, zero without one.
    pub first: u32,
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

    /// Counter of the last factory reset, zero without one: sets from before it are not used.
    #[must_use]
    pub fn reset(&self) -> u32 {
        self.last.map_or(0, |entry| entry.reset)
    }

    /// What the next entry carries as its chain.
    #[must_use]
    pub fn head(&self) -> Chain {
        self.last.map_or(Chain::default(), |entry| entry.hash())
    }

    /// Page that the volume begins in.
    #[must_use]
    pub fn page(&self) -> u16 {
        self.last.map_or(0, |entry| entry.page)
    }
}

/// The log on a range of flash.
pub struct Log<F: NorFlash> {
    flash: F,
    range: Range<u32>,
}

impl<F: NorFlash> Log<F> {
    const PAGE: u32 = F::ERASE_SIZE as u32;
    /// Places in a page.
    const PLACES: u32 = Self::PAGE / ENTRY as u32;

    /// Takes the flash and the pages in it that belong to the log, at least two.
    pub const fn new(flash: F, range: Range<u32>) -> Self {
        Self { flash, range }
    }

    fn pages(&self) -> u32 {
        self.range.len() as u32 / Self::PAGE
    }

    fn places(&self) -> u32 {
        self.pages() * Self::PLACES
    }

    /// First place of the volume.
    fn begin(end: &End) -> u32 {
        u32::from(end.page()) * Self::PLACES
    }

    /// Places of the volume that are used.
    #[must_use]
    pub fn used(&self, end: &End) -> u32 {
        (end.place + self.places()).wrapping_sub(Self::begin(end)) % self.places()
    }

    /// Page for the first entry of the next volume.
    #[must_use]
    pub fn next_page(&self, end: &End) -> u16 {
        (end.place.div_ceil(Self::PLACES) % self.pages()) as u16
    }

    /// Whether an entry of this kind can still be appended behind `end`: the last places are kept for what must always be
    /// possible, and eight for places that fail. A new volume has its free page.
    #[must_use]
    pub fn has_room(&self, end: &End, reason: Reason) -> bool {
        let kept = match reason {
            Reason::NewVolume => return true,
            Reason::Provision => 0,
            Reason::Fallback | Reason::FirmwareChange => KEPT / 2,
            Reason::Upload | Reason::Rollback | Reason::FactoryReset => KEPT,
        };
        self.used(end) + FAILURES + kept < self.places() - Self::PLACES
    }

    /// Appends an entry behind `end`, which moves on; the first entry of a volume at the begin of its page.
    ///
    /// # Errors
    /// Every variant of [`LogError`].
    pub async fn append(&mut self, end: &mut End, entry: &Entry) -> Result<(), LogError> {
        if !self.has_room(end, entry.reason) {
            return Err(LogError::Full);
        }
        let bytes = entry.encode();
        let is_first = entry.page != end.page() || end.last.is_none();
        let start = if is_first {
            u32::from(entry.page) * Self::PLACES
        } else {
            end.place
        };
        for place in start..=start + FAILURES {
            let place = place % self.places();
            let at = self.offset(place);
            // A failed erasure or write shows when it is read back; some drivers lose its error.
            if place.is_multiple_of(Self::PLACES) {
                let _ = self.flash.erase(at, at + Self::PAGE).await;
            }
            let _ = self.flash.write(at, &bytes).await;
            if self.read(place)? == bytes {
                *end = End {
                    last: Some(*entry),
                    first: if is_first { entry.counter } else { end.first },
                    place: place + 1,
                };
                return Ok(());
            }
        }
        Err(LogError::ReadBack)
    }

    /// The entries of the volume from `counter` on, at most `N`.
    ///
    /// # Errors
    /// [`LogError::Read`].
    pub fn entries<const N: usize>(
        &mut self,
        end: &End,
        counter: u32,
    ) -> Result<heapless::Vec<Entry, N>, LogError> {
        let mut entries = heapless::Vec::new();
        // No entry stands before the place of its counter.
        for place in counter.saturating_sub(end.first)..self.used(end) {
            let place = (Self::begin(end) + place) % self.places();
            let entry = Entry::decode(&self.read(place)?);
            if let Some(entry) = entry.filter(|entry| entry.counter >= counter)
                && entries.push(entry).is_err()
            {
                break;
            }
        }
        Ok(entries)
    }

    /// Whether nothing was ever written into the pages.
    ///
    /// # Errors
    /// [`LogError::Read`].
    pub fn is_blank(&mut self) -> Result<bool, LogError> {
        for place in 0..self.places() {
            if self.read(place)? != ERASED {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn offset(&self, place: u32) -> u32 {
        self.range.start + place * ENTRY as u32
    }

    fn read(&mut self, place: u32) -> Result<[u8; ENTRY], LogError> {
        let at = self.offset(place);
        read(&mut self.flash, at).ok_or(LogError::Read)
    }
}
