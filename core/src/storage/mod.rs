//! The storage of the coefficients: the content of the flash, the right to change it, and the log of changes.
//!
//! This module answers all requests about coefficients, on any flash; the board's storage task only adds the chip. Only
//! this module changes the flash:
//!
//! ```text
//! change, tag ──▶ authority ──▶ upload: pieces → commit ─┐
//!                               │                        └─▶ archive (set and log entry in one) ──▶ log
//!                               rollback ──────────────────▶ log
//!                               factory reset ─────────────▶ log ──▶ archive erased
//!                               provision ─────────────────▶ key beside the old one ──▶ log ──▶ old one erased
//!                               new volume ────────────────▶ log
//! ```
//!
//! The first step of each change decides, and for a key its entry in the log. When the power goes between two steps, the
//! next start carries out the rest ([`Storage::complete`]): no change is without its entry, and no entry without its
//! change. The last entry names the active set.
//!
//! The start, an upload, the key and the changes have files of their own.

mod changes;
mod key;
mod start;
mod upload;

use embedded_storage_async::nor_flash::NorFlash;

use self::key::KeyState;
use self::upload::Upload;
use crate::authority::{self, Authority};
use crate::facts::FlashLayout;
use crate::records::key::KeyPages;
use crate::records::log::{End, Entry, Log, Reason};
use crate::records::{
    Archive, ArchiveError, BuildId, CoefficientSet, History, MAX_ENCODED, SetId, Stored,
};
use crate::wire::change::{Challenge, Change, ProofChallenge, Statement, Tag};
use crate::wire::log::{Nonce, Volume};
use crate::wire::message::{ActiveSet, CHUNK, Chunk, Kept};
use crate::wire::{Refusal, Response};

/// Longest time of an upload from its tag to its commit, ms.
pub const UPLOAD_MS: u64 = 60_000;

/// Shortest time from one proof to the next, ms: a flood of requests for proofs does not take the core's time.
pub const PROOF_MS: u64 = 10;

/// The requests of a host about coefficients.
#[derive(Debug, Clone, PartialEq)]
pub enum StorageCommand {
    /// Which set is active?
    ActiveSet,
    /// Bytes of the active set from this offset on.
    Read(u16),
    /// The set that is this many places older than the newest.
    History(u8),
    /// Entries of the log from this counter on.
    Log(u32),
    /// A proof of the log over this number of the host's.
    LogProof(Nonce),
    /// A challenge.
    Challenge,
    /// A change, with its tag.
    Change(Change, Tag),
    /// The next piece of an upload, and its offset.
    Chunk(u16, Chunk),
    /// Check, store, read back, activate.
    Commit,
    /// Forget the upload.
    Abort,
    /// Prove the key to this challenge of the host.
    Prove(ProofChallenge),
}

impl StorageCommand {
    /// Whether it changes what the board keeps, or is a step of such a change.
    #[must_use]
    pub const fn is_change(&self) -> bool {
        matches!(self, Self::Change(..) | Self::Chunk(..) | Self::Commit)
    }
}

/// The active set.
#[derive(Debug, Clone, PartialEq)]
pub struct Active {
    /// Its identity, number and length.
    pub set: ActiveSet,
    /// Its coefficients.
    pub content: CoefficientSet,
    slot: u8,
}

/// What an entry of the log says of a change.
#[derive(Debug, Clone, Copy)]
struct Made {
    /// Counter that it has already in the archive or with the key, or zero: the log goes on there when its end is lost.
    counter: u32,
    reason: Reason,
    id: Option<SetId>,
    unix_s: u64,
}

impl Made {
    fn of(entry: &Entry) -> Self {
        Self {
            counter: entry.counter,
            reason: entry.reason,
            id: entry.id,
            unix_s: entry.unix_s,
        }
    }
}

/// The storage; owns the flash.
pub struct Storage<F: NorFlash> {
    flash: F,
    layout: FlashLayout,
    board: [u8; 12],
    /// The firmware; zeros until the start is complete.
    build: BuildId,
    end: End,
    /// A change that is made and not logged: the power went in between, or the flash failed.
    unlogged: Option<Made>,
    /// Whether the archive holds only sets from before the last factory reset.
    is_outdated: bool,
    /// Whether the flash had no record at the start and is not erased.
    is_foreign: bool,
    key: KeyState,
    active: Option<Active>,
    authority: Authority,
    next_proof_ms: u64,
    upload: Option<Upload>,
    read_only: bool,
}

