//! The key holder: changes of what the board keeps, and the board's account of them.

use anyhow::{bail, ensure};
use hexsense_core::authority;
use hexsense_core::records::log::Entry;
use hexsense_core::records::{CoefficientSet, MAX_ENCODED, SetId};
use hexsense_core::wire::change::{self, Change, Key};
use hexsense_core::wire::message::{CHUNK, Chunk, Kept};
use hexsense_core::wire::{Request, Response};
use sha2::{Digest, Sha256};

use crate::line::Line;
use crate::trial_set::Random;

/// Time of the first change, s since 1970; each later one is a minute after the one before.
const DATE: u64 = 1_790_000_000;

/// The board's own account of what it keeps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Account {
    /// Whether it has a key.
    pub provisioned: bool,
    /// The active set.
    pub active: Option<SetId>,
    /// All sets, newest first.
    pub history: Vec<Kept>,
    /// All changes, oldest first.
    pub log: Vec<Entry>,
}

impl Account {
    /// Asks the board.
    pub fn read(line: &mut Line) -> anyhow::Result<Self> {
        let provisioned = line.status()?.provisioned;
        let active = match line.ask(&Request::ActiveSet)? {
            Response::ActiveSet(active) => active.map(|active| active.id),
            other => bail!("the active set is {other:?}"),
        };
        Ok(Self {
            provisioned,
            active,
            history: history(line)?,
            log: log(line)?,
        })
    }

    /// The first thing that an auditor would find wrong: counters that do not rise by one, an entry that does not follow from
    /// the entry before it or does not carry its hash, an active set that the last entry does not name or the history does
    /// not have.
    pub fn audit(&self) -> Result<(), String> {
        let first = self.log.first();
        let mut active = first.and_then(|first| first.previous);
        for pair in self.log.windows(2) {
            if pair[1].chain != pair[0].hash() {
                return Err(format!("{:?} breaks the chain", pair[1]));
            }
        }
        for (entry, counter) in self
            .log
            .iter()
            .zip(first.map_or(1, |first| first.counter)..)
        {
            if entry.counter != counter {
                return Err(format!("entry {counter} has the counter {}", entry.counter));
            }
            if entry.previous != active {
                return Err(format!("{entry:?} follows after {active:?}"));
            }
            active = entry.id;
        }
        if active != self.active {
            return Err(format!(
                "the log ends with {active:?}, active is {:?}",
                self.active
            ));
        }
        match self.active {
            Some(id) if self.history.iter().all(|kept| kept.id != id) => {
                Err(format!("the active set {id} is not in the history"))
            }
            None if !self.history.is_empty() => Err("sets are kept, but none is active".to_owned()),
            _ => Ok(()),
        }
    }
}

fn history(line: &mut Line) -> anyhow::Result<Vec<Kept>> {
    let mut history = Vec::new();
    for age in 0..=u8::MAX {
        match line.ask(&Request::History { age })? {
            Response::Kept(Some(kept)) => history.push(kept),
            Response::Kept(None) => break,
            other => bail!("the history is {other:?}"),
        }
    }
    Ok(history)
}

fn log(line: &mut Line) -> anyhow::Result<Vec<Entry>> {
    let mut log: Vec<Entry> = Vec::new();
    loop {
        let counter = log.last().map_or(1, |entry| entry.counter + 1);
        match line.ask(&Request::Log { counter })? {
            Response::Log { last, entries } => {
                log.extend(&entries);
                if entries.is_empty() || log.last().is_some_and(|entry| entry.counter == last) {
                    return Ok(log);
                }
            }
            other => bail!("the log is {other:?}"),
        }
    }
}

/// One change.
#[derive(Debug, Clone)]
pub enum Act {
    /// Give the board this key.
    Provision(Key),
    /// Upload this set.
    Upload(Box<CoefficientSet>),
    /// Make this kept set active again.
    Rollback(SetId),
    /// Erase all sets.
    FactoryReset,
    /// Begin a new volume of the log after the entry with this counter.
    NewVolume(u32),
}

impl Act {
    /// Its name, for people.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Provision(_) => "provision",
            Self::Upload(_) => "upload",
            Self::Rollback(_) => "rollback",
            Self::FactoryReset => "factory reset",
            Self::NewVolume(_) => "new volume",
        }
    }
}

