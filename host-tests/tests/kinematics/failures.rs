//! Lengths without a pose are told apart, and no wrong pose is returned.

use hexsense_core::kinematics::forward::{ForwardError, Options, Solver};
use hexsense_core::kinematics::{Pose, inverse, jacobian};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::bases::{dietmaier, disturbed, misfit, preset, presets, signed};

const IL: &str = "il-96-300";

fn solver(name: &str) -> Solver<f64> {
    Solver::new(&preset(name), Options::default())
}

#[test]
fn lengths_that_are_not_numbers_are_named() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let lengths = [3.2, 3.2, bad, 3.2, 3.2, 3.2];
        let error = solver(IL).solve(&lengths).unwrap_err();
        assert!(
            matches!(error, ForwardError::NotFinite { jack: 3, .. }),
            "{error}"
        );
    }
}

#[test]
fn a_start_that_is_not_a_number_is_refused() {
    let solver = solver(IL);
    let mut start = solver.geometry().home();
    start.position.z = f64::NAN;
    for result in [
        solver.track(&[3.2; 6], &start),
        solver.solve_near(&[3.2; 6], &start),
    ] {
        assert_eq!(result, Err(ForwardError::StartNotFinite));
    }
}

#[test]
fn lengths_outside_the_stroke_are_named_with_their_limits() {
    let error = solver(IL)
        .solve(&[3.2, 3.2, 3.2, 3.2, 3.2, 3.951])
        .unwrap_err();
    let ForwardError::OutsideStroke {
        jack,
        length_m,
        length_min_m,
        length_max_m,
    } = error
    else {
        panic!("{error}")
    };
    assert_eq!(
        (jack, length_m, length_min_m, length_max_m),
        (6, 3.951, 2.45, 3.95)
    );
    let patient = Options {
        stroke_margin_m: 0.002,
        ..Options::default()
    };
    assert!(
        Solver::new(&preset(IL), patient)
            .solve(&[3.2, 3.2, 3.2, 3.2, 3.2, 3.951])
            .is_ok()
    );
}

/// Two neighbours on one upper hinge, one long and one short, next to a pair the other way round: the lengths are
/// inside the stroke, and no pose has them.
#[test]
fn lengths_without_a_pose_are_unreachable() {
    let lengths = [
        2.45,
        2.45,
        3.95,
        2.45,
        3.0991859630146434,
        3.442253777458543,
    ];
    let error = solver(IL).solve(&lengths).unwrap_err();
    assert!(
        matches!(error, ForwardError::Unreachable { short_m } if short_m > 0.01 && short_m < 0.5),
        "{error}"
    );
    let home = solver(IL).geometry().home();
    let error = solver(IL).solve_near(&lengths, &home).unwrap_err();
    assert!(matches!(error, ForwardError::Unreachable { .. }), "{error}");
}

/// Every base turned by 90 degrees about Y is singular by its symmetry (K. H. Hunt's singularity of the 6-3 layout).
#[test]
fn hunts_singular_pose_is_called_singular() {
    let solver = solver(IL);
    let mut pose = solver.geometry().home();
    pose.rotation =
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), core::f64::consts::FRAC_PI_2);
    assert!(solver.condition(&pose) > 1e12);
    let lengths = inverse(solver.geometry(), &pose);
    let wide = Options {
        stroke_margin_m: 2.0,
        ..Options::default()
    };
    let wide = Solver::new(solver.geometry(), wide);
    for result in [
        wide.track(&lengths, &pose),
        wide.solve_near(&lengths, &pose),
    ] {
        assert!(
            matches!(result, Err(ForwardError::Singular { .. })),
            "{result:?}"
        );
    }
    // There is no branch from there to anywhere else either.
    let onwards = wide.track(&lengths.map(|length| length + 0.1), &pose);
    assert!(
        matches!(onwards, Err(ForwardError::Singular { .. })),
        "{onwards:?}"
    );
}

#[test]
fn a_limit_on_the_condition_number_is_kept() {
    let geometry = preset(IL);
    let strict = Options {
        max_condition: 2.0,
        ..Options::default()
    };
    let error = Solver::new(&geometry, strict).solve(&[3.2; 6]).unwrap_err();
    let ForwardError::Singular { condition, limit } = error else {
        panic!("{error}")
    };
    assert!((2.0..3.0).contains(&condition) && limit == 2.0, "{error}");
    // The bound is over 3 here and the number itself is not: the number decides.
    let fair = Options {
        max_condition: 3.0,
        ..Options::default()
    };
    let solution = Solver::new(&geometry, fair).solve(&[3.2; 6]).unwrap();
    assert!(solution.condition_bound > 3.0);
}

