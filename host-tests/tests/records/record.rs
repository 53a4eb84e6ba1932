//! A set is read whole, or refused with the reason.

use hexsense_core::channel::{Ratiometric, Triad};
use hexsense_core::records::{
    BaseError, CoefficientSet, MAX_ENCODED, RecordError, SetId, TriadCoefficients,
};
use hexsense_core::sampling::Calibrator;
use proptest::prelude::*;

use crate::sets::any_set;
use host_tests::sets::{encoded, numbered};

/// CRC-32 (IEEE), bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 * (crc & 1))
        })
    })
}

/// Adds a checksum that matches.
fn sealed(body: &[u8]) -> Vec<u8> {
    [body, &crc32(body).to_le_bytes()].concat()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn every_set_is_read_as_it_was_written(set in any_set()) {
        let bytes = encoded(&set);
        let read = CoefficientSet::decode(&bytes);
        prop_assert_eq!(read.as_ref(), Ok(&set));
        prop_assert_eq!(encoded(&read.unwrap()), bytes);
    }

    #[test]
    fn identity_tells_sets_apart(one in any_set(), other in any_set()) {
        let (one_id, other_id) = (CoefficientSet::id_of(&encoded(&one)), CoefficientSet::id_of(&encoded(&other)));
        prop_assert_eq!(one_id == other_id, one == other);
        prop_assert_eq!(one_id, CoefficientSet::id_of(&encoded(&one.clone())));
    }
}

#[test]
fn identity_is_the_start_of_sha_256_of_the_bytes() {
    // FIPS 180-4's example: SHA-256("abc") = ba7816bf 8f01cfea …
    let id = CoefficientSet::id_of(b"abc");
    assert_eq!(id, SetId([0xBA, 0x78, 0x16, 0xBF, 0x8F, 0x01, 0xCF, 0xEA]));
    assert_eq!(id.to_string(), "ba7816bf8f01cfea");
}

#[test]
fn the_layout_is_the_one_that_boards_have_in_flash() {
    let set = CoefficientSet {
        geometry: heapless::String::try_from("an-74tk-200").unwrap(),
        ..numbered(1)
    };
    let bytes = encoded(&set);
    assert_eq!(
        (
            bytes.len(),
            CoefficientSet::id_of(&bytes).to_string().as_str()
        ),
        (585, "b2e23401c2a29320"),
        "the record's layout drifted: boards in the field would lose their coefficients"
    );
    assert_eq!(sealed(&bytes[..bytes.len() - 4]), bytes);
}

#[test]
fn the_longest_set_fits() {
    let mut set = numbered(u32::MAX);
    set.unix_s = u64::MAX;
    set.geometry = heapless::String::try_from("0123456789abcdef0123456789abcdef").unwrap();
    assert!(encoded(&set).len() <= MAX_ENCODED);
}

#[test]
fn a_buffer_that_is_too_short_is_refused() {
    let set = numbered(1);
    let needed = encoded(&set).len();
    for length in 0..needed {
        assert_eq!(
            set.encode(&mut vec![0; length]),
            Err(RecordError::Length {
                length: length as u32
            })
        );
    }
}

#[test]
fn every_truncation_is_refused() {
    let whole = encoded(&numbered(1));
    for length in 0..whole.len() {
        let cut = &whole[..length];
        let expected = match cut.split_last_chunk::<4>() {
            None => RecordError::Length {
                length: length as u32,
            },
            Some((body, stored)) => RecordError::Checksum {
                stored: u32::from_le_bytes(*stored),
                computed: crc32(body),
            },
        };
        assert_eq!(CoefficientSet::decode(cut), Err(expected));
    }
}

#[test]
fn every_truncation_with_a_checksum_that_fits_is_refused() {
    let whole = encoded(&numbered(1));
    let body = &whole[..whole.len() - 4];
    for length in 0..body.len() {
        assert_eq!(
            CoefficientSet::decode(&sealed(&body[..length])),
            Err(RecordError::Layout)
        );
    }
    assert_eq!(
        CoefficientSet::decode(&sealed(&[body, &[0]].concat())),
        Err(RecordError::Layout)
    );
}

#[test]
fn more_bytes_than_any_set_are_refused() {
    let length = MAX_ENCODED as u32 + 1;
    assert_eq!(
        CoefficientSet::decode(&sealed(&vec![0; MAX_ENCODED - 3])),
        Err(RecordError::Length { length })
    );
}