impl<F: NorFlash> Storage<F> {
    /// The storage of the board with this unique id in `flash`, divided by `layout`; [`Self::load`] comes next.
    pub fn new(flash: F, layout: FlashLayout, board: [u8; 12]) -> Self {
        Self {
            flash,
            layout,
            board,
            build: BuildId::default(),
            end: End::default(),
            unlogged: None,
            is_outdated: false,
            is_foreign: false,
            key: KeyState::Damaged,
            active: None,
            authority: Authority::default(),
            next_proof_ms: 0,
            upload: None,
            read_only: false,
        }
    }

    /// Never writes nor erases the flash from now on, because the chip's option bytes do not allow it. Everything can be
    /// read, and each change is refused as [`Refusal::OptionBytes`].
    pub fn forbid_changes(&mut self) {
        self.read_only = true;
    }

    /// Whether there is a key.
    #[must_use]
    pub fn is_provisioned(&self) -> bool {
        matches!(self.key, KeyState::InForce { .. })
    }

    /// Whether there was a key, and no copy of it is good: no change is taken then.
    #[must_use]
    pub fn is_key_damaged(&self) -> bool {
        matches!(self.key, KeyState::Damaged)
    }

    /// The active set.
    #[must_use]
    pub fn active(&self) -> Option<&Active> {
        self.active.as_ref()
    }

    /// Carries out a command at `now_ms`, ms since the start. `random` fills a challenge and returns whether it
    /// succeeded.
    ///
    /// # Errors
    /// A [`Refusal`], which names the problem.
    pub async fn carry_out(
        &mut self,
        command: StorageCommand,
        now_ms: u64,
        random: impl AsyncFnOnce(&mut Challenge) -> bool,
    ) -> Result<Response, Refusal> {
        if self.read_only && command.is_change() {
            return Err(Refusal::OptionBytes);
        }
        match command {
            StorageCommand::ActiveSet => Ok(Response::ActiveSet(
                self.active.as_ref().map(|active| active.set),
            )),
            StorageCommand::Read(offset) => self.read(offset),
            StorageCommand::History(age) => self.history(age),
            StorageCommand::Log(counter) => self.entries(counter),
            StorageCommand::LogProof(nonce) => self.prove_log(&nonce),
            StorageCommand::Challenge => {
                let mut challenge = [0; 16];
                if !random(&mut challenge).await {
                    return Err(Refusal::Random);
                }
                self.authority.open(challenge, now_ms);
                Ok(Response::Challenge(challenge))
            }
            StorageCommand::Change(change, tag) => self.change(&change, &tag, now_ms).await,
            StorageCommand::Chunk(offset, bytes) => self.chunk(offset, &bytes, now_ms),
            StorageCommand::Commit => self.commit(now_ms).await,
            StorageCommand::Abort => {
                self.upload = None;
                Ok(Response::Done)
            }
            StorageCommand::Prove(challenge) => self.prove(&challenge, now_ms),
        }
    }

    fn prove(&mut self, challenge: &ProofChallenge, now_ms: u64) -> Result<Response, Refusal> {
        if now_ms < self.next_proof_ms {
            return Err(Refusal::Busy);
        }
        self.next_proof_ms = now_ms.saturating_add(PROOF_MS);
        self.authority.close();
        self.upload = None;
        let statement = Statement {
            set: self.active_id(),
            changes: self.end.last_counter(),
        };
        let key = self.key.in_force()?;
        let tag = authority::proof(key, challenge, &self.board, &self.build, &statement);
        Ok(Response::Proof { statement, tag })
    }

    fn read(&self, offset: u16) -> Result<Response, Refusal> {
        let active = self.active.as_ref().ok_or(Refusal::NoSet)?;
        let mut buffer = [0; MAX_ENCODED];
        let encoded = active
            .content
            .encode(&mut buffer)
            .map_err(Refusal::Record)?;
        let rest = encoded.get(usize::from(offset)..).ok_or(Refusal::Offset {
            offset,
            length: active.set.length,
        })?;
        let bytes = rest.iter().copied().take(CHUNK).collect();
        Ok(Response::SetBytes { offset, bytes })
    }

