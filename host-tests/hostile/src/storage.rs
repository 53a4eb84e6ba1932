//! Commands in any order, at any time, from hosts with and without the key, with the power cut at any operation.
//!
//! In every case the active set is one that the key holder committed, the log's counters have no gap and its last entry
//! names the active set, a wrong tag changes no word of flash, and in the end the board takes a good upload.

use std::cell::RefCell;

use hexsense_core::authority::MAX_WAIT_MS;
use hexsense_core::records::log::Reason;
use hexsense_core::records::{Entry, SetId};
use hexsense_core::storage::StorageCommand;
use hexsense_core::wire::change::{Act, Challenge, Change, Key, Tag};
use hexsense_core::wire::message::{CHUNK, Chunk};
use hexsense_core::wire::{Refusal, Response};

use crate::bases::{BASES, CONTENTS, GOOD};
use crate::input::Input;
use crate::key_holder::{KEYS, KeyHolder, Shared, announced, id, signed, upload_of};
use crate::nor_flash::{Nor, Torn};

/// Most commands of an attack; more take time and find no new cases.
const COMMANDS: usize = 32;
/// The first byte picks the board's history, the others are commands.
///
/// # Panics
/// When a promise is broken.
pub fn run(data: &[u8]) {
    let mut input = Input(data);
    // The full archive is rare, because it takes ten times as long.
    let base = match input.byte() {
        255 => 4,
        byte => usize::from(byte % 4),
    };
    let nor = RefCell::new(BASES[base].clone());
    let mut attack = Attack::on(&nor, base);
    for _ in 0..COMMANDS {
        if input.is_empty() {
            break;
        }
        attack.step(&mut input);
    }
    attack.end();
}

/// An attack, and the possible states of the board after it.
struct Attack<'f> {
    nor: &'f RefCell<Nor>,
    key_holder: KeyHolder<Shared<'f>>,
    challenge: Option<Challenge>,
    heard: Option<(Change, Tag)>,
    /// Keys that the board may have: two after a power cut in a provisioning.
    keys: Vec<Option<Key>>,
    /// Sets that may be active: two after a power cut in a change of the active set.
    active: Vec<Option<SetId>>,
    /// Sets that were committed since the last factory reset.
    kept: Vec<SetId>,
    /// The upload that the key holder announced.
    upload: Option<SetId>,
    /// The bytes under way, and the number already sent.
    sent: (usize, usize),
}

impl<'f> Attack<'f> {
    fn on(nor: &'f RefCell<Nor>, base: usize) -> Self {
        let (key_holder, started) = KeyHolder::start(Shared(nor));
        assert_eq!(started, Ok(()));
        Self {
            nor,
            challenge: None,
            heard: None,
            keys: vec![(base > 0).then(|| KEYS[0].clone())],
            active: vec![key_holder.active()],
            kept: CONTENTS[..base.saturating_sub(1).min(GOOD)]
                .iter()
                .map(|content| id(content))
                .collect(),
            upload: None,
            sent: (0, 0),
            key_holder,
        }
    }

    fn step(&mut self, input: &mut Input) {
        match input.byte() % 13 {
            0 => self.key_holder.now_ms += u64::from(input.short()),
            1 => self.challenge = Some(self.key_holder.challenge()),
            2 => {
                let (act, key) = (self.act(input), input.pick(&[&KEYS[0], &KEYS[1]]));
                self.signed_change(act, key, 0);
            }
            3 => {
                let (act, flipped) = (self.act(input), input.byte());
                self.signed_change(act, &KEYS[0], flipped);
            }
            4 => self.piece(),
            5 => {
                let (offset, length) = (input.short(), input.byte());
                let bytes = input.bytes(usize::from(length).min(CHUNK));
                self.ask(StorageCommand::Chunk(
                    offset,
                    bytes.iter().copied().collect(),
                ));
            }
            6 => self.commit(),
            7 => self.ask(StorageCommand::Abort),
            8 => self.whole_upload(usize::from(input.byte())),
            9 => self.question(input),
            10 => {
                let (operations, torn) = (input.short() % 512, input.pick(&Torn::ALL));
                let seed = u64::from(operations);
                let mut nor = self.nor.borrow_mut();
                nor.cut_after(operations.into(), torn, seed);
            }
            11 => {
                let cut = input.byte();
                self.restart((cut > 0).then_some((cut.into(), input.pick(&Torn::ALL))));
            }
            _ => {
                if let Some((change, tag)) = self.heard.clone() {
                    // A challenge serves once.
                    self.change(change, tag, None);
                }
            }
        }
    }

