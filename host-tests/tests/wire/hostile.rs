//! No bytes make a decoder panic.

use hexsense_core::records::CoefficientSet;
use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::{MAX_FRAME, Response, frame, message, pose, telemetry};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use crate::messages;

fn decode_everything(bytes: &[u8]) {
    let _ = message::decode_request(bytes);
    let _ = message::decode_response(bytes);
    let _ = telemetry::decode(bytes);
    let _ = pose::decode(bytes);
    let _ = Greeting::decode(bytes);
    let _ = CoefficientSet::decode(bytes);
    let _ = frame::decode(&mut bytes.to_vec());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn random_bytes_are_survived(bytes in vec(any::<u8>(), 0..200)) {
        decode_everything(&bytes);
    }

    /// Bytes that start right get further into the decoders than random ones.
    #[test]
    fn nearly_right_bytes_are_survived(
        response in messages::message::<Response>(), changes in vec((any::<Index>(), any::<u8>()), 1..4), cut: Index,
    ) {
        let mut out = [0; MAX_FRAME];
        let length = message::encode_response(&response, 0, &mut out).unwrap();
        let mut payload = frame::decode(&mut out[..length - 1]).unwrap().payload.to_vec();
        for (place, byte) in changes {
            let place = place.index(payload.len());
            payload[place] = byte;
        }
        decode_everything(&payload);
        decode_everything(&payload[..cut.index(payload.len())]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn long_random_bytes_are_survived(bytes in vec(any::<u8>(), 1_000..1_400)) {
        decode_everything(&bytes);
    }
}