    fn history(&mut self, age: u8) -> Result<Response, Refusal> {
        let history = self.kept()?;
        Ok(Response::Kept(history.get(usize::from(age)).map(
            |stored| Kept {
                sequence: stored.entry.counter,
                id: stored.id,
                length: stored.length,
                made_unix_s: stored.made_unix_s,
                uploaded_unix_s: stored.entry.unix_s,
            },
        )))
    }

    /// The sets since the last factory reset.
    fn kept(&mut self) -> Result<History, Refusal> {
        let reset = self.end.reset();
        self.archive().history(reset).map_err(refusal)
    }

    fn entries(&mut self, counter: u32) -> Result<Response, Refusal> {
        let (mut log, end) = self.log();
        let last = end.last_counter();
        let entries = log.entries(end, counter).map_err(|_| Refusal::Flash)?;
        Ok(Response::Log { last, entries })
    }

    /// Places of the log's volume that are used; `None` when the flash has no record of this firmware and is not erased.
    #[must_use]
    pub fn log_used(&mut self) -> Option<u32> {
        let is_foreign = self.is_foreign;
        let (log, end) = self.log();
        (!is_foreign || end.last.is_some()).then(|| log.used(end))
    }

    /// The log's volume, signed with the key.
    fn prove_log(&self, nonce: &Nonce) -> Result<Response, Refusal> {
        let key = self.key.in_force()?;
        let volume = Volume {
            first: self.end.first,
            last: self.end.last_counter(),
            head: self.end.head(),
            build: self.build,
        };
        let mac = authority::log_mac(key, nonce, &self.board, &volume);
        Ok(Response::LogProof { volume, mac })
    }

    /// The next entry of the log.
    fn entry(&self, reason: Reason, id: Option<SetId>, unix_s: u64) -> Entry {
        Entry {
            counter: self.end.next_counter(),
            reason,
            unix_s,
            id,
            previous: self.end.last.and_then(|last| last.id),
            build: self.build,
            chain: self.end.head(),
            reset: self.end.reset(),
            page: self.end.page(),
        }
    }

    /// Reads the active set from the flash again, so that no flaw of the RAM stays in it. Where the flash gives it no more,
    /// the set in RAM stays; the next start looks for another.
    pub fn refresh(&mut self) {
        let Some((slot, id)) = self
            .active
            .as_ref()
            .map(|active| (active.slot, active.set.id))
        else {
            return;
        };
        let read = self.archive().read(slot, id);
        if let (Ok(Some(content)), Some(active)) = (read, &mut self.active) {
            active.content = content;
        }
    }

    fn read_set(&mut self, stored: &Stored) -> Result<CoefficientSet, Refusal> {
        let set = self.archive().read(stored.slot, stored.id);
        let set = set.map_err(refusal)?;
        set.ok_or(Refusal::Flash)
    }

    /// Activates a stored set, unless it belongs to another board, which is possible when flash is copied.
    fn activate(&mut self, stored: &Stored, content: CoefficientSet) {
        self.active = (content.board == self.board).then_some(Active {
            set: ActiveSet {
                id: stored.id,
                sequence: stored.entry.counter,
                length: stored.length,
            },
            content,
            slot: stored.slot,
        });
    }

    async fn erase_sets(&mut self) -> Result<(), Refusal> {
        let erased = self.archive().erase().await;
        erased.map_err(|_| Refusal::Erasure)
    }

    fn active_id(&self) -> Option<SetId> {
        self.active.as_ref().map(|active| active.set.id)
    }

    fn archive(&mut self) -> Archive<&mut F> {
        Archive::new(&mut self.flash, FlashLayout::ARCHIVE)
    }

    fn keys(&mut self) -> KeyPages<&mut F> {
        KeyPages::new(&mut self.flash, self.layout.key())
    }

    /// The log, and its end.
    fn log(&mut self) -> (Log<&mut F>, &mut End) {
        let log = Log::new(&mut self.flash, self.layout.log());
        (log, &mut self.end)
    }
}

fn refusal<E>(error: ArchiveError<E>) -> Refusal {
    match error {
        ArchiveError::Record(error) => Refusal::Record(error),
        ArchiveError::OtherBoard => Refusal::OtherBoard,
        ArchiveError::Flash(_) | ArchiveError::Read | ArchiveError::ReadBack => Refusal::Flash,
    }
}
