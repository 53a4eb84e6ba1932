//! Whether what answers is the board: a board proves that it has the key in the file at hand.
//!
//! The proof covers the board's unique id, the build of its firmware, its active set and the number of its changes. What a
//! command prints of set and log is compared with that.

use std::path::PathBuf;

use anyhow::{bail, ensure};
use hexsense_client::{Client, LinkError, ProofError};
use hexsense_core::records::SetId;
use hexsense_core::wire::Refusal;
use hexsense_core::wire::change::Statement;

use super::arguments::Key;
use crate::key_file::KeyFileError;

/// Whether a board is proven.
pub enum Proven {
    /// It has the key in this file.
    Yes {
        /// The file.
        file: PathBuf,
        /// What the board says of itself, and proves.
        statement: Statement,
    },
    /// Nothing can be said, for this reason.
    No(String),
    /// It does not have the key at hand.
    Wrong(String),
}

impl Proven {
    /// Has the board prove itself with the key at hand.
    ///
    /// # Errors
    /// What the link reports, and a file named by --key that holds no key.
    pub fn of(client: &mut Client, key: &Key) -> anyhow::Result<Self> {
        let board = client.identity()?.board;
        let file = key.file(&board);
        let loaded = match key.load(&board) {
            Ok(loaded) => loaded,
            Err(error) if key.named.is_some() => return Err(error.into()),
            Err(KeyFileError::Missing { file }) => {
                let reason =
                    format!("there is no {file} here; name the board's key with --key FILE");
                return Ok(Self::No(reason));
            }
            Err(error) => return Ok(Self::No(error.to_string())),
        };
        match client.prove(&loaded) {
            Ok(statement) => Ok(Self::Yes { file, statement }),
            Err(error @ ProofError::WrongTag { .. }) => {
                Ok(Self::Wrong(format!("{}: {error}", file.display())))
            }
            Err(ProofError::Link(LinkError::Refused(Refusal::Unprovisioned))) => {
                Ok(Self::Wrong(format!(
                    "{} is here, so the board had a key; but what answers on {} says that it has none: another board \
                     or program answers, the line changes what the board says, or the board's flash was erased",
                    file.display(),
                    client.port()
                )))
            }
            Err(ProofError::Link(LinkError::Refused(refusal @ Refusal::KeyDamaged))) => {
                Ok(Self::No(refusal.to_string()))
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Whether it is.
    #[must_use]
    pub fn is_proven(&self) -> bool {
        matches!(self, Self::Yes { .. })
    }

    /// The result as a line of text.
    #[must_use]
    pub fn line(&self) -> String {
        match self {
            Self::Yes { file, .. } => format!("board proven: it has the key in {}", file.display()),
            Self::No(reason) => format!("board not proven: {reason}"),
            Self::Wrong(reason) => format!("BOARD NOT PROVEN: {reason}"),
        }
    }

    /// Makes sure that the board does not lack the key at hand.
    ///
    /// # Errors
    /// A board that does.
    pub fn check(&self) -> anyhow::Result<()> {
        match self {
            Self::Wrong(reason) => bail!("the board is NOT PROVEN: {reason}"),
            Self::Yes { .. } | Self::No(_) => Ok(()),
        }
    }

    /// Makes sure that a proven board has this active set.
    ///
    /// # Errors
    /// Another one.
    pub fn check_set(&self, told: Option<SetId>) -> anyhow::Result<()> {
        let name = |set: Option<SetId>| set.map_or("none".to_owned(), |id| id.to_string());
        if let Self::Yes { statement, .. } = self {
            ensure!(
                statement.set == told,
                "the board proves that its set is {}, and on the line it is {}: the line changes what the board says",
                name(statement.set),
                name(told)
            );
        }
        Ok(())
    }

    /// Makes sure that a proven board has so many changes in its log.
    ///
    /// # Errors
    /// Another number.
    pub fn check_changes(&self, told: u32) -> anyhow::Result<()> {
        if let Self::Yes { statement, .. } = self {
            ensure!(
                statement.changes == told,
                "the board proves that its last change is {}, and on the line it is {told}: the line changes what the \
                 board says",
                statement.changes
            );
        }
        Ok(())
    }
}
