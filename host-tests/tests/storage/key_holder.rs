//! A storage on a flash memory, as a host with the key uses it.

use std::ops::{Deref, DerefMut};

use hexsense_core::records::{CoefficientSet, SetId};
use hexsense_core::storage::StorageCommand;
use hexsense_core::wire::change::{Act, Change, Key, Tag};
use hexsense_core::wire::{Refusal, Response};
use host_tests::nor_flash::Nor;
use host_tests::sets::{encoded, numbered};
use hostile::key_holder;

pub use key_holder::{KEY, OTHER_KEY, upload_of};

/// Pages of the bank that the storage owns.
pub const PAGES: usize = 128;

/// A started storage, for questions about sets by their number.
pub struct KeyHolder<'f>(key_holder::KeyHolder<&'f mut Nor>);

impl<'f> Deref for KeyHolder<'f> {
    type Target = key_holder::KeyHolder<&'f mut Nor>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for KeyHolder<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl<'f> KeyHolder<'f> {
    /// Starts a storage on this flash.
    pub fn start(nor: &'f mut Nor) -> Self {
        let (key_holder, started) = Self::try_start(nor);
        started.unwrap();
        key_holder
    }

    pub fn try_start(nor: &'f mut Nor) -> (Self, Result<(), Refusal>) {
        let (key_holder, started) = key_holder::KeyHolder::start(nor);
        (Self(key_holder), started)
    }

    /// A change with its tag for a fresh challenge.
    pub fn signed(&mut self, key: &Key, act: Act) -> (Change, Tag) {
        let challenge = self.challenge();
        key_holder::signed(key, &challenge, act)
    }

    /// Starts a storage on erased flash, and gives it a key and sets 1 to `last`.
    pub fn with_sets(nor: &'f mut Nor, last: u32) -> Self {
        let mut key_holder = Self::start(nor);
        key_holder.provision();
        for number in 1..=last {
            key_holder.upload(number).unwrap();
        }
        key_holder
    }

    pub fn provision(&mut self) {
        assert_eq!(self.change(&KEY, Act::Provision(KEY)), Ok(Response::Done));
    }

    /// Uploads set `number`.
    pub fn upload(&mut self, number: u32) -> Result<Response, Refusal> {
        self.0.upload(&KEY, &encoded(&numbered(number)))
    }

    /// Begins a new volume of the log.
    pub fn new_volume(&mut self) -> Result<Response, Refusal> {
        let last = self.log().last().unwrap().counter;
        self.change(&KEY, Act::NewVolume { last })
    }

    pub fn roll_back(&mut self, number: u32) -> Result<Response, Refusal> {
        self.change(&KEY, Act::Rollback(id(number)))
    }

    /// The active set, read as a host does.
    pub fn active(&mut self) -> Option<CoefficientSet> {
        let Ok(Response::ActiveSet(active)) = self.ask(StorageCommand::ActiveSet) else {
            panic!("no answer");
        };
        let mut bytes = Vec::new();
        while bytes.len() < usize::from(active?.length) {
            match self.ask(StorageCommand::Read(bytes.len() as u16)) {
                Ok(Response::SetBytes { bytes: piece, .. }) => bytes.extend(piece),
                other => panic!("{other:?}"),
            }
        }
        assert_eq!(CoefficientSet::id_of(&bytes), active?.id);
        Some(CoefficientSet::decode(&bytes).unwrap())
    }

    /// Identities of the kept sets, newest first.
    pub fn history(&mut self) -> Vec<SetId> {
        let kept = (0..).map_while(|age| match self.ask(StorageCommand::History(age)) {
            Ok(Response::Kept(kept)) => kept,
            other => panic!("{other:?}"),
        });
        kept.map(|kept| kept.id).collect()
    }
}

pub fn id(number: u32) -> SetId {
    CoefficientSet::id_of(&encoded(&numbered(number)))
}

/// A change of each kind, possible on a board with sets 1 and 2.
pub fn acts() -> Vec<Act> {
    vec![
        upload_of(&encoded(&numbered(3))),
        Act::Rollback(id(1)),
        Act::FactoryReset,
        Act::Provision(OTHER_KEY),
        Act::NewVolume { last: 1 },
    ]
}
