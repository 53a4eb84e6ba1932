//! Each side reads every message of the other unchanged.

use hexsense_core::channel::{INERTIAL, JACKS, Scan};
use hexsense_core::wire::frame::{self, Closed, Deframer};
use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::telemetry::Samples;
use hexsense_core::wire::{
    Frame, Kind, MAX_FRAME, PoseReport, Request, Response, message, pose, telemetry,
};
use proptest::prelude::*;

use crate::messages;

/// The two converters' parts of scans.
fn split(scans: &[Scan]) -> (Vec<[u16; INERTIAL]>, Vec<[u16; JACKS]>) {
    let parts = |scan: &Scan| (*scan.first_chunk().unwrap(), *scan.last_chunk().unwrap());
    scans.iter().map(parts).unzip()
}

/// Sends the frame through a receiver and decodes it.
fn receive<T>(sent: &[u8], read: impl Fn(Frame) -> Option<T>) -> Option<T> {
    let mut deframer = Deframer::<MAX_FRAME>::default();
    let (last, body) = sent.split_last()?;
    for byte in body {
        assert_eq!(deframer.push(*byte), None, "a frame ends only at its zero");
    }
    match deframer.push(*last)? {
        Closed::Frame(bytes) => read(frame::decode(bytes).ok()?),
        Closed::Overlong => None,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn every_request_arrives_as_sent(request in messages::message::<Request>(), sequence: u16) {
        let mut out = [0; MAX_FRAME];
        let length = message::encode_request(&request, sequence, &mut out).unwrap();
        let received = receive(&out[..length], |frame| {
            (frame.kind == Kind::Request && frame.sequence == sequence)
                .then(|| message::decode_request(frame.payload))?
        });
        prop_assert_eq!(received, Some(request));
        let payload = frame::decode(&mut out[..length - 1]).unwrap().payload;
        prop_assert_eq!(message::decode_request(&[payload, &[0]].concat()), None, "with something behind");
    }

    #[test]
    fn every_response_arrives_as_sent(response in messages::message::<Response>(), sequence: u16) {
        let mut out = [0; MAX_FRAME];
        let length = message::encode_response(&response, sequence, &mut out).unwrap();
        let received = receive(&out[..length], |frame| {
            (frame.kind == Kind::Response && frame.sequence == sequence)
                .then(|| message::decode_response(frame.payload))?
        });
        prop_assert_eq!(received, Some(response));
        let payload = frame::decode(&mut out[..length - 1]).unwrap().payload;
        prop_assert_eq!(message::decode_response(&[payload, &[0]].concat()), None, "with something behind");
    }

    #[test]
    fn every_greeting_arrives_as_sent(wire: u16, firmware: [u8; 3], sequence: u16) {
        let greeting = Greeting { wire, firmware };
        let mut out = [0; MAX_FRAME];
        let length = greeting.encode(sequence, &mut out).unwrap();
        let received = receive(&out[..length], |frame| {
            (frame.kind == Kind::Greeting && frame.sequence == sequence)
                .then(|| Greeting::decode(frame.payload))?
        });
        prop_assert_eq!(received, Some(greeting));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn every_pose_arrives_as_sent(report in messages::message::<PoseReport>(), sequence: u16) {
        let mut out = [0; MAX_FRAME];
        let length = pose::encode(&report, sequence, &mut out).unwrap();
        let received = receive(&out[..length], |frame| {
            (frame.kind == Kind::Pose && frame.sequence == sequence)
                .then(|| pose::decode(frame.payload))?
        });
        prop_assert_eq!(received, Some(report));
        let payload = frame::decode(&mut out[..length - 1]).unwrap().payload;
        prop_assert_eq!(pose::decode(&payload[..payload.len() - 1]), None, "cut short");
        prop_assert_eq!(pose::decode(&[payload, &[0]].concat()), None, "with something behind");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn every_block_arrives_as_sent(block in messages::block(), sequence: u16) {
        let (inertial, jacks) = split(block.counts.as_deref().unwrap_or_default());
        let samples = Samples {
            inertial: &inertial,
            jacks: &jacks,
            values: block.values.as_deref().unwrap_or_default(),
        };
        let mut out = [0; MAX_FRAME];
        let length =
            telemetry::encode(&block.header, samples, sequence, &mut out).unwrap();
        let received = receive(&out[..length], |frame| {
            (frame.kind == Kind::Block && frame.sequence == sequence)
                .then(|| telemetry::decode(frame.payload))?
        });
        prop_assert_eq!(received, Some(block));
        let payload = frame::decode(&mut out[..length - 1]).unwrap().payload;
        prop_assert_eq!(telemetry::decode(&payload[..payload.len() - 1]), None, "cut short");
        prop_assert_eq!(telemetry::decode(&[payload, &[0]].concat()), None, "with something behind");
    }
}

#[test]
fn a_greeting_of_a_later_version_is_read_by_an_older_reader() {
    let greeting = *b"hexsense\x02\x01\x03\x04\x05 and what later versions append";
    assert_eq!(
        Greeting::decode(&greeting),
        Some(Greeting {
            wire: 0x0102,
            firmware: [3, 4, 5],
        })
    );
}

#[test]
fn what_is_no_greeting_is_not_taken_for_one() {
    let greeting = *b"hexsense\x01\x00\x01\x02\x03";
    assert!(Greeting::decode(&greeting).is_some());
    assert_eq!(Greeting::decode(&greeting[..12]), None);
    for place in 0..8 {
        let mut other = greeting;
        other[place] ^= 1;
        assert_eq!(Greeting::decode(&other), None);
    }
}