    fn act(&mut self, input: &mut Input) -> Act {
        let byte = input.byte();
        if byte >= 248 {
            let proof = self.key_holder.ask(StorageCommand::LogProof([byte; 32]));
            return match proof {
                Ok(Response::LogProof { volume, .. }) => Act::NewVolume { last: volume.last },
                _ => Act::NewVolume { last: 0 },
            };
        }
        match byte % 8 {
            0..3 => upload_of(&CONTENTS[usize::from(input.byte()) % CONTENTS.len()]),
            3 => Act::Upload {
                length: input.short(),
                digest: input.array(),
            },
            4 => Act::Rollback(id(&CONTENTS[usize::from(input.byte()) % CONTENTS.len()])),
            5 => Act::Rollback(SetId(input.array())),
            6 => Act::FactoryReset,
            _ => Act::Provision(input.pick(&[&KEYS[0], &KEYS[1]]).clone()),
        }
    }

    /// A question, which changes no state.
    fn question(&mut self, input: &mut Input) {
        let command = match input.byte() % 4 {
            0 => StorageCommand::ActiveSet,
            1 => StorageCommand::Read(input.short()),
            2 => StorageCommand::History(input.byte()),
            _ => StorageCommand::Log(u32::from_le_bytes(input.array())),
        };
        let operations = self.nor.borrow().operations;
        self.ask(command);
        assert_eq!(self.nor.borrow().operations, operations);
    }

    /// A command that leaves the active set as it is.
    fn ask(&mut self, command: StorageCommand) {
        let _ = self.key_holder.ask(command);
        assert!(self.active.contains(&self.key_holder.active()));
    }

    /// A change signed with `key` for the last challenge; unless `flipped` is zero the tag is spoilt.
    fn signed_change(&mut self, act: Act, key: &Key, flipped: u8) {
        let challenge = self.challenge.unwrap_or_default();
        let (change, mut tag) = signed(key, &challenge, act);
        tag[usize::from(flipped) % tag.len()] ^= flipped;
        self.heard = Some((change.clone(), tag));
        let key = (flipped == 0 && self.challenge.take().is_some()).then_some(key);
        self.change(change, tag, key);
    }

    /// A change signed with the right key, or with a wrong one.
    fn change(&mut self, change: Change, tag: Tag, key: Option<&Key>) {
        let entitled = key.is_some_and(|key| {
            self.keys.iter().any(|own| match (own, &change.act) {
                (Some(own), _) => own == key,
                (None, Act::Provision(own)) => own == key,
                (None, _) => false,
            })
        });
        let before = (self.nor.borrow().operations, self.nor.borrow().is_powered());
        let answer = self
            .key_holder
            .ask(StorageCommand::Change(change.clone(), tag));
        if !entitled {
            assert!(answer.is_err(), "{change:?} without the key");
            assert_eq!(self.nor.borrow().operations, before.0, "{change:?}");
            assert!(self.active.contains(&self.key_holder.active()));
            return;
        }
        if let Ok(Response::Done | Response::Committed(_) | Response::Erased { .. }) = answer {
            self.upload = None;
        }
        match change.act {
            Act::Upload { digest, .. } => {
                if answer == Ok(Response::Done) {
                    self.upload = Some(announced(&digest));
                    self.sent.1 = 0;
                }
                self.settle(&answer, None, before);
            }
            Act::Rollback(id) => {
                assert!(
                    answer.is_err() || self.kept.contains(&id),
                    "{id} became active and is not kept"
                );
                self.settle(&answer, Some(Some(id)), before);
            }
            Act::FactoryReset => {
                if answer.is_ok() {
                    self.kept.clear();
                }
                self.settle(&answer, Some(None), before);
            }
            Act::NewVolume { .. } => self.settle(&answer, None, before),
            Act::Provision(key) => {
                if answer.is_ok() {
                    self.keys = vec![Some(key)];
                } else if self.operated(before) {
                    self.keys.push(Some(key));
                }
                self.settle(&answer, None, before);
            }
        }
    }

    /// The next piece of the upload under way.
    fn piece(&mut self) {
        let (content, offset) = self.sent;
        let rest = CONTENTS[content].get(offset..).unwrap_or_default();
        let piece: Chunk = rest.iter().copied().take(CHUNK).collect();
        self.sent.1 += piece.len();
        self.ask(StorageCommand::Chunk(offset as u16, piece));
    }

    fn commit(&mut self) {
        let before = (self.nor.borrow().operations, self.nor.borrow().is_powered());
        let answer = self.key_holder.ask(StorageCommand::Commit);
        let upload = self.upload.take();
        if answer.is_ok() {
            let good = upload
                .is_some_and(|upload| CONTENTS[..GOOD].iter().any(|content| id(content) == upload));
            assert!(good, "committed {upload:?}");
        }
        self.kept.extend(upload);
        self.settle(&answer, upload.map(Some), before);
    }

