//! A keeper on a flash memory, as a host with the key uses it.

use embassy_futures::block_on;
use hexsense::authority::tag;
use hexsense::keeper::{Command, Keeper};
use hexsense::store::{CoefficientSet, Entry, SetId};
use hexsense::wire::change::{Act, Change, Key, Tag};
use hexsense::wire::message::{CHUNK, Chunk};
use hexsense::wire::{Refusal, Response};
use host_tests::nor_flash::Nor;
use host_tests::sets::{BOARD, encoded, numbered};
use sha2::{Digest, Sha256};

pub const KEY: Key = Key(*b"the key of the board, 32 bytes..");
pub const OTHER_KEY: Key = Key(*b"the key of another, also 32 byte");
/// Pages of the bank that the keeper owns.
pub const PAGES: usize = 128;

/// A keeper that has started, and what it is asked.
pub struct Custody<'f> {
    pub keeper: Keeper<&'f mut Nor>,
    pub now_ms: u64,
    challenges: u8,
}

impl<'f> Custody<'f> {
    /// Starts a keeper on this flash.
    pub fn start(nor: &'f mut Nor) -> Self {
        let (custody, started) = Self::try_start(nor);
        started.unwrap();
        custody
    }

    pub fn try_start(nor: &'f mut Nor) -> (Self, Result<(), Refusal>) {
        let mut keeper = Keeper::new(nor, BOARD);
        let started = block_on(keeper.start());
        let custody = Self {
            keeper,
            now_ms: 0,
            challenges: 0,
        };
        (custody, started)
    }

    pub fn ask(&mut self, command: Command) -> Result<Response, Refusal> {
        self.challenges = self.challenges.wrapping_add(1);
        let random = [self.challenges; 16];
        let fill = async |challenge: &mut [u8; 16]| {
            *challenge = random;
            true
        };
        block_on(self.keeper.carry_out(command, self.now_ms, fill))
    }

    /// A change with its tag for a fresh challenge.
    pub fn signed(&mut self, key: &Key, act: Act) -> (Change, Tag) {
        let Ok(Response::Challenge(challenge)) = self.ask(Command::Challenge) else {
            panic!("no challenge");
        };
        let change = Change {
            unix_s: 1_790_000_000,
            act,
        };
        let tag = tag(key, &challenge, &BOARD, &change);
        (change, tag)
    }

    pub fn change(&mut self, key: &Key, act: Act) -> Result<Response, Refusal> {
        let (change, tag) = self.signed(key, act);
        self.ask(Command::Change(change, tag))
    }

    pub fn provision(&mut self) {
        assert_eq!(self.change(&KEY, Act::Provision(KEY)), Ok(Response::Done));
    }

    pub fn send(&mut self, bytes: &[u8]) -> Result<Response, Refusal> {
        for (index, piece) in bytes.chunks(CHUNK).enumerate() {
            let piece = Chunk::from_slice(piece).unwrap();
            self.ask(Command::Chunk((index * CHUNK) as u16, piece))?;
        }
        self.ask(Command::Commit)
    }

    /// Uploads set `number`.
    pub fn upload(&mut self, number: u32) -> Result<Response, Refusal> {
        let bytes = encoded(&numbered(number));
        self.change(&KEY, upload_of(&bytes))?;
        self.send(&bytes)
    }

    pub fn roll_back(&mut self, number: u32) -> Result<Response, Refusal> {
        self.change(&KEY, Act::Rollback(id(number)))
    }

    /// The active set, read as a host does.
    pub fn active(&mut self) -> Option<CoefficientSet> {
        let Ok(Response::ActiveSet(active)) = self.ask(Command::ActiveSet) else {
            panic!("no answer");
        };
        let mut bytes = Vec::new();
        while bytes.len() < usize::from(active?.length) {
            match self.ask(Command::Read(bytes.len() as u16)) {
                Ok(Response::SetBytes { bytes: piece, .. }) => bytes.extend(piece),
                other => panic!("{other:?}"),
            }
        }
        assert_eq!(CoefficientSet::id_of(&bytes), active?.id);
        Some(CoefficientSet::decode(&bytes).unwrap())
    }

    /// The whole log.
    pub fn log(&mut self) -> Vec<Entry> {
        let mut log = Vec::new();
        loop {
            let counter = log.len() as u32 + 1;
            match self.ask(Command::Log(counter)) {
                Ok(Response::Log { entries, .. }) if entries.is_empty() => return log,
                Ok(Response::Log { entries, .. }) => log.extend(entries),
                other => panic!("{other:?}"),
            }
        }
    }

    /// Identities of the kept sets, newest first.
    pub fn history(&mut self) -> Vec<SetId> {
        let kept = (0..).map_while(|age| match self.ask(Command::History(age)) {
            Ok(Response::Kept(kept)) => kept,
            other => panic!("{other:?}"),
        });
        kept.map(|kept| kept.id).collect()
    }
}

pub fn upload_of(bytes: &[u8]) -> Act {
    Act::Upload {
        length: bytes.len() as u16,
        digest: Sha256::digest(bytes).into(),
    }
}

pub fn id(number: u32) -> SetId {
    CoefficientSet::id_of(&encoded(&numbered(number)))
}
