//! The start: which set is active, and which work a loss of power left over.

use embedded_storage_async::nor_flash::NorFlash;

use super::key::KeyState;
use super::{Made, Storage, refusal};
use crate::records::log::Reason;
use crate::records::{BuildId, Stored};
use crate::wire::Refusal;

impl<F: NorFlash> Storage<F> {
    /// Reads the flash and activates a set: an uploaded set without its log entry, or the set that the log names, or
    /// the newest when that cannot be read. [`Self::complete`] comes next.
    ///
    /// # Errors
    /// [`Refusal::Flash`] when the flash cannot be read.
    pub fn load(&mut self) -> Result<(), Refusal> {
        let (mut log, end) = self.log();
        *end = log.end().map_err(|_| Refusal::Flash)?;
        let (reset, last) = (self.end.reset(), self.end.last_counter());
        let mut history = self.archive().history(0).map_err(refusal)?;
        self.find_key(last > 0 || !history.is_empty())?;
        let is_current = |stored: &Stored| stored.entry.counter > reset;
        self.is_outdated = history.first().is_some_and(|newest| !is_current(newest));
        history.retain(is_current);
        let newest = history.first();
        if let Some(uploaded) = newest.filter(|newest| newest.entry.counter > last) {
            self.unlogged = Some(Made::of(&uploaded.entry));
            return self.activate_kept(uploaded);
        }
        let Some(id) = self.end.last.and_then(|last| last.id) else {
            // A board without a key never had a record.
            self.is_foreign = matches!(self.key, KeyState::None)
                && !self.log().0.is_blank().map_err(|_| Refusal::Flash)?;
            return Ok(());
        };
        let named = history.iter().find(|stored| stored.id == id);
        if named.is_none() {
            self.unlogged = Some(Made {
                counter: 0,
                reason: Reason::Fallback,
                id: newest.map(|newest| newest.id),
                unix_s: 0,
            });
        }
        match named.or(newest) {
            Some(stored) => self.activate_kept(stored),
            None => Ok(()),
        }
    }

    /// Completes what a loss of power interrupted: the log entries of an upload and of a first key, and the
    /// erasure of a key that is not in force and of sets from before a factory reset. A firmware that is not that of the
    /// last entry then gets an entry of its own. What the board itself enters waits while the log is full. `build` is the
    /// firmware.
    ///
    /// # Errors
    /// [`Refusal::Log`] or [`Refusal::Erasure`] when a step fails; the active set stays active.
    pub async fn complete(&mut self, build: BuildId) -> Result<(), Refusal> {
        self.build = build;
        if self.read_only {
            return Ok(());
        }
        self.enter_owed().await?;
        if self.is_outdated {
            self.erase_sets().await?;
        }
        Ok(())
    }

    fn activate_kept(&mut self, stored: &Stored) -> Result<(), Refusal> {
        let content = self.read_set(stored)?;
        self.activate(stored, content);
        Ok(())
    }
}
