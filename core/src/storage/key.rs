//! The key in force, and its replacement.
//!
//! ```text
//! new key ──▶ the page that does not hold the key in force ──▶ log: now it is in force ──▶ the old key's page erased
//! ```
//!
//! The entry in the log decides. A change of the key that is refused or cut off before it leaves the old key in force,
//! also after the next start; after it only the new key serves. The first key of a board has no old key beside it. It is
//! in force once it is in its page, and the next start completes its entry.
//!
//! This file and `mod.rs` are two halves of [`Storage`].
//!
//! A board that had a key and finds no good copy of it is not a board without a key: it takes no change at all.

use embedded_storage_async::nor_flash::NorFlash;

use super::{Made, Storage};
use crate::records::key::{Key, KeyPages, StoredKey};
use crate::records::log::Reason;
use crate::wire::message::LOG_ENTRIES;
use crate::wire::{Refusal, Response};

/// What a board knows of its key.
#[derive(Debug)]
pub(super) enum KeyState {
    /// It never had one.
    None,
    /// This one.
    InForce {
        /// Its page, 0 or 1.
        page: u8,
        /// The key.
        stored: StoredKey,
        /// Whether the other page held a key that is not in force.
        has_spare: bool,
    },
    /// It had one, and no copy is good; or the flash was not read yet.
    Damaged,
}

impl KeyState {
    /// The key in force.
    ///
    /// # Errors
    /// [`Refusal::Unprovisioned`] and [`Refusal::KeyDamaged`].
    pub(super) fn in_force(&self) -> Result<&Key, Refusal> {
        match self {
            Self::InForce { stored, .. } => Ok(&stored.key),
            Self::None => Err(Refusal::Unprovisioned),
            Self::Damaged => Err(Refusal::KeyDamaged),
        }
    }
}

impl<F: NorFlash> Storage<F> {
    /// Finds the key in force; `had_one` tells whether the log or the archive shows that there is one.
    pub(super) fn find_key(&mut self, had_one: bool) -> Result<(), Refusal> {
        let keys = self.keys().load().map_err(|_| Refusal::Flash)?;
        let counter = |page: usize| keys[page].as_ref().map(|key| key.counter);
        let mut page = usize::from(counter(1) > counter(0));
        let has_spare = keys.iter().all(Option::is_some);
        if has_spare
            && let Some(newer) = &keys[page]
            && !self.is_in_force(newer)?
        {
            page = 1 - page;
        }
        self.key = match keys.into_iter().nth(page).flatten() {
            Some(stored) => KeyState::InForce {
                page: page as u8,
                stored,
                has_spare,
            },
            None if had_one => KeyState::Damaged,
            None => KeyState::None,
        };
        Ok(())
    }

    /// Whether the log has the entry of a key, or had it where it cannot be read any more.
    fn is_in_force(&mut self, key: &StoredKey) -> Result<bool, Refusal> {
        let (mut log, end) = self.log();
        if key.counter > end.last_counter() {
            return Ok(false);
        }
        // An entry of an earlier volume is its own: a volume begins only where there is no other key.
        if key.counter < end.first {
            return Ok(true);
        }
        let entries = log.entries::<LOG_ENTRIES>(end, key.counter);
        let entries = entries.map_err(|_| Refusal::Flash)?;
        let of_counter = entries.first().filter(|entry| entry.counter == key.counter);
        Ok(of_counter
            .is_none_or(|entry| entry.reason == Reason::Provision && entry.unix_s == key.unix_s))
    }

    /// The entry of a first key, where a loss of power left it over.
    pub(super) fn unlogged_key(&self) -> Option<Made> {
        match &self.key {
            KeyState::InForce { stored, .. } if stored.counter > self.end.last_counter() => {
                Some(Made {
                    counter: stored.counter,
                    reason: Reason::Provision,
                    id: self.active_id(),
                    unix_s: stored.unix_s,
                })
            }
            _ => None,
        }
    }

    /// Erases a key that is not in force. It may stay: beside the other it never comes in force.
    pub(super) async fn erase_spare(&mut self) {
        if let KeyState::InForce {
            page, has_spare, ..
        } = &mut self.key
            && *has_spare
        {
            let mut keys = KeyPages::new(&mut self.flash, self.layout.key());
            // Whether it is gone shows when it is read back.
            let _ = keys.erase(1 - *page).await;
            *has_spare = !matches!(keys.load(), Ok([None, _] | [_, None]));
        }
    }

    /// Whether there is a key that is not in force.
    pub(super) fn has_spare(&self) -> bool {
        matches!(
            self.key,
            KeyState::InForce {
                has_spare: true,
                ..
            }
        )
    }

    /// Puts a key in force in place of another.
    pub(super) async fn provision(&mut self, key: &Key, unix_s: u64) -> Result<Response, Refusal> {
        let entry = self.entry(Reason::Provision, self.active_id(), unix_s);
        let stored = StoredKey {
            counter: entry.counter,
            unix_s,
            key: key.clone(),
        };
        let old = self.key_page();
        let page = old.map_or(0, |old| 1 - old);
        let made = match self.keys().store(page, &stored).await {
            Ok(()) => self.append(&entry).await,
            Err(_) => Err(Refusal::Flash),
        };
        if made.is_ok() {
            self.key = KeyState::InForce {
                page,
                stored,
                has_spare: old.is_some(),
            };
        } else if let KeyState::InForce { has_spare, .. } = &mut self.key {
            *has_spare = true;
        } else {
            let _ = self.keys().erase(page).await;
        }
        // The entry is there already, and the other key goes.
        let _ = self.enter_owed().await;
        made.map(|()| Response::Done)
    }

    /// The page of the key in force.
    pub(super) fn key_page(&self) -> Option<u8> {
        match self.key {
            KeyState::InForce { page, .. } => Some(page),
            _ => None,
        }
    }
}
