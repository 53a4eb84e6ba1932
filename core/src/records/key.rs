//! The key in flash, in pages of its own. No request over the link reads them.
//!
//! ```text
//! | counter u32 | 0 u32 | time u64 | key 32 | CRC-32 | 0 u32 |        56 bytes, one record a page
//! ```
//!
//! A new key goes into the unused one of two pages, so that a power cut leaves the old key or the new one. The key with
//! the higher counter is valid, and the page of the old one is erased afterwards. Counter and time are those of the
//! key's entry in the [`super::log`].

use core::fmt;
use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;
use serde::{Deserialize, Serialize};

use crate::checksum::checksum;

const RECORD: usize = 56;
const CHECKED: usize = 48;

/// The secret that the board and the key holder share.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Key(#[serde(deserialize_with = "crate::bytes::read")] pub [u8; 32]);

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(secret)")
    }
}

/// A key, and the time of its arrival.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredKey {
    /// Counter of its log entry.
    pub counter: u32,
    /// The host's clock at that time, seconds since 1970-01-01 UTC.
    pub unix_s: u64,
    /// The key.
    pub key: Key,
}

impl StoredKey {
    fn encode(&self) -> [u8; RECORD] {
        let mut bytes = [0; RECORD];
        bytes[..4].copy_from_slice(&self.counter.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.unix_s.to_le_bytes());
        bytes[16..CHECKED].copy_from_slice(&self.key.0);
        let sum = checksum(&bytes[..CHECKED]);
        bytes[CHECKED..CHECKED + 4].copy_from_slice(&sum.to_le_bytes());
        bytes
    }

    fn decode(bytes: &[u8; RECORD]) -> Option<Self> {
        let (checked, rest) = bytes.split_at(CHECKED);
        let sum = checksum(checked).to_le_bytes();
        if rest.get(..4)? != sum {
            return None;
        }
        Some(Self {
            counter: u32::from_le_bytes(*checked.first_chunk()?),
            unix_s: u64::from_le_bytes(*checked.get(8..)?.first_chunk()?),
            key: Key(*checked.get(16..)?.first_chunk()?),
        })
    }
}

/// Why a key could not be stored.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum KeyError<E> {
    /// The flash failed.
    #[error("the flash failed: {0:?}")]
    Flash(E),
    /// The key does not read back as written.
    #[error("the key reads back differently from what was written; the flash may be worn out")]
    ReadBack,
}

/// The place of the key: two pages.
pub struct KeyPages<F: NorFlash> {
    flash: F,
    pages: [Range<u32>; 2],
}

impl<F: NorFlash> KeyPages<F> {
    /// Takes the flash and the two pages behind `start`, a multiple of the page.
    pub fn new(flash: F, start: u32) -> Self {
        let page = F::ERASE_SIZE as u32;
        Self {
            flash,
            pages: [start..start + page, start + page..start + 2 * page],
        }
    }

    /// The key; `None` on a board without one.
    ///
    /// # Errors
    /// [`KeyError::Flash`].
    pub async fn load(&mut self) -> Result<Option<StoredKey>, KeyError<F::Error>> {
        Ok(self.newest().await?.map(|(_, key)| key))
    }

    /// Stores a key in place of another; the other is valid until the new one reads back whole.
    ///
    /// # Errors
    /// Every variant of [`KeyError`].
    pub async fn store(&mut self, key: &StoredKey) -> Result<(), KeyError<F::Error>> {
        let old = self.newest().await?.map_or(1, |(page, _)| page);
        let new = 1 - old;
        self.erase(new).await?;
        let at = self.pages[new].start;
        // A failed write shows when it is read back.
        let _ = self.flash.write(at, &key.encode()).await;
        if self.read(new).await?.as_ref() != Some(key) {
            return Err(KeyError::ReadBack);
        }
        self.erase(old).await
    }

    async fn newest(&mut self) -> Result<Option<(usize, StoredKey)>, KeyError<F::Error>> {
        let keys = [self.read(0).await?, self.read(1).await?];
        let keys = keys.into_iter().enumerate();
        Ok(keys
            .filter_map(|(page, key)| Some((page, key?)))
            .max_by_key(|(_, key)| key.counter))
    }

    async fn erase(&mut self, page: usize) -> Result<(), KeyError<F::Error>> {
        let Range { start, end } = self.pages[page];
        self.flash.erase(start, end).await.map_err(KeyError::Flash)
    }

    async fn read(&mut self, page: usize) -> Result<Option<StoredKey>, KeyError<F::Error>> {
        let mut bytes = [0; RECORD];
        let at = self.pages[page].start;
        self.flash
            .read(at, &mut bytes)
            .await
            .map_err(KeyError::Flash)?;
        Ok(StoredKey::decode(&bytes))
    }
}
