//! Blocks of samples, sent by the board while it streams.
//!
//! ```text
//! | header, postcard | counts n × 15 × u16 LE, if streamed | values n × 9 × f32 LE, if streamed |
//! ```
//!
//! The header gives the number n of scans. A block of up to [`MAX_SCANS`] goes as it comes where the line can carry
//! that. Otherwise a frame gathers several blocks ([`scans_of_frame`]), so that the size of a block depends on the
//! analysis and not on the link. A block larger than a frame travels in two. The common data of a frame's scans seldom
//! change (the supply is read ten times a second); when they do, a frame ends early.
//!
//! Counts travel uncompressed, 16 bits each. At 4 kHz all fifteen channels then need 1.35 Mbit/s of a line of 2 Mbit/s,
//! header, checksum and COBS included. Telemetry may use 1.6; the rest is for answers. Packed differences would save
//! perhaps a third at rest and nothing while the base shakes, where the frames must fit too. A frame of constant length
//! takes constant time to make and to send, and an accepted stream never fails because of its content. Samples are not
//! postcard either: its variable-length integers would make a count up to three bytes.

use serde::{Deserialize, Serialize};

use super::frame::{self, FrameError, Kind};
use super::message::StreamContent;
use super::pose;
use crate::channel::{CHANNELS, INERTIAL, JACKS, Scan};
use crate::records::SetId;
use crate::sampling::{BlockSize, Values, supply};

/// Most scans of a frame.
pub const MAX_SCANS: usize = 16;
/// Bytes of one scan's counts.
const COUNT_BYTES: usize = CHANNELS * 2;
/// Bytes of one scan's values.
const VALUE_BYTES: usize = INERTIAL * 4;
/// Upper bound of the encoded header, bytes: scan 10, scans 1, rate 5, supply 4, temperature 4, set 9, dropped 5,
/// content 3, age of the supply 1.
const MAX_HEADER: usize = 42;

/// The common data of a frame's scans.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Scan counter of the first scan; the others follow without a gap.
    pub first_scan: u64,
    /// Scans in this frame, 1 to [`MAX_SCANS`].
    pub scans: u8,
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
    /// Whether no good reading of the supply has come for a second: the supply factor may be wrong.
    pub supply_is_old: bool,
}

/// Samples for a frame, one item a scan in each list; lists outside of the content may be empty.
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    /// Counts of the inertial channels.
    pub inertial: &'a [[u16; INERTIAL]],
    /// Counts of the jacks.
    pub jacks: &'a [[u16; JACKS]],
    /// Calibrated values.
    pub values: &'a [Values],
}

/// The scans of a frame, as received.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// The common data of the scans.
    pub header: Header,
    /// Raw counts, when streamed.
    pub counts: Option<heapless::Vec<Scan, MAX_SCANS>>,
    /// Calibrated values, when streamed.
    pub values: Option<heapless::Vec<Values, MAX_SCANS>>,
}

/// Readings of the supply in a second at most: so often a frame may end early.
pub const SUPPLY_HZ: u32 = supply::READINGS_HZ;
/// Sizes of frames, scans. Each is a multiple of every smaller block.
const FRAMES: [usize; 4] = [1, 4, 8, MAX_SCANS];

/// Scans that a frame of this stream gathers: those of one block where `max_bits_per_s` of the line carry that, otherwise
/// as few as they carry, and at most [`MAX_SCANS`].
#[must_use]
pub const fn scans_of_frame(
    content: StreamContent,
    rate_hz: u32,
    block: BlockSize,
    max_bits_per_s: u32,
) -> usize {
    let mut index = 0;
    while index < FRAMES.len() {
        let scans = FRAMES[index];
        if scans >= block.scans()
            && bits_in_frames(content, rate_hz, block, scans) <= max_bits_per_s
        {
            return scans;
        }
        index += 1;
    }
    MAX_SCANS
}

/// Line capacity that a stream needs where telemetry may use `max_bits_per_s`: bit/s of 10-bit characters, all overheads
/// included.
#[must_use]
pub const fn bits_per_second(
    content: StreamContent,
    rate_hz: u32,
    block: BlockSize,
    max_bits_per_s: u32,
) -> u32 {
    let scans = scans_of_frame(content, rate_hz, block, max_bits_per_s);
    bits_in_frames(content, rate_hz, block, scans)
}