/// The holder of a key.
#[derive(Clone)]
pub struct KeyHolder {
    /// The key.
    pub key: Key,
    /// Unique id of the board that changes are made for.
    pub board: [u8; 12],
    changes: u64,
}

impl KeyHolder {
    /// The key holder of this board, with a key of its own.
    pub fn of(line: &mut Line) -> anyhow::Result<Self> {
        Ok(Self {
            key: Key(*b"the key of the fault campaign's.."[..32]
                .first_chunk()
                .expect("32 bytes")),
            board: line.identity()?.board,
            changes: 0,
        })
    }

    /// Gives the board the key.
    pub fn provision(&mut self, line: &mut Line) -> anyhow::Result<()> {
        self.carry_out(line, &Act::Provision(self.key.clone()))
    }

    /// Has the board carry out a change; fails when it refuses.
    pub fn carry_out(&mut self, line: &mut Line, act: &Act) -> anyhow::Result<()> {
        self.changes += 1;
        match act {
            Act::Provision(key) => {
                let request = self.tagged(line, change::Act::Provision(key.clone()))?;
                line.order(&request)
            }
            Act::NewVolume(last) => {
                let request = self.tagged(line, change::Act::NewVolume { last: *last })?;
                line.order(&request)
            }
            Act::Upload(set) => self.upload(line, set),
            Act::Rollback(id) => {
                let request = self.tagged(line, change::Act::Rollback(*id))?;
                match line.ask(&request)? {
                    Response::Committed(active) if active.id == *id => Ok(()),
                    other => bail!("the rollback was answered by {other:?}"),
                }
            }
            Act::FactoryReset => {
                let request = self.tagged(line, change::Act::FactoryReset)?;
                match line.ask(&request)? {
                    Response::Erased { .. } => Ok(()),
                    other => bail!("the factory reset was answered by {other:?}"),
                }
            }
        }
    }

    /// The request of a change, with the tag that a new challenge asks for.
    pub fn tagged(&self, line: &mut Line, act: change::Act) -> anyhow::Result<Request> {
        let challenge = match line.ask(&Request::Challenge)? {
            Response::Challenge(challenge) => challenge,
            other => bail!("no challenge but {other:?}"),
        };
        let change = Change {
            unix_s: DATE + 60 * self.changes,
            act,
        };
        let tag = authority::tag(&self.key, &challenge, &self.board, &change);
        Ok(Request::Change { change, tag })
    }

    /// Begins the upload of these bytes.
    pub fn begin(&self, line: &mut Line, encoded: &[u8]) -> anyhow::Result<()> {
        let begin = self.tagged(line, upload_of(encoded))?;
        line.order(&begin)
    }

    fn upload(&self, line: &mut Line, set: &CoefficientSet) -> anyhow::Result<()> {
        let mut room = [0; MAX_ENCODED];
        let encoded = set.encode(&mut room)?;
        self.begin(line, encoded)?;
        for request in pieces(encoded) {
            line.order(&request)?;
        }
        match line.ask(&Request::UploadCommit)? {
            Response::Committed(active) => {
                ensure!(
                    active.id == CoefficientSet::id_of(encoded),
                    "another set was committed: {active:?}"
                );
                Ok(())
            }
            other => bail!("the commit was answered by {other:?}"),
        }
    }
}

/// Uploads coefficients drawn from `random`. A board without a key gets one first. Returns the key holder and the
/// coefficients.
pub fn calibrate(
    line: &mut Line,
    random: &mut Random,
) -> anyhow::Result<(KeyHolder, CoefficientSet)> {
    let mut key_holder = KeyHolder::of(line)?;
    if !line.status()?.provisioned {
        key_holder.provision(line)?;
    }
    let set = random.set(key_holder.board);
    key_holder.carry_out(line, &Act::Upload(Box::new(set.clone())))?;
    Ok((key_holder, set))
}

/// The change that begins the upload of these bytes.
pub fn upload_of(encoded: &[u8]) -> change::Act {
    change::Act::Upload {
        length: encoded.len() as u16,
        digest: Sha256::digest(encoded).into(),
    }
}

/// The requests that carry them.
pub fn pieces(encoded: &[u8]) -> impl Iterator<Item = Request> {
    encoded
        .chunks(CHUNK)
        .enumerate()
        .map(|(index, piece)| Request::UploadChunk {
            offset: (index * CHUNK) as u16,
            bytes: piece.iter().copied().collect::<Chunk>(),
        })
}
