//! The proof of a volume of the log: what the board signs with its key, so that a file with the entries can be checked away
//! from the board.
//!
//! ```text
//! mac = HMAC-SHA256(key, "hexsense log" ‖ nonce ‖ unique id of the board ‖ first u32 ‖ last u32 ‖ head ‖ build)
//! ```
//!
//! The head is the hash of the last entry, which stands for all entries before it. First and last are counters; the first
//! one names the volume. The label and the length of what is signed keep the proof from being the tag of a change.

use serde::{Deserialize, Serialize};

use crate::records::BuildId;
use crate::records::log::Chain;

/// Number of the host's own: a proof that was asked for with a fresh one was made after that.
pub type Nonce = [u8; 32];

/// A volume of the log, as far as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Volume {
    /// Counter of its first entry.
    pub first: u32,
    /// Counter of its last entry, zero in an empty log.
    pub last: u32,
    /// Hash of its last entry.
    pub head: Chain,
    /// The firmware that signs.
    pub build: BuildId,
}
