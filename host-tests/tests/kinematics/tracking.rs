//! Tracking a moving base, sample after sample.

use core::f64::consts::TAU;

use hexsense_core::kinematics::forward::{ForwardError, Options, Solver};
use hexsense_core::kinematics::{Angles, Convention, Geometry, Pose, Tracker, inverse};
use nalgebra::Vector3;

use crate::bases::{misfit, presets};

/// All six degrees of freedom at `hertz`, out of step, `metres` and `radians` to either side.
fn swinging(geometry: &Geometry<f64>, hertz: f64, metres: f64, radians: f64, t: f64) -> Pose<f64> {
    let at = |phase: f64| (TAU * hertz * t + phase).sin();
    let position = Vector3::new(
        metres * at(0.0),
        geometry.home_height_m() + metres * at(1.0),
        metres * at(2.0),
    );
    let angles = Angles {
        roll: radians * at(3.0),
        yaw: radians * at(4.0),
        pitch: radians * at(5.0),
    };
    Convention::Gost.pose(position, angles)
}

#[test]
fn two_iterations_follow_a_moving_base_at_one_kilohertz() {
    for (name, geometry) in presets() {
        let solver = Solver::new(&geometry, Options::default());
        let mut last = swinging(&geometry, 1.0, 0.1, 0.1, 0.0);
        for sample in 1..3000 {
            let pose = swinging(&geometry, 1.0, 0.1, 0.1, f64::from(sample) * 1e-3);
            let lengths = inverse(&geometry, &pose);
            let solution = solver.track(&lengths, &last).unwrap();
            assert!(solution.iterations <= 2, "{name}: {solution:?}");
            assert!(misfit(&geometry, &solution.pose, &lengths) <= 1e-10);
            let (distance, angle) = solution.pose.distance(&pose);
            assert!(
                distance < 1e-9 && angle < 1e-9,
                "{name}: {distance} {angle}"
            );
            last = solution.pose;
        }
    }
}

#[test]
fn a_jump_is_told_from_a_movement() {
    for (name, geometry) in presets() {
        let solver = Solver::new(&geometry, Options::default());
        let home = geometry.home();
        let moved = |x: f64, yaw: f64| {
            let position = home.position + Vector3::new(x, 0.0, 0.0);
            Convention::Gost.pose(
                position,
                Angles {
                    roll: 0.0,
                    pitch: 0.0,
                    yaw,
                },
            )
        };
        let track = |pose: Pose<f64>| solver.track(&inverse(&geometry, &pose), &home);
        assert!(track(moved(0.049, 0.049)).is_ok(), "{name}");
        for (x, yaw) in [(0.051, 0.0), (0.0, 0.0505)] {
            let error = track(moved(x, yaw)).unwrap_err();
            let ForwardError::Jump {
                distance_m,
                angle_rad,
                limit_m,
                limit_rad,
            } = error
            else {
                panic!("{name}: {error}");
            };
            assert!(
                (distance_m - x).abs() < 1e-9 && (angle_rad - yaw).abs() < 1e-7,
                "{name}: {error}"
            );
            assert_eq!([limit_m, limit_rad], [0.05, 0.05]);
        }
    }
}

/// A gap in the record, a bad sample, and lengths that no pose has: the tracker finds the next pose all the same.
#[test]
fn a_tracker_goes_on_after_gaps_and_bad_samples_on_the_branch_of_home() {
    for (name, geometry) in presets() {
        let solver = Solver::new(&geometry, Options::default());
        let mut tracker = Tracker::new(&solver);
        for sample in 0..2000 {
            let gap = if sample > 1000 { 0.3 } else { 0.0 };
            let pose = swinging(&geometry, 1.0, 0.1, 0.1, f64::from(sample) * 1e-3 + gap);
            let mut lengths = inverse(&geometry, &pose);
            if sample == 500 {
                lengths[2] = f64::NAN;
                let error = tracker.next(&lengths).unwrap_err();
                assert!(matches!(error, ForwardError::NotFinite { jack: 3, .. }));
                continue;
            }
            let solution = tracker.next(&lengths).unwrap();
            let (distance, angle) = solution.pose.distance(&pose);
            assert!(distance < 1e-9 && angle < 1e-9, "{name}: {sample}");
            let fresh = [0, 501, 1001].contains(&sample);
            assert!(
                fresh || solution.iterations <= 2,
                "{name} {sample}: {solution:?}"
            );
        }
    }
}