#[test]
fn every_flipped_bit_is_noticed() {
    let whole = encoded(&numbered(1));
    for bit in 0..8 * whole.len() {
        let mut flipped = whole.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let (body, stored) = flipped.split_last_chunk::<4>().unwrap();
        let damaged = RecordError::Checksum {
            stored: u32::from_le_bytes(*stored),
            computed: crc32(body),
        };
        assert_eq!(CoefficientSet::decode(&flipped), Err(damaged), "bit {bit}");
    }
}

/// The numbers of a triad, one after another, each for a test to spoil.
fn numbers(triad: &mut TriadCoefficients) -> impl Iterator<Item = &mut f32> {
    let uncertainties = triad
        .offset_uncertainty
        .iter_mut()
        .chain(triad.matrix_uncertainty.as_flattened_mut());
    let values = triad
        .offset
        .iter_mut()
        .chain(triad.matrix.as_flattened_mut());
    values.chain([&mut triad.delay_s]).chain(uncertainties)
}

/// Values before uncertainties in [`numbers`].
const VALUES: usize = 13;

#[test]
fn every_number_that_is_not_finite_is_refused() {
    for (index, triad) in Triad::ALL.into_iter().enumerate() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
            for number in 0..VALUES + 12 {
                let mut set = numbered(1);
                let spoilt = numbers(&mut set.triads[index]).nth(number).unwrap();
                *spoilt = if number < VALUES && bad == -1.0 {
                    f32::NAN
                } else {
                    bad
                };
                assert_eq!(
                    CoefficientSet::decode(&encoded(&set)),
                    Err(RecordError::NotFinite { triad }),
                    "number {number} of {triad:?}"
                );
            }
        }
    }
}

#[test]
fn matrices_that_mix_up_axes_are_refused() {
    let singular = [
        [[0.0; 3]; 3],
        [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0; 3]],
        [[1e-3, 2e-3, 3e-3], [2e-3, 4e-3, 6e-3], [0.0, 0.0, 1e-3]],
        [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [1e-3, 1e-3, 1e-9]],
    ];
    for (index, triad) in Triad::ALL.into_iter().enumerate() {
        for matrix in singular {
            let mut set = numbered(1);
            set.triads[index].matrix = matrix;
            assert_eq!(
                CoefficientSet::decode(&encoded(&set)),
                Err(RecordError::Singular { triad })
            );
        }
    }
}

/// A set of which one triad has this offset on each axis, and this gain of each axis alone.
fn plain(index: usize, offset: f32, gain: f32) -> CoefficientSet {
    let mut set = numbered(1);
    let triad = &mut set.triads[index];
    triad.offset = [offset; 3];
    triad.matrix = [[gain, 0.0, 0.0], [0.0, -gain, 0.0], [0.0, 0.0, gain]];
    set
}

