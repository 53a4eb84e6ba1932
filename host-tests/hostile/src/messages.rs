//! Payloads: no payload makes a decoder panic, and a decoded message is the same after it is encoded again.

use hexsense_core::channel::{CHANNELS, INERTIAL};
use hexsense_core::harmonics::analyser::MAX_BLOCKS;
use hexsense_core::harmonics::{Analyser, HARMONICS};
use hexsense_core::records::MAX_ENCODED;
use hexsense_core::sampling::BlockSums;
use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::message::{self, Request, Response};
use hexsense_core::wire::telemetry::{self, Block, Samples};
use hexsense_core::wire::{Drive, FrameError, MAX_FRAME, PoseReport, frame, pose};

/// The first byte chooses the decoder of the others.
///
/// # Panics
/// When a promise is broken.
pub fn run(data: &[u8]) {
    let Some((decoder, payload)) = data.split_first() else {
        return;
    };
    match decoder % 5 {
        0 => request(payload),
        1 => response(payload),
        2 => again(payload, telemetry::decode, encode_block),
        3 => again(payload, pose::decode, |report: &PoseReport, out| {
            pose::encode(report, 0, out)
        }),
        _ => again(payload, Greeting::decode, |greeting, out| {
            greeting.encode(0, out)
        }),
    }
}

fn request(payload: &[u8]) {
    let behind = [payload, &[0]].concat();
    let decodes = message::decode_request(payload).is_some();
    assert!(
        !decodes || message::decode_request(&behind).is_none(),
        "a request with something behind it was taken"
    );
    again(payload, message::decode_request, |request, out| {
        message::encode_request(request, 0, out)
    });
    if let Some(Request::Drive { drive, .. }) = message::decode_request(payload) {
        estimated(drive);
    }
}

fn response(payload: &[u8]) {
    again(payload, message::decode_response, |response, out| {
        message::encode_response(response, 0, out)
    });
    match message::decode_response(payload) {
        Some(Response::Refused(refusal)) => assert!(!refusal.to_string().is_empty()),
        Some(Response::SetBytes { bytes, .. }) => assert!(bytes.len() <= MAX_ENCODED),
        _ => {}
    }
}

/// A drive that passes the check can be estimated by the board: all its harmonics are below Nyquist.
fn estimated(drive: Drive) {
    if drive.check().is_err() {
        return;
    }
    let turns = (HARMONICS * drive.block.scans()) as f64 * drive.frequency_hz(1);
    assert!(drive.increment > 0 && turns <= 0.5, "{drive:?}");
    assert!((1..=MAX_BLOCKS).contains(&drive.blocks), "{drive:?}");
    let mut analyser = Analyser::new();
    analyser.start(drive);
    let scans = vec![[u16::MAX; CHANNELS]; drive.block.scans()];
    for block in 0..4 {
        let first_scan = block * scans.len() as u64;
        analyser.take(&BlockSums::of_scans(&scans, first_scan));
    }
    assert!(analyser.report(CHANNELS).is_none());
}

/// Decodes, encodes and decodes again; both encodings are the same.
fn again<T>(
    payload: &[u8],
    decode: impl Fn(&[u8]) -> Option<T>,
    encode: impl Fn(&T, &mut [u8]) -> Result<usize, FrameError>,
) {
    let Some(message) = decode(payload) else {
        return;
    };
    let mut first = [0; MAX_FRAME];
    let length = encode(&message, &mut first).expect("what arrived fits a frame");
    let mut bytes = first;
    let received = frame::decode(&mut bytes[..length - 1]).expect("an own frame");
    assert!(received.payload.len() <= payload.len());
    let message = decode(received.payload).expect("an own message");
    let mut second = [0; MAX_FRAME];
    assert_eq!(encode(&message, &mut second), Ok(length));
    assert_eq!(first[..length], second[..length]);
}

fn encode_block(block: &Block, out: &mut [u8]) -> Result<usize, FrameError> {
    let counts = block.counts.as_deref().unwrap_or_default();
    let inertial: Vec<_> = counts
        .iter()
        .map(|scan| std::array::from_fn(|channel| scan[channel]))
        .collect();
    let jacks: Vec<_> = counts
        .iter()
        .map(|scan| std::array::from_fn(|jack| scan[INERTIAL + jack]))
        .collect();
    let samples = Samples {
        inertial: &inertial,
        jacks: &jacks,
        values: block.values.as_deref().unwrap_or_default(),
    };
    telemetry::encode(&block.header, samples, 0, out)
}
