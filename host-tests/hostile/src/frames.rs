//! Bytes on the line: the deframer's output follows the layout, and it finds the next good frame.

use hexsense_core::wire::frame::{self, Closed, Deframer, Frame};
use hexsense_core::wire::{Kind, MAX_FRAME, MAX_PAYLOAD};

use crate::input::Input;

/// A receiver that is short enough for short attacks.
const SHORT: usize = 32;
/// Payload of the frame behind all damage.
const GOOD: &[u8] = b"the next good request";
const KINDS: [Kind; 6] = [
    Kind::Hello,
    Kind::Greeting,
    Kind::Request,
    Kind::Response,
    Kind::Block,
    Kind::Pose,
];

/// The bytes as they come, and as the payload of a frame that is damaged on its way.
///
/// # Panics
/// When a promise is broken.
pub fn run(data: &[u8]) {
    received::<MAX_FRAME>(data);
    received::<SHORT>(data);
    sent(Input(data));
}

/// Compares the deframer with the layout: runs between zeros, without the empty ones.
fn received<const N: usize>(data: &[u8]) {
    let mut deframer = Deframer::<N>::default();
    let mut expected = data
        .split_inclusive(|byte| *byte == 0)
        .filter_map(|run| run.strip_suffix(&[0]))
        .filter(|run| !run.is_empty());
    for byte in data {
        let Some(closed) = deframer.push(*byte) else {
            continue;
        };
        let run = expected.next().expect("a frame that nobody sent");
        match closed {
            Closed::Overlong => assert!(run.len() > N),
            Closed::Frame(bytes) => {
                assert_eq!(bytes, run);
                taken_apart(bytes);
            }
        }
    }
    assert_eq!(expected.next(), None, "a frame was lost");
    let good = encoded(Kind::Request, 7, GOOD);
    let found =
        std::iter::once(&0)
            .chain(&good)
            .fold(false, |_, byte| match deframer.push(*byte) {
                Some(Closed::Frame(bytes)) => is_good(bytes),
                _ => false,
            });
    assert!(found, "the good frame was not found");
}

/// A decoded frame is the same after it is encoded again.
fn taken_apart(bytes: &mut [u8]) {
    let Ok(received) = frame::decode(bytes) else {
        return;
    };
    // A receiver may be one byte longer than a frame.
    if received.payload.len() <= MAX_PAYLOAD {
        let mut again = encoded(received.kind, received.sequence, received.payload);
        let length = again.len() - 1;
        assert_eq!(frame::decode(&mut again[..length]), Ok(received));
    }
}

/// A frame with one byte changed, or cut short, and a good one behind it.
fn sent(mut input: Input) {
    let (kind, sequence) = (input.pick(&KINDS), input.short());
    let (place, value, cut) = (input.short(), input.byte(), input.byte());
    let payload = input.bytes(MAX_PAYLOAD);
    let mut stream = encoded(kind, sequence, payload);
    let sent = Frame {
        kind,
        sequence,
        payload,
    };
    let length = stream.len();
    assert_eq!(frame::decode(&mut stream.clone()[..length - 1]), Ok(sent));
    stream[usize::from(place) % length] ^= value;
    stream.truncate(length - usize::from(cut) % length);
    stream.push(0);
    stream.extend(encoded(Kind::Request, 7, GOOD));
    let mut deframer = Deframer::<MAX_FRAME>::default();
    let mut found = false;
    for byte in &stream {
        match deframer.push(*byte) {
            Some(Closed::Frame(bytes)) => found = is_good(bytes),
            Some(Closed::Overlong) => found = false,
            None => {}
        }
    }
    assert!(found, "the good frame was not found");
}

fn is_good(bytes: &mut [u8]) -> bool {
    frame::decode(bytes).is_ok_and(|frame| frame.payload == GOOD)
}

pub(crate) fn encoded(kind: Kind, sequence: u16, payload: &[u8]) -> Vec<u8> {
    let mut out = vec![0; MAX_FRAME];
    let length = frame::encode(kind, sequence, &mut out, |place| {
        place.get_mut(..payload.len())?.copy_from_slice(payload);
        Some(payload.len())
    });
    out.truncate(length.expect("a payload of at most the longest fits"));
    out
}