    /// An upload of the key holder.
    fn whole_upload(&mut self, content: usize) {
        let content = content % CONTENTS.len();
        self.challenge = Some(self.key_holder.challenge());
        let key = self.keys[0].clone().unwrap_or(KEYS[0].clone());
        self.signed_change(upload_of(&CONTENTS[content]), &key, 0);
        self.sent = (content, 0);
        while self.sent.1 < CONTENTS[content].len() {
            self.piece();
        }
        self.commit();
    }

    /// Whether the flash was changed since then.
    fn operated(&self, (operations, powered): (u32, bool)) -> bool {
        powered && self.nor.borrow().operations > operations
    }

    /// Applies the answer to a change that makes `wanted` active.
    fn settle(
        &mut self,
        answer: &Result<Response, Refusal>,
        wanted: Option<Option<SetId>>,
        before: (u32, bool),
    ) {
        let active = self.key_holder.active();
        match answer {
            Ok(Response::Committed(set)) => {
                assert_eq!(wanted, Some(Some(set.id)));
                self.active = vec![Some(set.id)];
            }
            Ok(Response::Erased { .. }) => {
                assert_eq!(wanted, Some(None));
                self.active = vec![None];
            }
            Err(refusal) if self.operated(before) => {
                let is_cut = !self.nor.borrow().is_powered();
                assert!(is_cut, "{refusal:?} while the power lasts");
                self.active.extend(wanted);
            }
            _ => {}
        }
        assert!(
            self.active.contains(&active),
            "{active:?} is active, not one of {:?}",
            self.active
        );
    }

    /// Switches off and on; the first start may be cut, the second is not.
    fn restart(&mut self, cut: Option<(u32, Torn)>) {
        self.nor.borrow_mut().power_on();
        if let Some((operations, torn)) = cut {
            let seed = operations.into();
            self.nor.borrow_mut().cut_after(operations, torn, seed);
            let (_, started) = KeyHolder::start(Shared(self.nor));
            let was_cut = self.nor.borrow_mut().power_on();
            assert!(was_cut || started.is_ok(), "{started:?}");
        }
        let challenges = self.key_holder.challenges;
        let (key_holder, started) = KeyHolder::start(Shared(self.nor));
        assert_eq!(started, Ok(()));
        self.key_holder = key_holder;
        self.key_holder.challenges = challenges;
        (self.challenge, self.upload) = (None, None);
        let active = self.key_holder.active();
        assert!(self.active.contains(&active), "{active:?}");
        self.active = vec![active];
        let is_provisioned = self.key_holder.storage.is_provisioned();
        self.keys.retain(|key| key.is_some() == is_provisioned);
        assert!(!self.keys.is_empty(), "provisioned: {is_provisioned}");
    }

    /// A good host completes its upload, and the board's records are in order.
    fn end(&mut self) {
        let was_cut = self.nor.borrow_mut().power_on();
        if was_cut {
            self.restart(None);
        }
        let content = &CONTENTS[0];
        let uploaded = self.keys.clone().iter().any(|key| {
            self.key_holder.now_ms += MAX_WAIT_MS;
            if key.is_none() {
                let provisioned = self
                    .key_holder
                    .change(&KEYS[0], Act::Provision(KEYS[0].clone()));
                assert_eq!(provisioned, Ok(Response::Done));
            }
            let key = key.as_ref().unwrap_or(&KEYS[0]);
            match self.key_holder.upload(key, content) {
                Err(Refusal::WrongTag) => false,
                Err(Refusal::AlreadyActive) => self.key_holder.active() == Some(id(content)),
                answer => {
                    assert!(matches!(answer, Ok(Response::Committed(_))), "{answer:?}");
                    true
                }
            }
        });
        assert!(uploaded, "the board takes none of its keys");
        let (mut key_holder, started) = KeyHolder::start(Shared(self.nor));
        assert_eq!(started, Ok(()));
        assert_eq!(key_holder.active(), Some(id(content)));
        in_order(&key_holder.log(), key_holder.active());
    }
}

/// Each entry carries the hash of the one before and follows on it, and the last names the active set.
fn in_order(log: &[Entry], active: Option<SetId>) {
    let first = log.first().map_or(1, |entry| entry.counter);
    let counters = log.iter().map(|entry| entry.counter);
    assert!(counters.eq(first..first + log.len() as u32), "{log:?}");
    assert_eq!(log.last().and_then(|entry| entry.id), active);
    for pair in log.windows(2) {
        assert_eq!(pair[1].previous, pair[0].id, "{log:?}");
        assert_eq!(pair[1].chain, pair[0].hash(), "{log:?}");
    }
    let lost = log.iter().any(|entry| entry.reason == Reason::Fallback);
    assert!(!lost, "an active set was lost: {log:?}");
}
