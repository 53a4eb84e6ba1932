//! The line to the board, frame by frame.
//!
//! ```text
//! bytes, requests → FrameLine → transport
//! transport → FrameLine → frames, each with its time of arrival
//! ```
//!
//! This layer repeats no request and waits for no answer: `conversation` does that for the host tool, and tests
//! of the board do it in their own way.

use std::time::Duration;

use hexsense_core::wire::frame::{self, Closed, Deframer};
use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::message::{decode_response, encode_request};
use hexsense_core::wire::telemetry::{self, Block};
use hexsense_core::wire::{Kind, MAX_FRAME, PoseReport, Request, Response, pose};

use super::missing::Missing;
use super::port;
use super::transport::{Transport, TransportError};

/// The host's end of the line.
pub struct FrameLine {
    transport: Box<dyn Transport>,
    deframer: Box<Deframer<MAX_FRAME>>,
    received: Vec<u8>,
    /// Bytes since the last frame ended.
    held: usize,
    sequence: u16,
    damaged: u64,
    missing: Missing,
}

/// A frame that arrived whole.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrived {
    /// When its last byte was read, by the clock of the transport.
    pub at: Duration,
    /// Bytes that it took on the line, its closing zero and what lay before it included.
    pub bytes: usize,
    /// Number of the request that it answers, or of the telemetry frame.
    pub sequence: u16,
    /// What it carries.
    pub content: Content,
}

/// What a frame of the board carries.
#[derive(Debug, Clone, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "one block in a stream of blocks is the usual case"
)]
pub enum Content {
    /// The answer to a hello.
    Greeting(Greeting),
    /// The answer to a request; `None` when it cannot be decoded.
    Response(Option<Response>),
    /// Scans.
    Block(Block),
    /// A pose that the board found.
    Pose(PoseReport),
}

impl FrameLine {
    /// Opens `port`; see [`port::open`].
    ///
    /// # Errors
    /// [`TransportError`].
    pub fn open(port: &str) -> Result<Self, TransportError> {
        port::open(port).map(Self::new)
    }

    /// A line over an open transport.
    #[must_use]
    pub fn new(transport: Box<dyn Transport>) -> Self {
        Self {
            transport,
            deframer: Box::default(),
            received: Vec::new(),
            held: 0,
            sequence: 0,
            damaged: 0,
            missing: Missing::default(),
        }
    }

    /// Time by the clock of the transport; in lockstep it is the board's.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.transport.now()
    }

    /// The port as it was asked for.
    #[must_use]
    pub fn port(&self) -> &str {
        self.transport.port()
    }

    /// Whether the clock of the transport goes on while no host reads.
    #[must_use]
    pub fn is_real_time(&self) -> bool {
        self.transport.is_real_time()
    }

    /// Frames that arrived damaged: too long, not COBS, with a wrong checksum, or with telemetry that cannot be decoded.
    #[must_use]
    pub fn damaged(&self) -> u64 {
        self.damaged
    }

    /// Telemetry frames, blocks and poses, that the board numbered and that did not arrive whole.
    #[must_use]
    pub fn missing(&self) -> u64 {
        self.missing.frames()
    }

    /// Sends bytes as they are. In lockstep they leave with the next [`FrameLine::receive`].
    ///
    /// # Errors
    /// [`TransportError`].
    pub fn send_bytes(&mut self, bytes: &[u8]) -> Result<(), TransportError> {
        self.transport.write(bytes)
    }

    /// Sends a request and returns its number, which the answer repeats.
    ///
    /// # Errors
    /// [`TransportError`].
    pub fn send(&mut self, request: &Request) -> Result<u16, TransportError> {
        self.send_frame(|sequence, out| encode_request(request, sequence, out).unwrap_or(0))
    }

    /// Asks the board for its greeting.
    ///
    /// # Errors
    /// [`TransportError`].
    pub fn send_hello(&mut self) -> Result<u16, TransportError> {
        self.send_frame(|sequence, out| {
            frame::encode(Kind::Hello, sequence, out, |_| Some(0)).unwrap_or(0)
        })
    }

    /// Sends what `encode` writes; every request is far shorter than the longest frame, so it always fits.
    fn send_frame(
        &mut self,
        encode: impl FnOnce(u16, &mut [u8]) -> usize,
    ) -> Result<u16, TransportError> {
        self.sequence = self.sequence.wrapping_add(1);
        // The zero closes half a frame that the board may still hold.
        let mut bytes = [0; 1 + MAX_FRAME];
        let length = encode(self.sequence, &mut bytes[1..]);
        self.transport.write(&bytes[..=length])?;
        Ok(self.sequence)
    }

    /// Waits until bytes come, at most for `timeout` by the clock of the transport; the frames that end in them, in the
    /// order in which they arrived.
    ///
    /// # Errors
    /// [`TransportError`]. That nothing comes in time is no error.
    pub fn receive(&mut self, timeout: Duration) -> Result<Vec<Arrived>, TransportError> {
        self.received.clear();
        self.transport.read(&mut self.received, timeout)?;
        let at = self.transport.now();
        let mut frames = Vec::new();
        for byte in &self.received {
            self.held += 1;
            let Some(closed) = self.deframer.push(*byte) else {
                continue;
            };
            let bytes = std::mem::take(&mut self.held);
            match content(closed) {
                None => self.damaged += 1,
                Some((sequence, content)) => {
                    if matches!(content, Content::Block(_) | Content::Pose(_)) {
                        self.missing.take(sequence);
                    }
                    frames.push(Arrived {
                        at,
                        bytes,
                        sequence,
                        content,
                    });
                }
            }
        }
        Ok(frames)
    }
}

