//! The keeper of the coefficients: what is in flash, who may change it, and the log of changes.
//!
//! Everything about coefficients that a host asks for is answered here, on any flash; the board's storage task only
//! adds the chip. Nothing but this module changes the flash:
//!
//! ```text
//! change, tag ──▶ authority ──▶ upload: pieces → commit ─┐
//!                               │                        └─▶ archive (set and log entry in one) ──▶ log
//!                               rollback ──────────────────▶ log
//!                               factory reset ─────────────▶ log ──▶ archive erased
//!                               provision ─────────────────▶ key ──▶ log
//! ```
//!
//! The first step of each is the one that counts. When the power goes between the two, the next start carries out the
//! second ([`Keeper::complete`]): no change is ever without its entry, and no entry without its change. The active set is
//! the one that the last entry names.

use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;
use sha2::{Digest, Sha256};

use crate::authority::Authority;
use crate::store::key::{KeyPages, StoredKey};
use crate::store::log::{End, Entry, Log, LogError, Reason};
use crate::store::{Archive, ArchiveError, CoefficientSet, History, MAX_ENCODED, SetId, Stored};
use crate::wire::change::{Act, Challenge, Change, Key, Tag};
use crate::wire::message::{ActiveSet, CHUNK, Chunk, Kept};
use crate::wire::{Refusal, Response};

/// Page of the flash, bytes.
const PAGE: u32 = 2_048;
/// Where the sets are: eight pages, so that 10,000 erasures of a page last for 70,000 uploads.
pub const ARCHIVE: u32 = 0;
/// Where the two pages of the key begin.
pub const KEY: u32 = 8 * PAGE;
/// Where the log is: the rest of a bank of 128 pages, 6041 entries.
pub const LOG: Range<u32> = 10 * PAGE..128 * PAGE;
/// How long an upload may take from its tag to its commit, ms.
pub const UPLOAD_MS: u64 = 60_000;

/// What a host may ask about coefficients.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Which set is active?
    ActiveSet,
    /// Bytes of the active set from this offset on.
    Read(u16),
    /// The set so many places older than the newest.
    History(u8),
    /// Entries of the log from this counter on.
    Log(u32),
    /// A challenge.
    Challenge,
    /// A change, with its tag.
    Change(Change, Tag),
    /// The next piece of an upload, and where it belongs.
    Chunk(u16, Chunk),
    /// Check, store, read back, activate.
    Commit,
    /// Forget the upload.
    Abort,
}

type Encoded = heapless::Vec<u8, MAX_ENCODED>;

/// An upload under way.
#[derive(Debug)]
struct Upload {
    length: u16,
    digest: [u8; 32],
    unix_s: u64,
    begun_ms: u64,
    bytes: Encoded,
}

impl Upload {
    /// Whether it is what was announced, a set, and for this board.
    fn check(&self, board: &[u8; 12]) -> Result<(), Refusal> {
        let expected = self.bytes.len() as u16;
        if expected != self.length {
            return Err(Refusal::OutOfOrder { expected });
        }
        if Sha256::digest(&self.bytes)[..] != self.digest {
            return Err(Refusal::WrongIdentity);
        }
        let set = CoefficientSet::decode(&self.bytes).map_err(Refusal::Record)?;
        if set.board == *board {
            Ok(())
        } else {
            Err(Refusal::OtherBoard)
        }
    }
}

/// The active set.
#[derive(Debug, Clone, PartialEq)]
pub struct Active {
    /// Which it is.
    pub set: ActiveSet,
    /// What is in it.
    pub content: CoefficientSet,
    slot: u8,
}

/// The keeper; owns the flash.
pub struct Keeper<F: NorFlash> {
    flash: F,
    board: [u8; 12],
    end: End,
    /// Entry of a change that was made and not logged, because the flash failed.
    unlogged: Option<Entry>,
    /// Whether the archive holds sets from before the last factory reset, and no other.
    is_outdated: bool,
    key: Option<StoredKey>,
    active: Option<Active>,
    authority: Authority,
    upload: Option<Upload>,
}

impl<F: NorFlash> Keeper<F> {
    /// A keeper of the flash of the board with this unique id; [`Self::load`] comes next.
    pub fn new(flash: F, board: [u8; 12]) -> Self {
        Self {
            flash,
            board,
            end: End::default(),
            unlogged: None,
            is_outdated: false,
            key: None,
            active: None,
            authority: Authority::default(),
            upload: None,
        }
    }