#[test]
fn sets_whose_values_can_reach_a_million_are_refused() {
    // The largest count is 65535, and 72088.5 at the largest supply, a tenth above the nominal.
    let bounds = [
        (0.0, 13.871, Some(13.873)),
        (72_088.5, 13.871, Some(13.873)),
        (36_044.25, 27.743, Some(27.745)),
        (-27_911.5, 9.999, Some(10.001)),
        // Offsets are counts, and below a million too.
        (999_999.0, 1e-3, None),
        (-999_999.0, 1e-3, None),
    ];
    for (index, triad) in Triad::ALL.into_iter().enumerate() {
        for (offset, good, bad) in bounds {
            let set = plain(index, offset, good);
            assert_eq!(CoefficientSet::decode(&encoded(&set)), Ok(set));
            if let Some(bad) = bad {
                let set = plain(index, offset, bad);
                let decoded = CoefficientSet::decode(&encoded(&set));
                assert_eq!(decoded, Err(RecordError::Values { triad }), "{offset}");
            }
        }
        for (offset, gain) in [(1e6, 1e-3), (-1e6, 1e-3), (3e38, 1e-38), (1.0, 1e36)] {
            let decoded = CoefficientSet::decode(&encoded(&plain(index, offset, gain)));
            assert_eq!(decoded, Err(RecordError::Values { triad }), "{offset}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5_000))]

    /// At the ends of the counts and of the supply, where the values are the largest, ratiometric or not.
    #[test]
    fn no_set_that_is_taken_makes_a_value_that_is_not_finite_or_reaches_a_million(
        bits in proptest::array::uniform12(proptest::num::f32::NORMAL),
        size in 0..40_i32,
        far in 0..40_i32,
        ratiometric in 0..1_u16 << 15,
    ) {
        let mut set = numbered(1);
        // Numbers of any size, most of them near what is still taken.
        let scaled = |number: f32, exponent: i32| number.signum() * (1.0 + number.abs().fract()) * 10_f32.powi(exponent);
        let triad = &mut set.triads[1];
        triad.offset = std::array::from_fn(|axis| scaled(bits[axis], far - 10 + axis as i32));
        triad.matrix = std::array::from_fn(|row| std::array::from_fn(|column| {
            scaled(bits[3 + 3 * row + column], size - 30)
        }));
        set.ratiometric = Ratiometric::from_bits(ratiometric).unwrap();
        if let Ok(set) = CoefficientSet::decode(&encoded(&set)) {
            let calibrator = Calibrator::new(&set);
            for supply in [0.9, 1.0, 1.1] {
                for corner in 0..8 {
                    let scan = std::array::from_fn(|channel| if corner >> (channel % 3) & 1 == 1 { u16::MAX } else { 0 });
                    let values = calibrator.apply(&scan, supply);
                    prop_assert!(values[3..6].iter().all(|value| value.abs() <= 1e6), "{values:?}");
                }
            }
        }
    }
}

#[test]
fn a_temperature_that_is_none_is_refused() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut set = numbered(1);
        set.temperature_c = bad;
        assert_eq!(
            CoefficientSet::decode(&encoded(&set)),
            Err(RecordError::Temperature)
        );
    }
}

/// Checks that a changed set is refused with this reason.
fn assert_refused(change: impl FnOnce(&mut CoefficientSet), reason: BaseError) {
    let mut set = numbered(1);
    change(&mut set);
    assert_eq!(
        CoefficientSet::decode(&encoded(&set)),
        Err(RecordError::Base(reason))
    );
}

#[test]
fn every_number_of_the_base_that_is_not_finite_is_refused() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let refused = |change: &dyn Fn(&mut CoefficientSet)| {
            assert_refused(change, BaseError::NotFinite);
        };
        for jack in 0..6 {
            for axis in 0..3 {
                refused(&|set| set.base.lower[jack][axis] = bad);
                refused(&|set| set.base.upper[jack][axis] = bad);
            }
        }
        refused(&|set| set.base.length_min_m = bad);
        refused(&|set| set.base.length_max_m = bad);
        refused(&|set| set.base.home_height_m = bad);
        refused(&|set| set.jacks.zero_length_m = bad);
    }
}

#[test]
fn transducers_that_do_not_measure_are_refused_by_name() {
    for jack in 0..6 {
        let reason = BaseError::Transducer {
            jack: jack as u8 + 1,
        };
        assert_refused(|set| set.jacks.zero_counts[jack] = f32::NAN, reason);
        for bad in [0.0, -0.0, f32::NAN, f32::INFINITY] {
            assert_refused(|set| set.jacks.metres_per_count[jack] = bad, reason);
        }
    }
}

#[test]
fn bases_that_cannot_stand_are_refused() {
    assert_refused(|set| set.base.length_min_m = -0.1, BaseError::Stroke);
    assert_refused(
        |set| set.base.length_min_m = set.base.length_max_m,
        BaseError::Stroke,
    );
    assert_refused(
        |set| set.base.home_height_m = 9.0,
        BaseError::Home { jack: 1 },
    );
    assert_refused(|set| set.base.upper = [[0.0; 3]; 6], BaseError::Degenerate);
}

#[test]
fn a_base_with_home_on_its_stops_is_still_one_when_it_is_stored() {
    for preset in hexsense_probe::geometry_file::preset_names() {
        let geometry = hexsense_probe::geometry_file::GeometryFile::load(preset).unwrap();
        let geometry = geometry.geometry;
        let lengths = hexsense_core::kinematics::inverse(&geometry, &geometry.home());
        let (least, greatest) = (
            lengths.into_iter().fold(f64::INFINITY, f64::min),
            lengths.into_iter().fold(0.0, f64::max),
        );
        for (length_min, length_max) in [(least, 9.0), (0.0, greatest)] {
            let on_stops = hexsense_core::kinematics::Geometry::new(
                *geometry.lower(),
                *geometry.upper(),
                length_min,
                length_max,
                Some(geometry.home_height_m()),
            )
            .unwrap();
            let stored = hexsense_core::records::MotionBase::new(&on_stops).geometry();
            assert!(stored.is_ok(), "{preset}: {stored:?}");
        }
    }
}
