//! The errors of the link.

use std::io;

use thiserror::Error;

use crate::machine::Stop;

/// Why the link cannot be opened, or has failed.
#[derive(Debug, Error)]
pub enum LinkError {
    /// The address cannot be listened on.
    #[error(
        "--link {address}: {source} (another process may listen there; port 0 picks a free one)"
    )]
    Listen {
        /// The address.
        address: String,
        /// What the system said.
        source: io::Error,
    },
    /// No pseudo-terminal is available.
    #[error("--link pty: {0}")]
    Pty(io::Error),
    /// The link broke, and waiting does not help.
    #[error("the link failed: {0}")]
    Failed(#[from] io::Error),
    /// The machine stopped.
    #[error(transparent)]
    Machine(#[from] Stop),
}