    /// Reads what is there and puts the active set to use: one that was uploaded and not logged any more, or the one that
    /// the log names, or the newest when that cannot be read. [`Self::complete`] comes next.
    ///
    /// # Errors
    /// [`Refusal::Flash`] when the flash cannot be read.
    pub async fn load(&mut self) -> Result<(), Refusal> {
        self.end = self.log().end().await.map_err(|_| Refusal::Flash)?;
        self.key = self.keys().load().await.map_err(|_| Refusal::Flash)?;
        let (reset, last) = (self.end.reset, self.end.last_counter());
        let mut history = self.archive().history(0).await.map_err(refusal)?;
        let is_current = |stored: &Stored| stored.entry.counter > reset;
        self.is_outdated = history.first().is_some_and(|newest| !is_current(newest));
        history.retain(is_current);
        let newest = history.first();
        if let Some(uploaded) = newest.filter(|newest| newest.entry.counter > last) {
            self.unlogged = Some(uploaded.entry);
            return self.activate_kept(uploaded).await;
        }
        let Some(id) = self.end.last.and_then(|last| last.id) else {
            return Ok(());
        };
        let named = history.iter().find(|stored| stored.id == id);
        if named.is_none() {
            self.unlogged = Some(Entry {
                previous: Some(id),
                ..self.entry(Reason::Fallback, newest.map(|newest| newest.id), 0)
            });
        }
        match named.or(newest) {
            Some(stored) => self.activate_kept(stored).await,
            None => Ok(()),
        }
    }

    /// Completes what a loss of power interrupted: the log entries of an upload and of a key, and the erasure of sets
    /// from before a factory reset.
    ///
    /// # Errors
    /// [`Refusal::Log`] or [`Refusal::Erasure`] when something could not be completed; what is active is active all the
    /// same.
    pub async fn complete(&mut self) -> Result<(), Refusal> {
        if let Some(entry) = self.unlogged {
            self.follow_up(&entry).await?;
        }
        let key = self.key.as_ref();
        let missing = key.filter(|key| key.counter > self.end.last_counter());
        if let Some(unix_s) = missing.map(|key| key.unix_s) {
            let entry = self.entry(Reason::Provision, self.active_id(), unix_s);
            self.follow_up(&entry).await?;
        }
        if self.is_outdated {
            let erased = self.archive().erase().await;
            erased.map_err(|_| Refusal::Erasure)?;
        }
        Ok(())
    }

    /// Whether there is a key.
    #[must_use]
    pub fn is_provisioned(&self) -> bool {
        self.key.is_some()
    }

    /// The active set.
    #[must_use]
    pub fn active(&self) -> Option<&Active> {
        self.active.as_ref()
    }

