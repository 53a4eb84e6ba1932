//! Changes of what the board keeps, and the exchange that authorises them.
//!
//! ```text
//! host                                            board
//! challenge? ───────────────────────────────────▶
//!            ◀─────────────── 16 random bytes, good for one change within ten seconds
//! change, tag ──────────────────────────────────▶ carried out, or refused
//!
//! tag = HMAC-SHA256(key, challenge ‖ unique id of the board ‖ SHA-256(postcard of the change))
//! ```
//!
//! The tag binds a change to this board and this moment: a recording of the line is worthless later and elsewhere. The
//! digest of the whole set binds an upload, so its pieces need no tags of their own.
//!
//! The other direction proves the board to a host that has its key:
//!
//! ```text
//! host                                            board
//! prove, 32 random bytes ───────────────────────▶ forgets its own challenge, and an upload under way
//!            ◀──────────────────────────────────── statement, tag
//!
//! tag = HMAC-SHA256(key, "hexsense proof 1" ‖ challenge ‖ unique id ‖ build ‖ statement)
//! ```
//!
//! A change that is held back on the line is void from then on. So a host that lost an answer and then has a proof knows
//! whether its change was made, and that it cannot be made any more.

use serde::{Deserialize, Serialize};

use crate::records::SetId;
pub use crate::records::key::Key;
use crate::records::log::Reason;

/// Random bytes that a tag answers.
pub type Challenge = [u8; 16];
/// HMAC-SHA256 over challenge, board and change.
pub type Tag = [u8; 32];
/// Random bytes that a proof answers. They are as long as a tag and a key, because each length of array that the board
/// decodes takes half a kilobyte of flash.
pub type ProofChallenge = [u8; 32];

/// What a board says of itself and proves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Statement {
    /// The active set.
    pub set: Option<SetId>,
    /// Counter of the last entry of its log, zero without one.
    pub changes: u32,
}

/// One change, with its time for the board's log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Change {
    /// The host's clock, seconds since 1970-01-01 UTC: the board has no clock.
    pub unix_s: u64,
    /// What to do.
    pub act: Act,
}

/// What a change does.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Act {
    /// A set will come in chunks, and its commit makes it active.
    Upload {
        /// Length of the encoded set, bytes.
        length: u16,
        /// SHA-256 of the encoded set; its first eight bytes are the set's identity.
        #[serde(deserialize_with = "crate::bytes::read")]
        digest: [u8; 32],
    },
    /// One of the kept sets becomes active again.
    Rollback(SetId),
    /// All sets are erased; key and log stay.
    FactoryReset,
    /// The key from now on. The key before it makes the tag; on a board without a key, this key does.
    Provision(Key),
    /// The log's volume is closed, and its next entries are those of another.
    NewVolume {
        /// Counter of its last entry: a volume that has got another since it was exported stays open.
        last: u32,
    },
}

impl Act {
    /// The reason of its entry in the log.
    #[must_use]
    pub const fn reason(&self) -> Reason {
        match self {
            Self::Upload { .. } => Reason::Upload,
            Self::Rollback(_) => Reason::Rollback,
            Self::FactoryReset => Reason::FactoryReset,
            Self::Provision(_) => Reason::Provision,
            Self::NewVolume { .. } => Reason::NewVolume,
        }
    }
}
