//! The changes: each is made and logged in an order in which no loss of power separates the two.

use embedded_storage_async::nor_flash::NorFlash;

use super::Storage;
use super::key::KeyState;
use crate::records::log::{Entry, LogError, Reason};
use crate::records::{SetId, Stored};
use crate::wire::change::{Act, Change, Tag};
use crate::wire::{Refusal, Response};

impl<F: NorFlash> Storage<F> {
    pub(super) async fn change(
        &mut self,
        change: &Change,
        tag: &Tag,
        now_ms: u64,
    ) -> Result<Response, Refusal> {
        let key = match (&self.key, &change.act) {
            (KeyState::None, Act::Provision(key)) => key,
            (state, _) => state.in_force()?,
        };
        self.authority
            .check(key, &self.board, change, tag, now_ms)?;
        let is_same =
            self.is_provisioned() && matches!(&change.act, Act::Provision(new) if new == key);
        self.upload = None;
        if is_same {
            return Err(Refusal::SameKey);
        }
        if let Some(entry) = self.unlogged {
            let logged = self.follow_up(&entry).await;
            logged.map_err(|_| Refusal::EarlierLog)?;
        }
        let end = self.end;
        if !self.log().has_room(&end) {
            return Err(Refusal::LogFull);
        }
        match &change.act {
            Act::Upload { length, digest } => self.begin(*length, *digest, change.unix_s, now_ms),
            Act::Rollback(id) => self.roll_back(*id, change.unix_s).await,
            Act::FactoryReset => self.reset(change.unix_s).await,
            Act::Provision(key) => self.provision(key, change.unix_s).await,
        }
    }

    async fn roll_back(&mut self, id: SetId, unix_s: u64) -> Result<Response, Refusal> {
        if self.active_id() == Some(id) {
            return Err(Refusal::AlreadyActive);
        }
        let is_wanted = |stored: &Stored| stored.id == id;
        let kept = self.kept().await?.into_iter().find(is_wanted);
        let kept = kept.ok_or(Refusal::NoSuchSet)?;
        let content = self.read_set(&kept).await?;
        let entry = self.entry(Reason::Rollback, Some(id), unix_s);
        self.append(&entry).await?;
        self.activate(&kept, content);
        self.committed()
    }

    pub(super) fn committed(&self) -> Result<Response, Refusal> {
        let active = self.active.as_ref().ok_or(Refusal::OtherBoard)?;
        Ok(Response::Committed(active.set))
    }

    async fn reset(&mut self, unix_s: u64) -> Result<Response, Refusal> {
        let sets = self.kept().await?.len() as u8;
        let entry = self.entry(Reason::FactoryReset, None, unix_s);
        self.append(&entry).await?;
        self.active = None;
        self.erase_sets().await?;
        Ok(Response::Erased { sets })
    }

    pub(super) async fn append(&mut self, entry: &Entry) -> Result<(), Refusal> {
        let mut end = self.end;
        let appended = self.log().append(&mut end, entry).await;
        self.end = end;
        appended.map_err(|error| match error {
            LogError::Full => Refusal::LogFull,
            LogError::Flash(_) | LogError::ReadBack => Refusal::Flash,
        })
    }

    /// Appends the entry of a change that is made; if that fails, the entry precedes the next change.
    pub(super) async fn follow_up(&mut self, entry: &Entry) -> Result<(), Refusal> {
        self.unlogged = Some(*entry);
        self.append(entry).await.map_err(|_| Refusal::Log)?;
        self.unlogged = None;
        Ok(())
    }
}