/// The same for frames with this number of scans.
const fn bits_in_frames(
    content: StreamContent,
    rate_hz: u32,
    block: BlockSize,
    in_frame: usize,
) -> u32 {
    let counts = if content.counts { COUNT_BYTES } else { 0 };
    let values = if content.values { VALUE_BYTES } else { 0 };
    let mut samples = 0;
    if content.has_blocks() {
        let frame = frame_bits(MAX_HEADER + in_frame * (counts + values));
        samples = frame * rate_hz.div_ceil(in_frame as u32);
        if in_frame > block.scans() {
            // A frame that ends early becomes two, and so does the next one at the end of the board's ring.
            samples += 2 * SUPPLY_HZ * frame_bits(MAX_HEADER);
        }
    }
    let blocks_hz = rate_hz.div_ceil(block.scans() as u32);
    let poses_hz = if blocks_hz < pose::MAX_RATE_HZ {
        blocks_hz
    } else {
        pose::MAX_RATE_HZ
    };
    let poses = if content.pose {
        frame_bits(pose::MAX_REPORT) * poses_hz
    } else {
        0
    };
    samples + poses
}

/// Bits on the line of a frame with this payload in bytes; sixteen more cover header, checksum and COBS.
const fn frame_bits(payload: usize) -> u32 {
    ((payload + 16) * 10) as u32
}

/// Encodes samples as a frame into `out` and returns its length; `header` gives the number of scans and the content.
///
/// # Errors
/// [`FrameError::Long`] when `out` is shorter than the frame, or there are fewer samples or more scans than a frame
/// holds.
pub fn encode(
    header: &Header,
    samples: Samples<'_>,
    sequence: u16,
    out: &mut [u8],
) -> Result<usize, FrameError> {
    frame::encode(Kind::Block, sequence, out, |payload| {
        write(header, samples, payload)
    })
}

/// Writes header and samples into the payload of a frame and returns their length; `None` when the payload is too
/// short or samples are missing.
fn write(header: &Header, samples: Samples<'_>, payload: &mut [u8]) -> Option<usize> {
    let scans = usize::from(header.scans);
    let mut used = postcard::to_slice(header, payload).ok()?.len();
    if header.content.counts {
        let bytes = payload.get_mut(used..used + scans * COUNT_BYTES)?;
        let (inertial, jacks) = (samples.inertial.get(..scans)?, samples.jacks.get(..scans)?);
        let counts = inertial.iter().zip(jacks);
        for (bytes, (inertial, jacks)) in bytes.chunks_exact_mut(COUNT_BYTES).zip(counts) {
            let counts = inertial.iter().chain(jacks);
            for (bytes, count) in bytes.chunks_exact_mut(2).zip(counts) {
                bytes.copy_from_slice(&count.to_le_bytes());
            }
        }
        used += scans * COUNT_BYTES;
    }
    if header.content.values {
        let bytes = payload.get_mut(used..used + scans * VALUE_BYTES)?;
        let values = samples.values.get(..scans)?.as_flattened();
        for (bytes, value) in bytes.chunks_exact_mut(4).zip(values) {
            bytes.copy_from_slice(&value.to_le_bytes());
        }
        used += scans * VALUE_BYTES;
    }
    Some(used)
}

/// Decodes the payload of a block frame; `None` when it is not a block of this version.
#[must_use]
pub fn decode(payload: &[u8]) -> Option<Block> {
    let (header, mut rest) = postcard::take_from_bytes::<Header>(payload).ok()?;
    let scans = usize::from(header.scans);
    if scans == 0 || scans > MAX_SCANS {
        return None;
    }
    let mut take = |wanted: bool, bytes: usize| {
        let (taken, after) = rest.split_at_checked(if wanted { scans * bytes } else { 0 })?;
        rest = after;
        Some(taken)
    };
    let counts = take(header.content.counts, COUNT_BYTES)?
        .as_chunks::<COUNT_BYTES>()
        .0;
    let values = take(header.content.values, VALUE_BYTES)?
        .as_chunks::<VALUE_BYTES>()
        .0;
    rest.is_empty().then(|| Block {
        header,
        counts: header
            .content
            .counts
            .then(|| counts.iter().map(scan_of).collect()),
        values: header
            .content
            .values
            .then(|| values.iter().map(values_of).collect()),
    })
}

fn scan_of(bytes: &[u8; COUNT_BYTES]) -> Scan {
    let counts = bytes.as_chunks::<2>().0;
    core::array::from_fn(|channel| u16::from_le_bytes(counts[channel]))
}

fn values_of(bytes: &[u8; VALUE_BYTES]) -> Values {
    let values = bytes.as_chunks::<4>().0;
    core::array::from_fn(|channel| f32::from_le_bytes(values[channel]))
}
