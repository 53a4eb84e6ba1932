//! The keeper's side: changes of what the board keeps, and the account that it gives of them.

use anyhow::bail;
use hexsense::store::{CoefficientSet, MAX_ENCODED, SetId};
use hexsense::wire::message::{CHUNK, Chunk};
use hexsense::wire::{Request, Response};

use super::line::Line;

/// What the board says of what it keeps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Account {
    /// The active set.
    pub active: Option<SetId>,
}

impl Account {
    /// Asks the board.
    pub fn read(line: &mut Line) -> anyhow::Result<Self> {
        match line.ask(&Request::ActiveSet)? {
            Response::ActiveSet(active) => Ok(Self {
                active: active.map(|active| active.id),
            }),
            other => bail!("the active set is {other:?}"),
        }
    }
}

/// One change.
#[derive(Debug, Clone)]
pub enum Act {
    /// Upload this set.
    Upload(Box<CoefficientSet>),
}

impl Act {
    /// Has the board carry it out.
    pub fn carry_out(&self, line: &mut Line) -> anyhow::Result<()> {
        match self {
            Self::Upload(set) => upload(line, set),
        }
    }
}

fn upload(line: &mut Line, set: &CoefficientSet) -> anyhow::Result<()> {
    let mut room = [0; MAX_ENCODED];
    let encoded = set.encode(&mut room)?;
    let id = CoefficientSet::id_of(encoded);
    line.order(&Request::UploadBegin {
        length: encoded.len() as u16,
        id,
    })?;
    for (index, piece) in encoded.chunks(CHUNK).enumerate() {
        line.order(&Request::UploadChunk {
            offset: (index * CHUNK) as u16,
            bytes: piece.iter().copied().collect::<Chunk>(),
        })?;
    }
    match line.ask(&Request::UploadCommit)? {
        Response::Committed(active) if active.id == id => Ok(()),
        other => bail!("the commit was answered by {other:?}"),
    }
}
