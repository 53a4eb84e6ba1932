//! The board's precision: `f32` against `f64`.

use hexsense_core::kinematics::forward::{Options, Solver};
use hexsense_core::kinematics::{Pose, inverse};
use nalgebra::UnitQuaternion;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::bases::{disturbed, joined_to_home, presets};

/// Greatest error that the board may add: of the position, m; of the rotation, rad.
const ALLOWED: f64 = 5e-7;

fn to_single(pose: &Pose<f64>) -> Pose<f32> {
    Pose {
        position: pose.position.cast(),
        rotation: pose.rotation.cast(),
    }
}

fn to_double(pose: &Pose<f32>) -> Pose<f64> {
    let rotation = UnitQuaternion::new_normalize(pose.rotation.into_inner().cast());
    Pose {
        position: pose.position.cast(),
        rotation,
    }
}

/// Both get the same lengths, rounded to single precision; the double one has the geometry of the file.
#[test]
fn single_precision_costs_less_than_half_a_micrometre() {
    let mut random = ChaCha8Rng::seed_from_u64(30);
    for (name, geometry) in presets() {
        let tolerant = Options {
            stroke_margin_m: 1e-5,
            ..Options::default()
        };
        let exact = Solver::new(&geometry, tolerant);
        let board = Solver::<f32>::new(
            &geometry,
            Options {
                stroke_margin_m: 1e-5,
                ..Options::default()
            },
        );
        let stroke = geometry.length_max_m() - geometry.length_min_m();
        for _ in 0..5000 {
            let pose = joined_to_home(&geometry, stroke, 1.0, &mut random);
            if exact.condition(&pose) > 8.0 {
                continue;
            }
            let lengths = inverse(&geometry, &pose).map(|length| length as f32);
            let truth = exact.solve(&lengths.map(f64::from)).unwrap().pose;
            let last = to_single(&disturbed(&pose, 2e-3, 2e-3, &mut random));
            for solution in [
                board.solve(&lengths).unwrap(),
                board.track(&lengths, &last).unwrap(),
            ] {
                let (distance, angle) = to_double(&solution.pose).distance(&truth);
                assert!(
                    distance < ALLOWED && angle < ALLOWED,
                    "{name}: {distance} {angle} {solution:?}"
                );
            }
        }
    }
}

/// Near home only the rounding of the result is left, half a unit in the last place of the height.
#[test]
fn single_precision_is_exact_near_home() {
    let mut random = ChaCha8Rng::seed_from_u64(32);
    for (name, geometry) in presets() {
        let exact = Solver::new(&geometry, Options::default());
        let board = Solver::<f32>::new(&geometry, Options::default());
        for _ in 0..1000 {
            let pose = disturbed(&geometry.home(), 1e-3, 1e-3, &mut random);
            let lengths = inverse(&geometry, &pose).map(|length| length as f32);
            let truth = exact.solve(&lengths.map(f64::from)).unwrap().pose;
            let (distance, _) = to_double(&board.solve(&lengths).unwrap().pose).distance(&truth);
            let last_place = 2.0 * f64::from(f32::EPSILON);
            assert!(distance < 0.55 * last_place, "{name}: {distance}");
        }
    }
}

#[test]
fn single_precision_stays_true_over_an_hour_of_tracking() {
    let (_, geometry) = presets()[0];
    let board = Solver::<f32>::new(&geometry, Options::default());
    let mut random = ChaCha8Rng::seed_from_u64(31);
    let mut last = geometry.cast::<f32>().home();
    for _ in 0..360_000 {
        let pose = disturbed(&geometry.home(), 0.01, 0.01, &mut random);
        let lengths = inverse(&geometry, &pose).map(|length| length as f32);
        last = board.track(&lengths, &last).unwrap().pose;
        let norm = last.rotation.quaternion().norm();
        assert!((norm - 1.0).abs() < 1e-6, "{norm}");
        assert!(to_double(&last).distance(&pose).0 < 2.0 * ALLOWED);
    }
}
