//! Blocks of samples, sent by the board while it streams.
//!
//! ```text
//! | header, postcard | counts 16 × 15 × u16 LE, if streamed | values 16 × 9 × f32 LE, if streamed |
//! ```
//!
//! The samples are not postcard: its variable-length integers would make a count of 16 bits up to three bytes.

use serde::{Deserialize, Serialize};

use super::frame::{self, FrameError, Kind};
use super::message::StreamContent;
use super::pose;
use crate::channel::{CHANNELS, INERTIAL, Scan};
use crate::sampling::{BLOCK, Values};
use crate::store::SetId;

const COUNT_BYTES: usize = BLOCK * CHANNELS * 2;
const VALUE_BYTES: usize = BLOCK * INERTIAL * 4;
/// Upper bound of the encoded header, bytes.
const MAX_HEADER: usize = 64;

/// What is common to the scans of a block.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Scan counter of the first scan; the others follow without a gap.
    pub first_scan: u64,
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Supply factor of these scans, see [`crate::sampling`].
    pub supply: f32,
    /// Temperature of the die, °C.
    pub temperature_c: f32,
    /// Set that made the values; `None` without one.
    pub set: Option<SetId>,
    /// Blocks that the link had to drop since the start of the board, this stream or earlier.
    pub dropped: u32,
    /// What follows the header.
    pub content: StreamContent,
}

/// A block as received.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// What is common to the scans.
    pub header: Header,
    /// Raw counts, when streamed.
    pub counts: Option<[Scan; BLOCK]>,
    /// Calibrated values, when streamed.
    pub values: Option<[Values; BLOCK]>,
}

/// Line capacity that a stream needs, bit/s of 10-bit characters, all overheads included.
#[must_use]
pub const fn bits_per_second(content: StreamContent, rate_hz: u32) -> u32 {
    let counts = if content.counts { COUNT_BYTES } else { 0 };
    let values = if content.values { VALUE_BYTES } else { 0 };
    let blocks = if content.has_blocks() {
        frame_bits(MAX_HEADER + counts + values) * rate_hz / BLOCK as u32
    } else {
        0
    };
    let poses_hz = if rate_hz < pose::MAX_RATE_HZ * BLOCK as u32 {
        rate_hz.div_ceil(BLOCK as u32)
    } else {
        pose::MAX_RATE_HZ
    };
    let poses = if content.pose {
        frame_bits(pose::MAX_REPORT) * poses_hz
    } else {
        0
    };
    blocks + poses
}

/// Bits on the line of a frame with so many bytes of payload; sixteen cover header, checksum and COBS.
const fn frame_bits(payload: usize) -> u32 {
    ((payload + 16) * 10) as u32
}

/// Encodes a block as a frame into `out` and returns its length; `header.content` says which of the samples go.
///
/// # Errors
/// [`FrameError::Long`] when `out` is shorter than the frame.
pub fn encode(
    header: &Header,
    counts: &[Scan; BLOCK],
    values: &[Values; BLOCK],
    sequence: u16,
    out: &mut [u8],
) -> Result<usize, FrameError> {
    frame::encode(Kind::Block, sequence, out, |payload| {
        let mut used = postcard::to_slice(header, payload).ok()?.len();
        if header.content.counts {
            let bytes = payload.get_mut(used..used + COUNT_BYTES)?;
            for (bytes, count) in bytes.chunks_exact_mut(2).zip(counts.as_flattened()) {
                bytes.copy_from_slice(&count.to_le_bytes());
            }
            used += COUNT_BYTES;
        }
        if header.content.values {
            let bytes = payload.get_mut(used..used + VALUE_BYTES)?;
            for (bytes, value) in bytes.chunks_exact_mut(4).zip(values.as_flattened()) {
                bytes.copy_from_slice(&value.to_le_bytes());
            }
            used += VALUE_BYTES;
        }
        Some(used)
    })
}

/// Decodes the payload of a block frame; `None` when it is not a block of this version.
#[must_use]
pub fn decode(payload: &[u8]) -> Option<Block> {
    let (header, mut rest) = postcard::take_from_bytes::<Header>(payload).ok()?;
    let counts = if header.content.counts {
        let (bytes, after) = rest.split_at_checked(COUNT_BYTES)?;
        rest = after;
        let mut counts = [[0; CHANNELS]; BLOCK];
        for (count, bytes) in counts
            .as_flattened_mut()
            .iter_mut()
            .zip(bytes.as_chunks::<2>().0)
        {
            *count = u16::from_le_bytes(*bytes);
        }
        Some(counts)
    } else {
        None
    };
    let values = if header.content.values {
        let (bytes, after) = rest.split_at_checked(VALUE_BYTES)?;
        rest = after;
        let mut values = [[0.0; INERTIAL]; BLOCK];
        for (value, bytes) in values
            .as_flattened_mut()
            .iter_mut()
            .zip(bytes.as_chunks::<4>().0)
        {
            *value = f32::from_le_bytes(*bytes);
        }
        Some(values)
    } else {
        None
    };
    rest.is_empty().then_some(Block {
        header,
        counts,
        values,
    })
}
