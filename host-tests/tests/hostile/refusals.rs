//! Wrong lengths, numbers that are not finite, frequencies above Nyquist and zero periods: each is refused by its name.

use std::cell::RefCell;

use hexsense::FACTS;
use hexsense_core::harmonics::analyser::MAX_BLOCKS;
use hexsense_core::harmonics::drive::increment;
use hexsense_core::harmonics::{Drive, DriveError};
use hexsense_core::records::{CoefficientSet, MAX_ENCODED};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::change::Act;
use hexsense_core::wire::message::{CHUNK, Request, decode_request, encode_request};
use hexsense_core::wire::{MAX_FRAME, Refusal, Response, frame};
use hostile::bases::{BASES, CONTENTS};
use hostile::key_holder::{KEYS, KeyHolder, Shared, upload_of};
use hostile::sets::{encoded, numbered};
use proptest::prelude::*;

/// The request after its way over the line.
fn arrived(request: &Request) -> Option<Request> {
    let mut out = [0; MAX_FRAME];
    let length = encode_request(request, 0, &mut out).unwrap();
    decode_request(frame::decode(&mut out[..length - 1]).unwrap().payload)
}

fn checked(drive: Drive) -> Result<(), DriveError> {
    match arrived(&Request::Drive { analyser: 0, drive }) {
        Some(Request::Drive { drive, .. }) => drive.check(),
        other => panic!("{other:?}"),
    }
}

/// All numbers of a set.
fn numbers(set: &mut CoefficientSet) -> Vec<&mut f32> {
    let triads = set.triads.iter_mut().flat_map(|triad| {
        let offsets = triad.offset.iter_mut().chain(&mut triad.offset_uncertainty);
        let matrices = triad
            .matrix
            .iter_mut()
            .chain(&mut triad.matrix_uncertainty)
            .flatten();
        offsets.chain(matrices).chain([&mut triad.delay_s])
    });
    let base = &mut set.base;
    let hinges = base.lower.iter_mut().chain(&mut base.upper).flatten();
    let lengths = [
        &mut base.length_min_m,
        &mut base.length_max_m,
        &mut base.home_height_m,
    ];
    let jacks = set.jacks.zero_counts.iter_mut();
    let jacks = jacks.chain(&mut set.jacks.metres_per_count);
    let others = [&mut set.temperature_c, &mut set.jacks.zero_length_m];
    triads
        .chain(hinges)
        .chain(lengths)
        .chain(jacks)
        .chain(others)
        .collect()
}

/// A board with a key and a set refuses the upload of these bytes as `is_expected` demands, changes nothing, and takes
/// the next good one.
fn refused(act: Act, bytes: &[u8], is_expected: impl Fn(Refusal) -> bool) {
    let nor = RefCell::new(BASES[2].clone());
    let (mut key_holder, _) = KeyHolder::start(Shared(&nor));
    let (active, operations) = (key_holder.active(), nor.borrow().operations);
    let answer = key_holder
        .change(&KEYS[0], act)
        .and_then(|_| key_holder.send(bytes));
    assert!(answer.clone().is_err_and(&is_expected), "{answer:?}");
    assert_eq!(
        (key_holder.active(), nor.borrow().operations),
        (active, operations)
    );
    let good = key_holder.upload(&KEYS[0], &CONTENTS[1]);
    assert!(matches!(good, Ok(Response::Committed(_))), "{good:?}");
}

#[test]
fn each_number_of_a_set_that_is_not_finite_is_refused() {
    let count = numbers(&mut numbered(1)).len();
    assert_eq!(count, 3 * 25 + 2 * 18 + 3 + 12 + 2);
    for (place, value) in
        (0..count).zip([f32::NAN, f32::INFINITY, f32::NEG_INFINITY].iter().cycle())
    {
        let mut set = numbered(1);
        *numbers(&mut set)[place] = *value;
        let bytes = encoded(&set);
        refused(upload_of(&bytes), &bytes, |refusal| {
            matches!(refusal, Refusal::Record(_))
        });
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn a_drive_too_fast_or_of_no_length_is_refused(
        block in proptest::sample::select(&BlockSize::ALL[..]), fast: u64, long: u32, settle_blocks in 0..=MAX_BLOCKS,
    ) {
        let drive = Drive { increment: 1, block, settle_blocks, blocks: 1 };
        prop_assert_eq!(checked(drive), Ok(()));
        let nyquist = 1 << 63;
        let above = Drive { increment: fast | nyquist, ..drive };
        prop_assert_eq!(checked(above), Err(DriveError::Frequency));
        prop_assert_eq!(checked(Drive { increment: 0, ..drive }), Err(DriveError::Frequency));
        let none = Drive { blocks: 0, ..drive };
        prop_assert_eq!(checked(none), Err(DriveError::Blocks { blocks: 0 }));
        let blocks = long.saturating_add(MAX_BLOCKS + 1);
        let endless = Drive { blocks, ..drive };
        prop_assert_eq!(checked(endless), Err(DriveError::Blocks { blocks }));
        let waiting = Drive { settle_blocks: blocks, ..drive };
        prop_assert_eq!(checked(waiting), Err(DriveError::Settle { blocks }));
    }

    #[test]
    fn no_frequency_that_is_none_or_at_nyquist_or_above_has_an_increment(
        rate_hz in proptest::sample::select(&FACTS.rates_hz[..]), above in 0.0..1e9_f64,
    ) {
        let nyquist = f64::from(rate_hz) / 2.0;
        for hz in [nyquist + above, -above, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            prop_assert_eq!(increment(hz, rate_hz), None);
        }
        prop_assert_eq!(increment(above, 0), None);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_length_that_is_not_that_of_the_set_is_refused(length: u16) {
        let bytes = &CONTENTS[1];
        prop_assume!(usize::from(length) != bytes.len());
        let Act::Upload { digest, .. } = upload_of(bytes) else { unreachable!() };
        refused(Act::Upload { length, digest }, bytes, |refusal| match refusal {
            Refusal::Length { length: told, .. } => told == length && (length == 0 || usize::from(length) > MAX_ENCODED),
            Refusal::OutOfOrder { expected } => expected <= length && usize::from(expected) <= bytes.len(),
            _ => false,
        });
    }

    /// The length of a piece is the byte behind the request's number and the offset of one byte.
    #[test]
    fn a_piece_whose_length_lies_does_not_decode(length in 0..=CHUNK, told: u8) {
        let piece = vec![0x5A; length].into_iter().collect();
        let mut out = [0; MAX_FRAME];
        let request = Request::UploadChunk { offset: 3, bytes: piece };
        let encoded = encode_request(&request, 0, &mut out).unwrap();
        let mut payload = frame::decode(&mut out[..encoded - 1]).unwrap().payload.to_vec();
        prop_assume!(length < 128 && usize::from(told) != length);
        payload[2] = told;
        prop_assert_eq!(decode_request(&payload), None);
    }
}
