//! Frames, which delimit, number and check messages.
//!
//! COBS takes the zero byte out of a message, so that a zero always ends a frame and a receiver that joins late or
//! has lost bytes finds the next frame by itself.

use serde::{Deserialize, Serialize};

use crate::checksum::checksum;

const HEADER: usize = 3;
const TRAILER: usize = 4;
/// Longest payload of a frame, bytes.
pub const MAX_PAYLOAD: usize = 1_152;
/// Longest frame on the line, bytes: COBS adds one byte in 254 and one more, and the closing zero follows.
pub const MAX_FRAME: usize = {
    let message = HEADER + MAX_PAYLOAD + TRAILER;
    message + message / 254 + 2
};

/// The content of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Asks for the board's version; never changes.
    Hello = 0,
    /// Answers a hello; never changes.
    Greeting = 1,
    /// A [`super::Request`].
    Request = 2,
    /// A [`super::Response`].
    Response = 3,
    /// A block of samples, see [`super::telemetry`].
    Block = 4,
    /// The board's own pose, see [`super::pose`].
    Pose = 5,
}

impl Kind {
    fn from_byte(byte: u8) -> Option<Self> {
        [
            Self::Hello,
            Self::Greeting,
            Self::Request,
            Self::Response,
            Self::Block,
            Self::Pose,
        ]
        .into_iter()
        .find(|kind| *kind as u8 == byte)
    }
}

/// A decoded frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    /// The kind of the payload.
    pub kind: Kind,
    /// Number of the request (echoed by its response), or of the telemetry frame.
    pub sequence: u16,
    /// The message.
    pub payload: &'a [u8],
}

/// Why received bytes are not a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// Not COBS.
    #[error("the bytes between two zeros are not COBS")]
    Encoding,
    /// Shorter than header and checksum.
    #[error("a frame of {length} bytes is too short")]
    Short {
        /// Bytes after decoding.
        length: usize,
    },
    /// The checksum does not match.
    #[error("the checksum of a frame does not fit: bytes were lost or changed on the line")]
    Checksum,
    /// An unknown kind.
    #[error("frame kind {kind} is unknown: the other side speaks another version")]
    Kind {
        /// As received.
        kind: u8,
    },
    /// The payload does not fit a frame or the buffer.
    #[error("a payload of {length} bytes does not fit a frame (at most {MAX_PAYLOAD})")]
    Long {
        /// Bytes of payload.
        length: usize,
    },
}

/// Encodes one frame into `out`, closing zero included, and returns its length in bytes.
///
/// `fill` writes the payload into the slice it is given and returns the payload's length, or `None` when it does
/// not fit.
///
/// # Errors
/// [`FrameError::Long`]; `out` of [`MAX_FRAME`] bytes and a payload of at most [`MAX_PAYLOAD`] always fit.
pub fn encode(
    kind: Kind,
    sequence: u16,
    out: &mut [u8],
    fill: impl FnOnce(&mut [u8]) -> Option<usize>,
) -> Result<usize, FrameError> {
    let mut fill = Some(fill);
    encode_filled(kind, sequence, out, &mut |payload| fill.take()?(payload))
}

/// Does the work of [`encode`], of which the firmware would have one for each kind of payload.
fn encode_filled(
    kind: Kind,
    sequence: u16,
    out: &mut [u8],
    fill: &mut dyn FnMut(&mut [u8]) -> Option<usize>,
) -> Result<usize, FrameError> {
    let mut message = [0; HEADER + MAX_PAYLOAD + TRAILER];
    message[0] = kind as u8;
    message[1..HEADER].copy_from_slice(&sequence.to_le_bytes());
    let length = fill(&mut message[HEADER..HEADER + MAX_PAYLOAD])
        .filter(|length| *length <= MAX_PAYLOAD)
        .ok_or(FrameError::Long {
            length: MAX_PAYLOAD + 1,
        })?;
    let body = HEADER + length;
    let sum = checksum(&message[..body]);
    message[body..body + TRAILER].copy_from_slice(&sum.to_le_bytes());
    let message = &message[..body + TRAILER];
    if out.len() < cobs::max_encoding_length(message.len()) + 1 {
        return Err(FrameError::Long { length });
    }
    let encoded = cobs::encode(message, out);
    out[encoded] = 0;
    Ok(encoded + 1)
}

/// Encodes a message as postcard in one frame, as [`encode`] does.
pub(super) fn encode_message(
    kind: Kind,
    message: &impl Serialize,
    sequence: u16,
    out: &mut [u8],
) -> Result<usize, FrameError> {
    encode(kind, sequence, out, |payload| {
        Some(postcard::to_slice(message, payload).ok()?.len())
    })
}

/// Decodes a message that takes all of the payload.
pub(super) fn decode_message<'p, T: Deserialize<'p>>(payload: &'p [u8]) -> Option<T> {
    let mut from = postcard::Deserializer::from_bytes(payload);
    let message = T::deserialize(&mut from).ok();
    message.filter(|_| from.finalize().is_ok_and(<[u8]>::is_empty))
}

/// Decodes a frame in place; `bytes` are those between two zeros, without them.
///
/// # Errors
/// Every variant of [`FrameError`] but `Long`.
pub fn decode(bytes: &mut [u8]) -> Result<Frame<'_>, FrameError> {
    let length = cobs::decode_in_place(bytes).map_err(|_| FrameError::Encoding)?;
    let message = &bytes[..length];
    let (body, sum) = message
        .split_last_chunk::<TRAILER>()
        .ok_or(FrameError::Short { length })?;
    let ([kind, low, high], payload) = body
        .split_first_chunk::<HEADER>()
        .ok_or(FrameError::Short { length })?;
    if u32::from_le_bytes(*sum) != checksum(body) {
        return Err(FrameError::Checksum);
    }
    let kind = Kind::from_byte(*kind).ok_or(FrameError::Kind { kind: *kind })?;
    Ok(Frame {
        kind,
        sequence: u16::from_le_bytes([*low, *high]),
        payload,
    })
}

/// Collects received bytes into frames; `N` is the longest accepted run of bytes between two zeros.
///
/// Holds one frame at a time. A run that is longer than `N` is dropped and counted when its zero comes.
#[derive(Debug)]
pub struct Deframer<const N: usize> {
    bytes: [u8; N],
    length: usize,
    overlong: bool,
}

/// The bytes before a received zero.
#[derive(Debug, PartialEq, Eq)]
pub enum Closed<'a> {
    /// Bytes for [`decode`].
    Frame(&'a mut [u8]),
    /// A run of bytes longer than any frame; it was dropped.
    Overlong,
}

impl<const N: usize> Default for Deframer<N> {
    fn default() -> Self {
        Self {
            bytes: [0; N],
            length: 0,
            overlong: false,
        }
    }
}

impl<const N: usize> Deframer<N> {
    /// Takes one byte; a zero closes the bytes before it. Empty runs are ignored.
    pub fn push(&mut self, byte: u8) -> Option<Closed<'_>> {
        if byte != 0 {
            match self.bytes.get_mut(self.length) {
                Some(slot) => {
                    *slot = byte;
                    self.length += 1;
                }
                None => self.overlong = true,
            }
            return None;
        }
        let length = core::mem::take(&mut self.length);
        if core::mem::take(&mut self.overlong) {
            return Some(Closed::Overlong);
        }
        if length == 0 {
            None
        } else {
            Some(Closed::Frame(&mut self.bytes[..length]))
        }
    }
}
