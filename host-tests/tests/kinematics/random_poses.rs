//! Forward kinematics from home finds every pose, no wrong one, and returns true figures with it.

use hexsense_core::kinematics::forward::{Options, Solver};
use hexsense_core::kinematics::jacobian::condition_bound;
use hexsense_core::kinematics::{Geometry, Pose, inverse};
use nalgebra::{UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::bases::{disturbed, joined_to_home, misfit, presets, published, without_stroke};

const POSES: usize = 10_000;

/// The pose is found exactly, and the figures with it are true.
fn assert_found(name: &str, solver: &Solver<f64>, pose: &Pose<f64>) {
    let geometry = solver.geometry();
    let lengths = inverse(geometry, pose);
    let solution = solver
        .solve(&lengths)
        .unwrap_or_else(|error| panic!("{name} {pose:?}: {error}"));
    let residual = misfit(geometry, &solution.pose, &lengths);
    assert!(
        residual <= 1e-10 && solution.residual_m <= 1e-10,
        "{name}: {residual} {solution:?}"
    );
    let (distance, angle) = solution.pose.distance(pose);
    let size = geometry.length_max_m();
    // The possible error from a residual of 1e-10 at such an ill-conditioned pose.
    let allowed = 1e-9 * solution.condition_bound * size.max(1.0);
    assert!(
        distance < allowed && angle < allowed,
        "{name}: {distance} {angle} {solution:?}"
    );
    assert!(solution.iterations <= 12, "{name}: {solution:?}");
}

#[test]
fn every_pose_joined_to_home_inside_the_stroke_is_found_from_home() {
    let mut random = ChaCha8Rng::seed_from_u64(10);
    for (name, geometry) in presets() {
        let solver = Solver::new(&geometry, Options::default());
        let stroke = geometry.length_max_m() - geometry.length_min_m();
        for _ in 0..POSES {
            assert_found(
                name,
                &solver,
                &joined_to_home(&geometry, stroke, 2.0, &mut random),
            );
        }
    }
}

#[test]
fn bases_without_a_stroke_are_solved_up_to_25_degrees_and_a_tenth_of_their_radius() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for (name, geometry) in without_stroke() {
        let solver = Solver::new(&geometry, Options::default());
        let radius = geometry
            .lower()
            .iter()
            .map(Vector3::norm)
            .fold(0.0, f64::max);
        for _ in 0..POSES {
            let pose = disturbed(
                &geometry.home(),
                0.1 * radius,
                25_f64.to_radians(),
                &mut random,
            );
            assert_found(name, &solver, &pose);
        }
    }
}

/// 6-3 (two jacks on each upper hinge) and 3-6 (two on each lower hinge).
#[test]
fn coincident_hinges_work_both_ways_round() {
    let three_six = published("linuxcnc_genhexkins", [5.0, 80.0], Some(20.0));
    assert_eq!(three_six.lower()[1], three_six.lower()[2]);
    let upside_down = Geometry::new(
        *three_six.upper(),
        *three_six.lower(),
        5.0,
        80.0,
        Some(20.0),
    )
    .unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(12);
    for geometry in [three_six, upside_down] {
        let solver = Solver::new(&geometry, Options::default());
        for _ in 0..1000 {
            assert_found(
                "coincident",
                &solver,
                &joined_to_home(&geometry, 5.0, 0.6, &mut random),
            );
        }
    }
}

#[test]
fn the_bound_of_the_condition_number_is_one_and_not_far_off() {
    let mut random = ChaCha8Rng::seed_from_u64(13);
    let within = |geometry: &Geometry<f64>| geometry.lower()[0].norm() * 0.1;
    let real = |(name, geometry)| (name, geometry, 10.0);
    let any = |(name, geometry)| (name, geometry, f64::INFINITY);
    for (name, geometry, factor) in presets()
        .into_iter()
        .map(real)
        .chain(without_stroke().into_iter().map(any))
    {
        let solver = Solver::new(&geometry, Options::default());
        for _ in 0..1000 {
            let pose = joined_to_home(&geometry, within(&geometry), 0.4, &mut random);
            let bound = solver
                .solve(&inverse(&geometry, &pose))
                .unwrap()
                .condition_bound;
            let condition = solver.condition(&pose);
            assert!(
                bound >= condition && bound < factor * condition,
                "{name}: {bound} {condition}"
            );
        }
    }
}

/// With so loose a tolerance one step leads from a distant pose to a worse conditioned one.
#[test]
fn the_bound_belongs_to_the_pose_that_is_returned() {
    let geometry = crate::bases::preset("il-96-300");
    let loose = Options {
        tolerance_m: 0.3,
        stroke_margin_m: 2.0,
        jump_m: 1.0,
        jump_rad: 1.0,
        ..Options::default()
    };
    let solver = Solver::new(&geometry, loose);
    let turned = |yaw: f64| Pose {
        position: geometry.home().position,
        rotation: UnitQuaternion::from_axis_angle(&Vector3::y_axis(), yaw),
    };
    for end in [1.3, 1.4, 1.5] {
        let lengths = inverse(&geometry, &turned(end));
        let solution = solver.track(&lengths, &turned(end - 0.4)).unwrap();
        let exact = condition_bound(&geometry, &solution.pose);
        // An eighth is to spare, and the lengths here are not yet those that scale the bound.
        let ratio = solution.condition_bound / exact;
        assert!((1.0..1.4).contains(&ratio), "{end}: {exact} {solution:?}");
    }
}
