//! The changes: each is made and logged in an order in which no loss of power separates the two.

use embedded_storage_async::nor_flash::NorFlash;

use super::key::KeyState;
use super::{Made, Storage};
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
        let logged = self.enter_owed().await;
        logged.map_err(|_| Refusal::EarlierLog)?;
        let (log, end) = self.log();
        if !log.has_room(end, change.act.reason()) {
            return Err(Refusal::LogFull);
        }
        match &change.act {
            Act::NewVolume { last } => self.new_volume(*last, change.unix_s).await,
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
        let kept = self.kept()?.into_iter().find(is_wanted);
        let kept = kept.ok_or(Refusal::NoSuchSet)?;
        let content = self.read_set(&kept)?;
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
        let sets = self.kept()?.len() as u8;
        let next = self.entry(Reason::FactoryReset, None, unix_s);
        let entry = Entry {
            reset: next.counter,
            ..next
        };
        self.append(&entry).await?;
        self.active = None;
        self.erase_sets().await?;
        Ok(Response::Erased { sets })
    }

    /// Closes the volume of the log whose last entry has this counter, by the first entry of the next one.
    async fn new_volume(&mut self, last: u32, unix_s: u64) -> Result<Response, Refusal> {
        // The entry of a key that is not in force must not leave the volume that is searched for it.
        if self.has_spare() {
            return Err(Refusal::Flash);
        }
        let (log, end) = self.log();
        if end.last_counter() != last {
            return Err(Refusal::LogMoved);
        }
        let page = log.next_page(end);
        let entry = Entry {
            page,
            ..self.entry(Reason::NewVolume, self.active_id(), unix_s)
        };
        self.append(&entry).await?;
        Ok(Response::Done)
    }

    pub(super) async fn append(&mut self, entry: &Entry) -> Result<(), Refusal> {
        let (mut log, end) = self.log();
        let appended = log.append(end, entry).await;
        appended.map_err(|error| match error {
            LogError::Full => Refusal::LogFull,
            LogError::Read | LogError::ReadBack => Refusal::Flash,
        })
    }

    /// Appends the entries of what is done and not logged; if that fails, they precede the next change. A key that is not in
    /// force goes first.
    pub(super) async fn enter_owed(&mut self) -> Result<(), Refusal> {
        self.erase_spare().await;
        // A change, a key and another firmware can be owed. More would follow from a flash that no board wrote.
        for _ in 0..3 {
            let Some(made) = self.owed() else {
                break;
            };
            let next = self.entry(made.reason, made.id, made.unix_s);
            let entry = Entry {
                counter: next.counter.max(made.counter),
                ..next
            };
            self.append(&entry).await.map_err(|_| Refusal::Log)?;
            self.unlogged = None;
        }
        Ok(())
    }

    /// The next of them. What the board enters by itself waits while the log is full.
    fn owed(&mut self) -> Option<Made> {
        let made = if let Some(made) = self.unlogged.or_else(|| self.unlogged_key()) {
            made
        } else {
            let last = self.end.last.as_ref()?;
            if last.build == self.build {
                return None;
            }
            Made {
                counter: 0,
                reason: Reason::FirmwareChange,
                id: last.id,
                unix_s: 0,
            }
        };
        let (log, end) = self.log();
        log.has_room(end, made.reason).then_some(made)
    }
}
