//! One entry of the log, and the hash that the next one carries.
//!
//! ```text
//! | counter u32 | reason u8 | has id, has previous u8 | page u16 | time u64 | id 8 | previous id 8 | build 8 |
//! | chain 16 | reset u32 | CRC-32 |                                                           64 bytes, little endian
//! chain = first 16 bytes of SHA-256(everything of the entry before but its CRC)
//! ```

use serde::{Deserialize, Serialize};

use crate::checksum::{checksum, sha256};
use crate::records::build::BuildId;
use crate::records::record::SetId;

/// Bytes of an entry in flash.
pub const ENTRY: usize = 64;
/// Where the checksum begins.
const CHECKED: usize = 60;

/// Hash of an entry; zeros where there is none before.
pub type Chain = [u8; 16];

/// The kind of a change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reason {
    /// A set was uploaded.
    Upload,
    /// A kept set was made active again.
    Rollback,
    /// All sets were erased.
    FactoryReset,
    /// The board got a key.
    Provision,
    /// The active set became unreadable, and the newest readable one took its place. The time is unknown, zero.
    Fallback,
    /// The board started with another firmware than the one of the entry before. The time is unknown, zero.
    FirmwareChange,
    /// A volume of the log begins; the one before is closed.
    NewVolume,
}

impl Reason {
    const ALL: [Self; 7] = [
        Self::Upload,
        Self::Rollback,
        Self::FactoryReset,
        Self::Provision,
        Self::Fallback,
        Self::FirmwareChange,
        Self::NewVolume,
    ];
}

/// One change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// Number of the change on this board, from 1 through all volumes.
    pub counter: u32,
    /// Its kind.
    pub reason: Reason,
    /// The host's clock at the change, seconds since 1970-01-01 UTC.
    pub unix_s: u64,
    /// The set that is active after it; `None` after a factory reset.
    pub id: Option<SetId>,
    /// The set that was active before.
    pub previous: Option<SetId>,
    /// The firmware that made it.
    pub build: BuildId,
    /// Hash of the entry before, see [`Entry::hash`]; zeros in the first of the first volume.
    pub chain: Chain,
    /// Counter of the last factory reset up to this entry, zero without one: sets from before it are not used.
    pub reset: u32,
    /// Page of the log, from 0, that its volume begins in.
    pub page: u16,
}

impl Entry {
    /// Hash of all of the entry, which the next one carries as its [`Entry::chain`].
    #[must_use]
    pub fn hash(&self) -> Chain {
        let mut chain = Chain::default();
        chain.copy_from_slice(&sha256(&self.encode()[..CHECKED])[..16]);
        chain
    }

    pub(in crate::records) fn encode(&self) -> [u8; ENTRY] {
        let mut bytes = [0; ENTRY];
        bytes[..4].copy_from_slice(&self.counter.to_le_bytes());
        bytes[4] = self.reason as u8;
        bytes[5] = u8::from(self.id.is_some()) | u8::from(self.previous.is_some()) << 1;
        bytes[6..8].copy_from_slice(&self.page.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.unix_s.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.id.unwrap_or_default().0);
        bytes[24..32].copy_from_slice(&self.previous.unwrap_or_default().0);
        bytes[32..40].copy_from_slice(&self.build.0);
        bytes[40..56].copy_from_slice(&self.chain);
        bytes[56..CHECKED].copy_from_slice(&self.reset.to_le_bytes());
        let sum = checksum(&bytes[..CHECKED]);
        bytes[CHECKED..].copy_from_slice(&sum.to_le_bytes());
        bytes
    }

    /// The entry in these bytes. Bytes that it does not encode to are none, with whatever checksum: so nothing in them can
    /// be altered without altering the entry.
    pub(in crate::records) fn decode(bytes: &[u8; ENTRY]) -> Option<Self> {
        let id = |present: u8, at: usize| {
            let id = bytes.get(at..)?.first_chunk::<8>()?;
            (bytes[5] & present != 0).then_some(SetId(*id))
        };
        let entry = Self {
            counter: u32::from_le_bytes(*bytes.first_chunk()?),
            reason: Reason::ALL
                .into_iter()
                .find(|reason| *reason as u8 == bytes[4])?,
            unix_s: u64::from_le_bytes(*bytes.get(8..)?.first_chunk()?),
            id: id(1, 16),
            previous: id(2, 24),
            build: BuildId(*bytes.get(32..)?.first_chunk()?),
            chain: *bytes.get(40..)?.first_chunk()?,
            reset: u32::from_le_bytes(*bytes.get(56..)?.first_chunk()?),
            page: u16::from_le_bytes(*bytes.get(6..)?.first_chunk()?),
        };
        (entry.encode() == *bytes).then_some(entry)
    }
}