#[test]
fn too_few_iterations_are_no_convergence() {
    let few = Options {
        max_iterations: 2,
        ..Options::default()
    };
    let solver = Solver::new(&preset(IL), few);
    let error = solver.solve(&[2.6, 3.6, 2.8, 3.4, 3.0, 3.5]).unwrap_err();
    assert!(
        matches!(error, ForwardError::NoConvergence { iterations: 2, short_m } if short_m > 1e-10),
        "{error}"
    );
}

/// Near the ill-conditioned ones of Dietmaier's poses the sign of det J differs from one side to the other. From the
/// wrong side no pose is tracked, and where Newton's method does get across, the error names the branch; as a guess the
/// same start is good enough.
#[test]
fn a_pose_across_a_singularity_is_another_branch() {
    let geometry = dietmaier();
    let solver = Solver::new(
        &geometry,
        Options {
            max_condition: 1e9,
            ..Options::default()
        },
    );
    let row = &crate::bases::rows("dietmaier40_poses.csv")[19];
    let n = crate::bases::numbers(row);
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), -core::f64::consts::FRAC_PI_2);
    let r = Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_row_slice(&n[4..13]));
    let pose = Pose {
        position: turn * Vector3::new(n[1], n[2], n[3]),
        rotation: UnitQuaternion::from_rotation_matrix(&(turn * r * turn.inverse())),
    };
    let lengths = inverse(&geometry, &pose);
    let sign = jacobian(&geometry, &pose).determinant().signum();
    let mut random = ChaCha8Rng::seed_from_u64(20);
    let mut told = 0;
    for _ in 0..5000 {
        let start = disturbed(&pose, 2e-4, 2e-4, &mut random);
        let tracked = solver.track(&lengths, &start);
        if jacobian(&geometry, &start).determinant() * sign < 0.0 {
            assert!(tracked.is_err(), "{tracked:?}");
            told += usize::from(tracked == Err(ForwardError::BranchChanged));
            let (distance, _) = solver
                .solve_near(&lengths, &start)
                .unwrap()
                .pose
                .distance(&pose);
            assert!(distance < 1e-5, "{distance}");
        }
    }
    assert!(told > 0, "no start was told from the branch of the pose");
}

/// Any six lengths inside the stroke, ends included.
#[test]
fn whatever_is_returned_has_the_lengths_and_the_branch_of_home() {
    let mut random = ChaCha8Rng::seed_from_u64(21);
    for (name, geometry) in presets() {
        let solver = Solver::new(&geometry, Options::default());
        let (min, max) = (geometry.length_min_m(), geometry.length_max_m());
        let sign = jacobian(&geometry, &geometry.home()).determinant().signum();
        let mut found = 0;
        for _ in 0..5000 {
            let share = |random: &mut ChaCha8Rng| (0.5 + 0.75 * signed(random)).clamp(0.0, 1.0);
            let lengths = core::array::from_fn(|_| min + (max - min) * share(&mut random));
            match solver.solve(&lengths) {
                Ok(solution) => {
                    found += 1;
                    assert!(
                        misfit(&geometry, &solution.pose, &lengths) <= 1e-10,
                        "{name} {lengths:?}"
                    );
                    assert!(
                        jacobian(&geometry, &solution.pose).determinant() * sign > 0.0,
                        "{name} {lengths:?}"
                    );
                }
                Err(error) => assert!(
                    matches!(error, ForwardError::Unreachable { .. }),
                    "{name} {lengths:?}: {error}"
                ),
            }
        }
        assert!(found > 4000, "{name}: {found}");
    }
}

proptest! {
    #[test]
    fn no_input_panics(lengths: [f64; 6], position: [f64; 3], turn: [f64; 3], near: bool) {
        let solver = Solver::new(&dietmaier(), Options { stroke_margin_m: f64::MAX, ..Options::default() });
        let lengths = if near { lengths.map(|l| 1.0 + l.rem_euclid(1.0)) } else { lengths };
        let start = Pose { position: position.into(), rotation: UnitQuaternion::from_scaled_axis(turn.into()) };
        let results =
            [solver.solve(&lengths), solver.track(&lengths, &start), solver.solve_near(&lengths, &start)];
        for solution in results.into_iter().flatten() {
            prop_assert!(misfit(solver.geometry(), &solution.pose, &lengths) <= 1e-9);
        }
    }
}
