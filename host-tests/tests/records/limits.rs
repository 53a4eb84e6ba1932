//! Which numbers a set may hold: each limit from both sides, with the nearest numbers that single precision has.

use hexsense_core::channel::Triad;
use hexsense_core::records::{BaseError, CoefficientSet, RecordError};
use host_tests::sets::{encoded, numbered};

/// What is wrong with a changed set.
fn problem(change: impl FnOnce(&mut CoefficientSet)) -> Option<RecordError> {
    let mut set = numbered(1);
    change(&mut set);
    CoefficientSet::decode(&encoded(&set)).err()
}

const LEAST: f32 = f32::from_bits(1);

#[test]
fn an_uncertainty_may_be_zero_and_as_large_as_a_number_can_be_but_not_negative() {
    for (index, triad) in Triad::ALL.into_iter().enumerate() {
        for place in 0..3 {
            let offset = |u: f32| problem(|set| set.triads[index].offset_uncertainty[place] = u);
            let gain = |u: f32| problem(|set| set.triads[index].matrix_uncertainty[2][place] = u);
            for fine in [0.0, -0.0, f32::MAX] {
                assert_eq!((offset(fine), gain(fine)), (None, None));
            }
            let refused = Some(RecordError::NotFinite { triad });
            assert_eq!((offset(-LEAST), gain(-LEAST)), (refused, refused));
        }
    }
}

/// The matrix diag(1, 1, d) has |det| = d and norm √(2 + d²): it is singular up to d = 1e-4·(2 + d²)^1.5 = 2.828 427e-4.
#[test]
fn a_matrix_is_singular_up_to_a_ten_thousandth_of_its_cubed_norm_whatever_its_unit() {
    for (index, triad) in Triad::ALL.into_iter().enumerate() {
        for axis in 0..3 {
            for unit in [1.0, 1e-3, -6e-4, 9.0] {
                let with = |d: f32| {
                    problem(|set| {
                        let matrix = &mut set.triads[index].matrix;
                        *matrix = [[unit, 0.0, 0.0], [0.0, unit, 0.0], [0.0, 0.0, unit]];
                        matrix[axis][axis] = d * unit;
                    })
                };
                assert_eq!(with(2.8285e-4), None, "{unit}");
                assert_eq!(with(2.8284e-4), Some(RecordError::Singular { triad }));
            }
        }
    }
}

#[test]
fn a_transducer_may_have_any_slope_but_none() {
    for place in 0..6 {
        let with = |slope| problem(|set| set.jacks.metres_per_count[place] = slope);
        for fine in [LEAST, -LEAST, f32::MAX] {
            assert_eq!(with(fine), None);
        }
        let jack = place as u8 + 1;
        let refused = RecordError::Base(BaseError::Transducer { jack });
        assert_eq!((with(0.0), with(-0.0)), (Some(refused), Some(refused)));
    }
}

#[test]
fn the_shortest_length_may_be_zero_but_not_negative() {
    let with = |length_m| problem(|set| set.base.length_min_m = length_m);
    assert_eq!((with(0.0), with(-0.0)), (None, None));
    assert_eq!(with(-LEAST), Some(RecordError::Base(BaseError::Stroke)));
}

/// At home jacks 1 and 2 of this base are √7.593 75 m long, the longest, and jacks 3 and 6 √7.519 531 25 m, the shortest.
/// Four units in the last place, 1.3 µm, are allowed for what lengths are computed with.
#[test]
fn home_may_be_on_either_stop_and_not_beyond() {
    let [longest_m, shortest_m] = [7.593_75_f64, 7.519_531_25].map(|square| square.sqrt() as f32);
    let outside = |jack| Some(RecordError::Base(BaseError::Home { jack }));
    let with = |length_m| problem(|set| set.base.length_max_m = length_m);
    assert_eq!(with(longest_m), None);
    assert_eq!(with(longest_m - 2e-6), outside(1));
    let with = |length_m| problem(|set| set.base.length_min_m = length_m);
    assert_eq!(with(shortest_m), None);
    assert_eq!(with(shortest_m + 2e-6), outside(3));
}