    /// Carries out a command at `now_ms`, ms since the start. `random` fills a challenge, and says whether it could.
    ///
    /// # Errors
    /// A [`Refusal`], which says what is wrong.
    pub async fn carry_out(
        &mut self,
        command: Command,
        now_ms: u64,
        random: impl AsyncFnOnce(&mut Challenge) -> bool,
    ) -> Result<Response, Refusal> {
        match command {
            Command::ActiveSet => Ok(Response::ActiveSet(
                self.active.as_ref().map(|active| active.set),
            )),
            Command::Read(offset) => self.read(offset),
            Command::History(age) => self.history(age).await,
            Command::Log(counter) => self.entries(counter).await,
            Command::Challenge => {
                let mut challenge = [0; 16];
                if !random(&mut challenge).await {
                    return Err(Refusal::Random);
                }
                self.authority.open(challenge, now_ms);
                Ok(Response::Challenge(challenge))
            }
            Command::Change(change, tag) => self.change(&change, &tag, now_ms).await,
            Command::Chunk(offset, bytes) => self.chunk(offset, &bytes, now_ms),
            Command::Commit => self.commit(now_ms).await,
            Command::Abort => {
                self.upload = None;
                Ok(Response::Done)
            }
        }
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

    async fn history(&mut self, age: u8) -> Result<Response, Refusal> {
        let history = self.kept().await?;
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
    async fn kept(&mut self) -> Result<History, Refusal> {
        let reset = self.end.reset;
        self.archive().history(reset).await.map_err(refusal)
    }

    async fn entries(&mut self, counter: u32) -> Result<Response, Refusal> {
        let end = self.end;
        let entries = self.log().entries(&end, counter).await;
        Ok(Response::Log {
            last: end.last_counter(),
            entries: entries.map_err(|_| Refusal::Flash)?,
        })
    }

    async fn change(
        &mut self,
        change: &Change,
        tag: &Tag,
        now_ms: u64,
    ) -> Result<Response, Refusal> {
        let key = match (&self.key, &change.act) {
            (Some(stored), _) => &stored.key,
            (None, Act::Provision(key)) => key,
            (None, _) => return Err(Refusal::Unprovisioned),
        };
        self.authority
            .check(key, &self.board, change, tag, now_ms)?;
        self.upload = None;
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

    fn begin(
        &mut self,
        length: u16,
        digest: [u8; 32],
        unix_s: u64,
        begun_ms: u64,
    ) -> Result<Response, Refusal> {
        if length == 0 || usize::from(length) > MAX_ENCODED {
            let limit = MAX_ENCODED as u16;
            return Err(Refusal::Length { length, limit });
        }
        self.upload = Some(Upload {
            length,
            digest,
            unix_s,
            begun_ms,
            bytes: Encoded::new(),
        });
        Ok(Response::Done)
    }

    /// The upload under way, as long as its unlock lasts.
    fn upload(&mut self, now_ms: u64) -> Result<&mut Upload, Refusal> {
        let is_over = |upload: &mut Upload| now_ms.saturating_sub(upload.begun_ms) > UPLOAD_MS;
        if self.upload.take_if(is_over).is_some() {
            return Err(Refusal::Expired);
        }
        self.upload.as_mut().ok_or(Refusal::NoUpload)
    }

    fn chunk(&mut self, offset: u16, bytes: &[u8], now_ms: u64) -> Result<Response, Refusal> {
        let upload = self.upload(now_ms)?;
        let expected = upload.bytes.len() as u16;
        let fits = upload.bytes.len() + bytes.len() <= usize::from(upload.length);
        if offset == expected && fits && upload.bytes.extend_from_slice(bytes).is_ok() {
            Ok(Response::Done)
        } else {
            Err(Refusal::OutOfOrder { expected })
        }
    }

    async fn commit(&mut self, now_ms: u64) -> Result<Response, Refusal> {
        let committed = self.store(now_ms).await;
        self.upload = None;
        committed
    }

    /// Makes the uploaded set the newest in the archive and the active one.
    async fn store(&mut self, now_ms: u64) -> Result<Response, Refusal> {
        let board = self.board;
        let upload = self.upload(now_ms)?;
        upload.check(&board)?;
        let (id, unix_s) = (CoefficientSet::id_of(&upload.bytes), upload.unix_s);
        let entry = self.entry(Reason::Upload, Some(id), unix_s);
        let slot = self.active.as_ref().map(|active| active.slot);
        let upload = self.upload.as_ref().ok_or(Refusal::NoUpload)?;
        let mut archive = Archive::new(&mut self.flash, ARCHIVE);
        let stored = archive.append(&entry, &upload.bytes, slot).await;
        let stored = stored.map_err(refusal)?;
        let content = CoefficientSet::decode(&upload.bytes).map_err(Refusal::Record)?;
        self.activate(&stored, content);
        self.follow_up(&entry).await?;
        self.committed()
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

    fn committed(&self) -> Result<Response, Refusal> {
        let active = self.active.as_ref().ok_or(Refusal::OtherBoard)?;
        Ok(Response::Committed(active.set))
    }

    async fn reset(&mut self, unix_s: u64) -> Result<Response, Refusal> {
        let sets = self.kept().await?.len() as u8;
        let entry = self.entry(Reason::FactoryReset, None, unix_s);
        self.append(&entry).await?;
        self.active = None;
        let erased = self.archive().erase().await;
        erased.map_err(|_| Refusal::Erasure)?;
        Ok(Response::Erased { sets })
    }

    async fn provision(&mut self, key: &Key, unix_s: u64) -> Result<Response, Refusal> {
        let entry = self.entry(Reason::Provision, self.active_id(), unix_s);
        let stored = StoredKey {
            counter: entry.counter,
            unix_s,
            key: key.clone(),
        };
        let kept = self.keys().store(&stored).await;
        kept.map_err(|_| Refusal::Flash)?;
        self.key = Some(stored);
        self.follow_up(&entry).await?;
        Ok(Response::Done)
    }

    fn entry(&self, reason: Reason, id: Option<SetId>, unix_s: u64) -> Entry {
        Entry {
            counter: self.end.next_counter(),
            reason,
            unix_s,
            id,
            previous: self.active_id(),
        }
    }

    async fn append(&mut self, entry: &Entry) -> Result<(), Refusal> {
        let mut end = self.end;
        let appended = self.log().append(&mut end, entry).await;
        self.end = end;
        appended.map_err(|error| match error {
            LogError::Full => Refusal::LogFull,
            LogError::Flash(_) | LogError::ReadBack => Refusal::Flash,
        })
    }

    /// Appends the entry of a change that is made; if that fails it comes before the next change.
    async fn follow_up(&mut self, entry: &Entry) -> Result<(), Refusal> {
        self.unlogged = Some(*entry);
        self.append(entry).await.map_err(|_| Refusal::Log)?;
        self.unlogged = None;
        Ok(())
    }

    async fn activate_kept(&mut self, stored: &Stored) -> Result<(), Refusal> {
        let content = self.read_set(stored).await?;
        self.activate(stored, content);
        Ok(())
    }

    async fn read_set(&mut self, stored: &Stored) -> Result<CoefficientSet, Refusal> {
        let set = self.archive().read(stored.slot).await.map_err(refusal)?;
        set.ok_or(Refusal::Flash)
    }

    /// Puts a stored set to use; one of another board, whose flash came here, is not.
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

    fn active_id(&self) -> Option<SetId> {
        self.active.as_ref().map(|active| active.set.id)
    }

    fn archive(&mut self) -> Archive<&mut F> {
        Archive::new(&mut self.flash, ARCHIVE)
    }

    fn keys(&mut self) -> KeyPages<&mut F> {
        KeyPages::new(&mut self.flash, KEY)
    }

    fn log(&mut self) -> Log<&mut F> {
        Log::new(&mut self.flash, LOG)
    }
}

fn refusal<E>(error: ArchiveError<E>) -> Refusal {
    match error {
        ArchiveError::Record(error) => Refusal::Record(error),
        ArchiveError::Flash(_) | ArchiveError::ReadBack => Refusal::Flash,
    }
}
