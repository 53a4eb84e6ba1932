//! The version exchange, whose shape never changes.
//!
//! A host first sends an empty hello frame. With any two versions, the board answers with a greeting:
//!
//! ```text
//! | "hexsense" | wire version u16 LE | firmware major u8 | minor u8 | patch u8 |
//! ```
//!
//! Later versions may append bytes, which older readers ignore.

use super::frame::{self, FrameError, Kind};

/// Speed of the serial line at which a board is greeted, bit/s: a host must know it before it knows the board.
pub const BAUD: u32 = 2_000_000;
const MAGIC: &[u8; 8] = b"hexsense";
const LENGTH: usize = 13;

/// The first message of a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Greeting {
    /// Version of the wire that the board speaks, see [`super::VERSION`].
    pub wire: u16,
    /// Version of the firmware: major, minor, patch.
    pub firmware: [u8; 3],
}

impl Greeting {
    /// Encodes the greeting as a frame into `out` and returns its length.
    ///
    /// # Errors
    /// [`FrameError::Long`] when `out` is shorter than the frame.
    pub fn encode(&self, sequence: u16, out: &mut [u8]) -> Result<usize, FrameError> {
        frame::encode(Kind::Greeting, sequence, out, |payload| {
            let payload = payload.first_chunk_mut::<LENGTH>()?;
            payload[..8].copy_from_slice(MAGIC);
            payload[8..10].copy_from_slice(&self.wire.to_le_bytes());
            payload[10..].copy_from_slice(&self.firmware);
            Some(LENGTH)
        })
    }

    /// Reads a greeting; `None` when the payload is not one.
    #[must_use]
    pub fn decode(payload: &[u8]) -> Option<Self> {
        let payload = payload.first_chunk::<LENGTH>()?;
        if &payload[..8] != MAGIC {
            return None;
        }
        let [.., low, high, major, minor, patch] = *payload;
        Some(Self {
            wire: u16::from_le_bytes([low, high]),
            firmware: [major, minor, patch],
        })
    }
}
