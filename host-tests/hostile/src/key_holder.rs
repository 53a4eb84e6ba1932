//! A storage on a flash memory whose power can be cut at any operation, and the host that asks it.

use std::cell::RefCell;

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use hexsense_core::authority::tag;
use hexsense_core::records::{BuildId, CoefficientSet, Entry, SetId};
use hexsense_core::storage::{Storage, StorageCommand};
use hexsense_core::wire::change::{Act, Challenge, Change, Key, Tag};
use hexsense_core::wire::message::{CHUNK, Chunk};
use hexsense_core::wire::{Refusal, Response};
use sha2::{Digest, Sha256};

use crate::nor_flash::{Fault, Nor, PAGE, layout};
use crate::sets::{BOARD, BUILD};

/// Pages of the memory: archive, key, and a log of 128 places. The board's is longer.
pub const PAGES: usize = 14;
/// Key of the board.
pub const KEY: Key = Key(*b"the key of the board, 32 bytes..");
/// Key of another.
pub const OTHER_KEY: Key = Key(*b"the key of another, also 32 byte");
/// The keys of hosts.
pub const KEYS: [Key; 2] = [KEY, OTHER_KEY];

/// Flash that the storage owns and that the test can inspect.
#[derive(Clone, Copy)]
pub struct Shared<'f>(pub &'f RefCell<Nor>);

impl ErrorType for Shared<'_> {
    type Error = Fault;
}

// An operation never waits, so no other borrow of the memory is open.
#[allow(clippy::await_holding_refcell_ref)]
impl ReadNorFlash for Shared<'_> {
    const READ_SIZE: usize = Nor::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        self.0.borrow_mut().read(offset, bytes).await
    }

    fn capacity(&self) -> usize {
        self.0.borrow().capacity()
    }
}

#[allow(clippy::await_holding_refcell_ref)]
impl NorFlash for Shared<'_> {
    const WRITE_SIZE: usize = Nor::WRITE_SIZE;
    const ERASE_SIZE: usize = Nor::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        self.0.borrow_mut().erase(from, to).await
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        self.0.borrow_mut().write(offset, bytes).await
    }
}

/// A board from the host's side.
pub struct KeyHolder<F: NorFlash> {
    /// The storage that answers.
    pub storage: Storage<F>,
    /// Time since the start, ms.
    pub now_ms: u64,
    /// Number of challenges so far: the board draws random ones, which never come twice.
    pub(crate) challenges: u64,
}

impl<F: NorFlash> KeyHolder<F> {
    /// Starts a board with this flash, and returns the result of the start.
    pub fn start(flash: F) -> (Self, Result<(), Refusal>) {
        Self::start_with(flash, BUILD)
    }

    /// Starts a board with this flash and firmware.
    pub fn start_with(flash: F, build: BuildId) -> (Self, Result<(), Refusal>) {
        let pages = flash.capacity() / PAGE;
        let mut storage = Storage::new(flash, layout(pages), BOARD);
        let started = block_on(async {
            storage.load()?;
            storage.complete(build).await
        });
        let key_holder = Self {
            storage,
            now_ms: 0,
            challenges: 0,
        };
        (key_holder, started)
    }

    /// The answer to a command.
    pub fn ask(&mut self, command: StorageCommand) -> Result<Response, Refusal> {
        self.challenges += 1;
        let mut random = [0xA5; 16];
        random[..8].copy_from_slice(&self.challenges.to_le_bytes());
        let fill = async |challenge: &mut Challenge| {
            *challenge = random;
            true
        };
        block_on(self.storage.carry_out(command, self.now_ms, fill))
    }

    /// A fresh challenge.
    ///
    /// # Panics
    /// When there is none.
    pub fn challenge(&mut self) -> Challenge {
        match self.ask(StorageCommand::Challenge) {
            Ok(Response::Challenge(challenge)) => challenge,
            other => panic!("no challenge: {other:?}"),
        }
    }

    /// Asks for a change with this key.
    pub fn change(&mut self, key: &Key, act: Act) -> Result<Response, Refusal> {
        let challenge = self.challenge();
        let (change, tag) = signed(key, &challenge, act);
        self.ask(StorageCommand::Change(change, tag))
    }

    /// Sends all pieces of a set whose upload has begun, and commits it.
    pub fn send(&mut self, bytes: &[u8]) -> Result<Response, Refusal> {
        for (index, piece) in bytes.chunks(CHUNK).enumerate() {
            let piece = piece.iter().copied().collect::<Chunk>();
            self.ask(StorageCommand::Chunk((index * CHUNK) as u16, piece))?;
        }
        self.ask(StorageCommand::Commit)
    }

    /// Uploads a set with this key.
    pub fn upload(&mut self, key: &Key, bytes: &[u8]) -> Result<Response, Refusal> {
        self.change(key, upload_of(bytes))?;
        self.send(bytes)
    }

    /// Identity of the active set.
    #[must_use]
    pub fn active(&self) -> Option<SetId> {
        self.storage.active().map(|active| active.set.id)
    }

    /// The whole log.
    ///
    /// # Panics
    /// When it cannot be read.
    pub fn log(&mut self) -> Vec<Entry> {
        let mut log: Vec<Entry> = Vec::new();
        loop {
            let counter = log.last().map_or(1, |last| last.counter + 1);
            match self.ask(StorageCommand::Log(counter)) {
                Ok(Response::Log { entries, .. }) if entries.is_empty() => return log,
                Ok(Response::Log { entries, .. }) => log.extend(entries),
                other => panic!("no log: {other:?}"),
            }
        }
    }
}

/// A change with its tag.
#[must_use]
pub fn signed(key: &Key, challenge: &Challenge, act: Act) -> (Change, Tag) {
    let change = Change {
        unix_s: 1_790_000_000,
        act,
    };
    let tag = tag(key, challenge, &BOARD, &change);
    (change, tag)
}

/// The announcement of a set.
#[must_use]
pub fn upload_of(bytes: &[u8]) -> Act {
    Act::Upload {
        length: bytes.len() as u16,
        digest: Sha256::digest(bytes).into(),
    }
}

/// Identity of a set that was announced with this digest.
#[must_use]
pub fn announced(digest: &[u8; 32]) -> SetId {
    let mut id = SetId::default();
    id.0.copy_from_slice(&digest[..8]);
    id
}

/// Identity of encoded bytes.
#[must_use]
pub fn id(bytes: &[u8]) -> SetId {
    CoefficientSet::id_of(bytes)
}
