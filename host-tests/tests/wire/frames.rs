//! The receiver detects a damaged frame and finds the frame after it.

use hexsense_core::wire::frame::{self, Closed, Deframer, FrameError};
use hexsense_core::wire::{Frame, Kind, MAX_FRAME, Request, message};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::messages;

fn encoded(request: &Request, sequence: u16) -> Vec<u8> {
    let mut out = [0; MAX_FRAME];
    let length = message::encode_request(request, sequence, &mut out).unwrap();
    out[..length].to_vec()
}

/// Kind, sequence number and payload of a frame.
type Whole = (Kind, u16, Vec<u8>);

/// All frames that a receiver finds in a stream of bytes.
fn received<const N: usize>(stream: &[u8]) -> Vec<Result<Whole, Damage>> {
    let mut deframer = Deframer::<N>::default();
    let close = |byte: &u8| {
        Some(match deframer.push(*byte)? {
            Closed::Frame(bytes) => frame::decode(bytes).map(own).map_err(Damage::Frame),
            Closed::Overlong => Err(Damage::Overlong),
        })
    };
    stream.iter().filter_map(close).collect()
}

fn own(frame: Frame) -> Whole {
    (frame.kind, frame.sequence, frame.payload.to_vec())
}

#[derive(Debug, Clone, PartialEq)]
enum Damage {
    Frame(FrameError),
    Overlong,
}

fn finds(stream: &[u8], request: &Request, sequence: u16) -> bool {
    let last = received::<MAX_FRAME>(stream).pop();
    last.is_some_and(|frame| {
        frame.is_ok_and(|(kind, number, payload)| {
            kind == Kind::Request
                && number == sequence
                && message::decode_request(&payload).as_ref() == Some(request)
        })
    })
}

#[test]
fn any_changed_byte_of_a_frame_is_noticed() {
    let chunk = |bytes: &[u8]| Request::UploadChunk {
        offset: 3,
        bytes: heapless::Vec::from_slice(bytes).unwrap(),
    };
    // With zeros that COBS has to move, and without.
    for request in [
        Request::Identity,
        chunk(&[0; 5]),
        chunk(&[7, 0, 9]),
        chunk(&[0xFF; 40]),
    ] {
        let sent = encoded(&request, 0x0100);
        for place in 0..sent.len() {
            for change in 1..=0xFF {
                let mut damaged = sent.clone();
                damaged[place] ^= change;
                let whole = received::<MAX_FRAME>(&damaged)
                    .into_iter()
                    .find(Result::is_ok);
                assert_eq!(
                    whole, None,
                    "byte {place} of {request:?} changed by {change:#x}"
                );
            }
        }
    }
}

#[test]
fn an_unknown_kind_with_a_good_checksum_is_named() {
    let mut message = vec![9, 0, 0];
    let checksum = crc32(&message).to_le_bytes();
    message.extend(checksum);
    let mut bytes = vec![0; 32];
    let length = cobs_encode(&message, &mut bytes);
    assert_eq!(
        frame::decode(&mut bytes[..length]),
        Err(FrameError::Kind { kind: 9 })
    );
}

#[test]
fn a_frame_without_room_for_header_and_checksum_is_named() {
    for length in 0..7 {
        let mut bytes = vec![length as u8 + 1];
        bytes.extend(vec![1; length]);
        assert_eq!(frame::decode(&mut bytes), Err(FrameError::Short { length }));
    }
}

/// COBS of a short message, byte by byte as the definition says.
fn cobs_encode(message: &[u8], out: &mut [u8]) -> usize {
    let (mut code, mut end) = (0, 1);
    for byte in message {
        if *byte == 0 {
            out[code] = (end - code) as u8;
            code = end;
        } else {
            out[end] = *byte;
        }
        end += 1;
    }
    out[code] = (end - code) as u8;
    end
}

/// CRC-32 of ISO-HDLC, bit by bit; of "123456789" it is 0xCBF43926.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 * (crc & 1))
        })
    })
}

#[test]
fn a_frame_is_laid_out_as_documented() {
    assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    let mut message = vec![Kind::Request as u8, 0x34, 0x12, 0x00];
    let checksum = crc32(&message).to_le_bytes();
    message.extend(checksum);
    let mut expected = vec![0; 32];
    let length = cobs_encode(&message, &mut expected);
    expected.truncate(length + 1);
    assert_eq!(encoded(&Request::Identity, 0x1234), expected);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn a_frame_is_found_after_garbage_that_a_zero_closed(
        mut stream in vec(any::<u8>(), 0..3_000), request in messages::message::<Request>(), sequence: u16,
    ) {
        stream.push(0);
        stream.extend(encoded(&request, sequence));
        prop_assert!(finds(&stream, &request, sequence));
    }

    #[test]
    fn garbage_costs_at_most_the_frame_it_runs_into(
        mut stream in vec(any::<u8>(), 0..3_000), requests in vec(messages::message::<Request>(), 2), sequence: u16,
    ) {
        stream.extend(encoded(&requests[0], sequence));
        stream.extend(encoded(&requests[1], sequence.wrapping_add(1)));
        prop_assert!(finds(&stream, &requests[1], sequence.wrapping_add(1)));
    }

    #[test]
    fn lost_bytes_cost_at_most_the_frame_they_belong_to_and_the_next(
        requests in vec(messages::message::<Request>(), 3), from: prop::sample::Index, lost in 1_usize..20,
    ) {
        let mut stream = encoded(&requests[0], 1);
        let start = from.index(stream.len());
        let end = (start + lost).min(stream.len());
        stream.drain(start..end);
        stream.extend(encoded(&requests[1], 2));
        let whole: Vec<_> = received::<MAX_FRAME>(&stream).into_iter().flatten().collect();
        prop_assert!(whole.iter().all(|(_, sequence, _)| *sequence == 2), "half a frame passed");
        stream.extend(encoded(&requests[2], 3));
        prop_assert!(finds(&stream, &requests[2], 3));
    }
}

#[test]
fn a_run_longer_than_any_frame_is_dropped_once_and_the_next_frame_found() {
    for extra in [1, 2, 500] {
        let mut stream = vec![0x55; 64 + extra];
        stream.push(0);
        let frame = encoded(&Request::Status, 7);
        stream.extend(&frame);
        let all = received::<64>(&stream);
        assert_eq!(all[0], Err(Damage::Overlong));
        assert_eq!(all[1].as_ref().map(|frame| frame.1), Ok(7));
        assert_eq!(all.len(), 2);
    }
}

#[test]
fn a_run_as_long_as_the_receiver_is_kept() {
    let mut deframer = Deframer::<64>::default();
    for _ in 0..64 {
        assert_eq!(deframer.push(0x55), None);
    }
    assert_eq!(deframer.push(0), Some(Closed::Frame(&mut [0x55; 64])));
}
