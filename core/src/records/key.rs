//! The key in flash, in pages of its own. No request over the link reads them.
//!
//! ```text
//! | counter u32 | 0 u32 | time u64 | key 32 | CRC-32 | 0 u32 |        56 bytes, twice in a page: at its start and in its middle
//! ```
//!
//! Either good copy of a page will do, so that damage to one costs nothing. A new key goes into the page of the two that
//! does not hold the key in force. It carries counter and time of the entry in the [`super::log`] that brings it in
//! force, and the storage erases the page of the old key afterwards.

use core::fmt;

use embedded_storage_async::nor_flash::NorFlash;
use serde::{Deserialize, Serialize};

use super::reading::read;
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
pub enum KeyError {
    /// The flash could not be read.
    #[error("the flash cannot be read")]
    Read,
    /// The flash could not be erased.
    #[error("the flash cannot be erased")]
    Erase,
    /// A copy of the key does not read back as written.
    #[error("the key reads back differently from what was written; the flash may be worn out")]
    ReadBack,
}

/// The place of the key: two pages.
pub struct KeyPages<F: NorFlash> {
    flash: F,
    start: u32,
}

impl<F: NorFlash> KeyPages<F> {
    const PAGE: u32 = {
        assert!(F::ERASE_SIZE >= 2 * RECORD, "a page holds a key twice");
        F::ERASE_SIZE as u32
    };

    /// Takes the flash and the two pages behind `start`, a multiple of the page.
    pub const fn new(flash: F, start: u32) -> Self {
        Self { flash, start }
    }

    /// The key in each page, by either copy of it.
    ///
    /// # Errors
    /// [`KeyError::Read`].
    pub fn load(&mut self) -> Result<[Option<StoredKey>; 2], KeyError> {
        let mut keys = [None, None];
        for copy in 0..4 {
            let bytes = self.read(copy)?;
            if let Some(found) = StoredKey::decode(&bytes) {
                keys[usize::from(copy / 2)] = Some(found);
            }
        }
        Ok(keys)
    }

    /// Stores a key in a page (0 or 1), twice; what the page held is gone.
    ///
    /// # Errors
    /// Every variant of [`KeyError`]; the page may then hold the key nevertheless.
    pub async fn store(&mut self, page: u8, key: &StoredKey) -> Result<(), KeyError> {
        self.erase(page).await?;
        let record = key.encode();
        for copy in [2 * page, 2 * page + 1] {
            let at = self.place(copy);
            // A failed write shows when it is read back.
            let _ = self.flash.write(at, &record).await;
            if self.read(copy)? != record {
                return Err(KeyError::ReadBack);
            }
        }
        Ok(())
    }

    /// Erases a page (0 or 1).
    ///
    /// # Errors
    /// [`KeyError::Erase`].
    pub async fn erase(&mut self, page: u8) -> Result<(), KeyError> {
        let start = self.place(2 * page);
        let erased = self.flash.erase(start, start + Self::PAGE).await;
        erased.map_err(|_| KeyError::Erase)
    }

    fn read(&mut self, copy: u8) -> Result<[u8; RECORD], KeyError> {
        let at = self.place(copy);
        read(&mut self.flash, at).ok_or(KeyError::Read)
    }

    /// Where a copy (0 to 3) begins: two are in each page.
    fn place(&self, copy: u8) -> u32 {
        self.start + u32::from(copy) * (Self::PAGE / 2)
    }
}
