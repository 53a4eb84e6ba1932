//! The proof of a board: it has the key that the host has, and says what firmware, set and log it has.
//!
//! See [`hexsense_core::wire::change`]. After a proof the board has forgotten its challenge and an upload under way, so that
//! a change that was sent before and has not arrived by then is refused when it comes.

use hexsense_core::authority;
use hexsense_core::wire::change::{Key, Statement};
use hexsense_core::wire::{Identity, Request, Response};

use super::client::Client;
use super::conversation::answer_error;
use super::error::LinkError;

/// Why a board is not proven.
#[derive(Debug, thiserror::Error)]
pub enum ProofError {
    /// What answers does not have the key.
    #[error(
        "what answers on {port} does not have this key: another board or program answers, the line changes what the \
         board says, or the board has another key by now"
    )]
    WrongTag {
        /// The port.
        port: String,
    },
    /// There is no proof: the board refused, or the link failed.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The system has no random numbers.
    #[error("the system gives no random numbers, which a proof needs: {0}")]
    Random(getrandom::Error),
}

impl Client {
    /// Has the board prove that it has this key; what it says of itself.
    ///
    /// # Errors
    /// [`ProofError`].
    pub fn prove(&mut self, key: &Key) -> Result<Statement, ProofError> {
        let mut challenge = [0; 32];
        getrandom::fill(&mut challenge).map_err(ProofError::Random)?;
        let Identity { board, build, .. } = self.identity()?;
        let request = Request::Prove { challenge };
        let Response::Proof { statement, tag } = self.conversation.ask(&request)? else {
            return Err(answer_error(&request).into());
        };
        let expected =
            build.map(|build| authority::proof(key, &challenge, &board, &build, &statement));
        if expected == Some(tag) {
            Ok(statement)
        } else {
            let port = self.port().to_owned();
            Err(ProofError::WrongTag { port })
        }
    }
}
