//! A coefficient set on its way to the board and back.
//!
//! ```text
//! begin → pieces → commit → read back and compare
//! ```
//!
//! Until the commit the old set stays active, whatever happens. The commit is the one request that must not be asked
//! twice: when its answer is lost, the board proves which set is active instead, and that it has forgotten the upload.

use hexsense_core::records::{CoefficientSet, SetId};
use hexsense_core::wire::change::{Act, Key};
use hexsense_core::wire::message::{ActiveSet, CHUNK, Chunk};
use hexsense_core::wire::{Refusal, Request, Response};
use sha2::{Digest, Sha256};

use super::change::{CHANGE, ChangeError};
use super::client::Client;
use super::conversation::answer_error;
use super::error::LinkError;

/// Why an upload was not completed, and what the board has now.
#[derive(Debug, thiserror::Error)]
pub enum UploadError {
    /// The board did not let it begin.
    #[error("{0}. The coefficients on the board are unchanged")]
    Refused(ChangeError),
    /// It broke off before the commit.
    #[error(
        "the upload broke off: {0}. The old coefficients are still active on the board; upload again"
    )]
    Before(LinkError),
    /// It broke off while the board was storing, or before it stores.
    #[error(
        "the upload broke off while the board was storing the set: {reason}. Either the old set or the whole new one is \
         active within a minute, never a mixture; see which after that with `hexsense show --port {port}`, and upload \
         again if it is the old one"
    )]
    During {
        /// What went wrong.
        reason: String,
        /// The port.
        port: String,
    },
    /// The set is active, and the board's log does not say so.
    #[error(transparent)]
    Unlogged(Refusal),
    /// It broke off while the set was read back.
    #[error(
        "the board has stored the new coefficients, but reading them back broke off: {0}. See them with `hexsense show`"
    )]
    After(LinkError),
    /// The bytes read back differ.
    #[error(
        "the board reads back another set ({read_back}) than the one uploaded ({uploaded}); upload again, and replace the board if it happens twice"
    )]
    Different {
        /// Identity of the set that was sent.
        uploaded: String,
        /// Identity of the set that came back.
        read_back: String,
    },
}

impl Client {
    /// Makes an encoded set the active one and proves it by reading it back. `key` is the board's. Nothing
    /// changes when the set is active already.
    ///
    /// # Errors
    /// [`UploadError`], which says what the board has now.
    pub fn upload(&mut self, encoded: &[u8], key: &Key) -> Result<ActiveSet, UploadError> {
        let act = Act::Upload {
            length: encoded.len() as u16,
            digest: Sha256::digest(encoded).into(),
        };
        let id = CoefficientSet::id_of(encoded);
        match self.begin_upload(key, act) {
            Ok(()) => {
                self.send_pieces(encoded).map_err(UploadError::Before)?;
                self.commit(id, key)?;
            }
            Err(LinkError::Refused(Refusal::AlreadyActive)) => {}
            Err(LinkError::Refused(refusal)) => {
                return Err(UploadError::Refused(self.refused(refusal)));
            }
            Err(error) => return Err(UploadError::Before(error)),
        }
        let read_back = self.read_set().map_err(UploadError::After)?;
        match read_back {
            Some((active, bytes)) if bytes == encoded => Ok(active),
            other => Err(UploadError::Different {
                uploaded: id.to_string(),
                read_back: other.map_or("none".to_owned(), |(_, bytes)| {
                    CoefficientSet::id_of(&bytes).to_string()
                }),
            }),
        }
    }

    fn send_pieces(&mut self, encoded: &[u8]) -> Result<(), LinkError> {
        for (index, piece) in encoded.chunks(CHUNK).enumerate() {
            let bytes: Chunk = piece.iter().copied().collect();
            let offset = index * CHUNK;
            let request = Request::UploadChunk {
                offset: offset as u16,
                bytes,
            };
            match self.conversation.command(&request) {
                // The piece had arrived and its answer was lost.
                Err(LinkError::Refused(Refusal::OutOfOrder { expected }))
                    if usize::from(expected) == offset + piece.len() => {}
                other => other?,
            }
        }
        Ok(())
    }

    fn commit(&mut self, id: SetId, key: &Key) -> Result<(), UploadError> {
        let start = self.now();
        let commit = Request::UploadCommit;
        let error = match self.conversation.ask_once(&commit, CHANGE) {
            Ok(Some(Response::Committed(_))) => return Ok(()),
            Ok(Some(_)) => answer_error(&commit),
            Ok(None) => self.conversation.silent(&commit, 1, start).into(),
            Err(LinkError::Refused(unlogged @ Refusal::Log)) => {
                return Err(UploadError::Unlogged(unlogged));
            }
            Err(error) => error,
        };
        match self.prove(key) {
            Ok(statement) if statement.set == Some(id) => Ok(()),
            Ok(_) => Err(UploadError::Before(error)),
            Err(reason) => Err(UploadError::During {
                reason: reason.to_string(),
                port: self.port().to_owned(),
            }),
        }
    }
}