/// Number and content of a frame; `None` for a damaged one and for one that only hosts send.
fn content(closed: Closed) -> Option<(u16, Content)> {
    let Closed::Frame(bytes) = closed else {
        return None;
    };
    let frame = frame::decode(bytes).ok()?;
    let content = match frame.kind {
        Kind::Greeting => Content::Greeting(Greeting::decode(frame.payload)?),
        Kind::Response => Content::Response(decode_response(frame.payload)),
        Kind::Block => Content::Block(telemetry::decode(frame.payload)?),
        Kind::Pose => Content::Pose(pose::decode(frame.payload)?),
        Kind::Hello | Kind::Request => return None,
    };
    Some((frame.sequence, content))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives what it holds, piece by piece, a millisecond apart.
    struct Pieces {
        pieces: std::vec::IntoIter<Vec<u8>>,
        now: Duration,
    }

    impl Transport for Pieces {
        fn write(&mut self, _: &[u8]) -> Result<(), TransportError> {
            Ok(())
        }

        fn read(&mut self, into: &mut Vec<u8>, _: Duration) -> Result<(), TransportError> {
            self.now += Duration::from_millis(1);
            into.extend(self.pieces.next().unwrap_or_default());
            Ok(())
        }

        fn now(&self) -> Duration {
            self.now
        }

        fn port(&self) -> &str {
            "pieces"
        }
    }

    #[test]
    fn a_frame_in_two_pieces_arrives_with_the_second_and_a_damaged_one_is_counted() {
        let greeting = Greeting {
            wire: 7,
            firmware: [1, 2, 3],
        };
        let mut buffer = [0; MAX_FRAME];
        let length = greeting.encode(9, &mut buffer).unwrap();
        let whole = &buffer[..length];
        let mut damaged = whole.to_vec();
        damaged[5] ^= 0x10;
        let (head, tail) = whole.split_at(4);
        let pieces = vec![damaged, head.to_vec(), [tail, whole].concat()];
        let mut line = FrameLine::new(Box::new(Pieces {
            pieces: pieces.into_iter(),
            now: Duration::ZERO,
        }));
        assert_eq!(line.receive(Duration::ZERO).unwrap(), []);
        assert_eq!(line.damaged(), 1);
        assert_eq!(line.receive(Duration::ZERO).unwrap(), []);
        let arrived = line.receive(Duration::ZERO).unwrap();
        assert_eq!(arrived.len(), 2);
        for frame in arrived {
            let at = Duration::from_millis(3);
            let expected = (at, length, 9, Content::Greeting(greeting));
            let found = (frame.at, frame.bytes, frame.sequence, frame.content);
            assert_eq!(found, expected);
        }
        assert_eq!(line.damaged(), 1);
    }
}
