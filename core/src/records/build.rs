//! The firmware's identity: what stands in flash decides it, not what the firmware says of itself.
//!
//! ```text
//! build = first eight bytes of SHA-256(code in flash ‖ version: major, minor, patch)
//! ```
//!
//! Every set says with which build its captures were recorded, and every entry of the [`super::log`] by which build it was
//! made.

use core::{fmt, mem};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Bytes that are hashed at a time: a quarter of a millisecond on the board.
const PIECE: usize = 1_024;

/// Identity of a firmware by its code and version.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, Default)]
pub struct BuildId(pub [u8; 8]);

/// The hash of a firmware, piece by piece: others work in between, because the board's code takes 30 ms.
pub struct BuildHash<'c> {
    hash: Sha256,
    rest: &'c [u8],
    version: [u8; 3],
}

impl<'c> BuildHash<'c> {
    /// The hash of this code and version, with nothing done yet.
    #[must_use]
    pub fn new(code: &'c [u8], version: [u8; 3]) -> Self {
        Self {
            hash: Sha256::new(),
            rest: code,
            version,
        }
    }

    /// Hashes the next kibibyte; the identity when that was the last.
    pub fn advance(&mut self) -> Option<BuildId> {
        let (piece, rest) = self.rest.split_at(self.rest.len().min(PIECE));
        self.hash.update(piece);
        self.rest = rest;
        if !rest.is_empty() {
            return None;
        }
        self.hash.update(self.version);
        let digest: [u8; 32] = mem::take(&mut self.hash).finalize().into();
        Some(BuildId(*digest.first_chunk()?))
    }
}

impl fmt::Display for BuildId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for BuildId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "BuildId({self})")
    }
}
