//! Published tables: hinges, poses and lengths from outside of this project.

use approx::assert_abs_diff_eq;
use hexsense_core::kinematics::convention::{from_z_up, to_z_up};
use hexsense_core::kinematics::forward::{Options, Solver};
use hexsense_core::kinematics::{Angles, Convention, Pose, inverse};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::bases::{self, ball, dietmaier, misfit, numbers, published, rows};

const DIETMAIER_LENGTHS: [f64; 6] = [1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071];

struct Posture {
    pose: Pose<f64>,
    condition: f64,
}

/// The forty poses. The table says "any" axes, so its coordinates are turned like those of its hinges: with R by rows
/// in z-up axes, A = C·R·Cᵀ.
fn forty_postures() -> Vec<Posture> {
    let turned = |m: Matrix3<f64>| {
        let columns: [Vector3<f64>; 3] = [Vector3::x(), Vector3::y(), Vector3::z()];
        Matrix3::from_columns(&columns.map(|e| from_z_up(m * to_z_up(e))))
    };
    let posture = |cells: &Vec<String>| {
        let n = numbers(cells);
        let rotation = Rotation3::from_matrix_unchecked(turned(Matrix3::from_row_slice(&n[4..13])));
        let position = from_z_up(Vector3::new(n[1], n[2], n[3]));
        Posture {
            pose: Pose {
                position,
                rotation: UnitQuaternion::from_rotation_matrix(&rotation),
            },
            condition: n[15],
        }
    };
    let postures: Vec<_> = rows("dietmaier40_poses.csv").iter().map(posture).collect();
    assert_eq!(postures.len(), 40);
    postures
}

#[test]
fn all_forty_dietmaier_poses_have_the_published_lengths() {
    for posture in forty_postures() {
        assert!(misfit(&dietmaier(), &posture.pose, &DIETMAIER_LENGTHS) < 1e-8);
    }
}

#[test]
fn condition_numbers_agree_with_those_published_for_dietmaiers_poses() {
    let solver = Solver::new(&dietmaier(), Options::default());
    for posture in forty_postures() {
        let condition = solver.condition(&posture.pose);
        approx::assert_relative_eq!(condition, posture.condition, max_relative = 1e-4);
    }
}

#[test]
fn every_dietmaier_pose_is_found_again_from_within_a_ten_thousandth() {
    let solver = Solver::new(&dietmaier(), Options::default());
    let mut random = ChaCha8Rng::seed_from_u64(40);
    for (number, posture) in (1..).zip(forty_postures()) {
        for _ in 0..100 {
            let guess = Pose {
                position: posture.pose.position + ball(&mut random).normalize() * 1e-4,
                rotation: posture.pose.rotation
                    * UnitQuaternion::from_scaled_axis(ball(&mut random).normalize() * 1e-4),
            };
            let found = solver.solve_near(&DIETMAIER_LENGTHS, &guess).unwrap();
            let (distance, angle) = found.pose.distance(&posture.pose);
            assert!(
                distance < 1e-5 && angle < 1e-5,
                "pose {number}: {distance} {angle}"
            );
            assert!(misfit(&dietmaier(), &found.pose, &DIETMAIER_LENGTHS) < 1e-10);
        }
    }
}

/// The convention is R = Rx·Ry·Rz; the published pose turns about one axis only.
#[test]
fn nasa_lengths_follow_from_the_pose_and_the_pose_from_the_lengths() {
    let geometry = published("nasa_msfc_cdsl", [50.0, 300.0], Some(-111.31));
    for row in rows("nasa_cdsl_legs.csv") {
        let n = numbers(&row);
        let [roll, pitch, yaw] = [n[0], n[1], n[2]].map(f64::to_radians);
        let position = Vector3::new(n[3], n[4], n[5] - 111.31);
        let pose = Convention::Xyz.pose(position, Angles { roll, pitch, yaw });
        let lengths: [f64; 6] = n[6..12].try_into().unwrap();
        // Lengths that a symmetric pose makes equal differ by 0.002 in the table.
        assert!(misfit(&geometry, &pose, &lengths) < 2.5e-3);

        let found = Solver::new(&geometry, Options::default())
            .solve(&inverse(&geometry, &pose))
            .unwrap();
        let (position_found, angles) = Convention::Xyz.coordinates(&found.pose);
        assert_abs_diff_eq!(position_found, position, epsilon = 1e-9);
        assert_abs_diff_eq!(angles.yaw, yaw, epsilon = 1e-11);
    }
}

#[test]
fn mathworks_demo_has_its_published_legs_at_home() {
    let geometry = published("mathworks_demo", [1.0, 6.0], Some(2.0));
    for length in inverse(&geometry, &geometry.home()) {
        assert_abs_diff_eq!(length, 3.153800684, epsilon = 1e-9);
    }
}

#[test]
fn nategh_and_aghelis_legs_are_all_equal_at_their_leg_offset() {
    let offset = 0.6048652;
    let geometry = published("nategh_agheli_nominal", [offset - 0.3, offset + 0.3], None);
    for length in inverse(&geometry, &geometry.home()) {
        assert_abs_diff_eq!(length, offset, epsilon = 1e-6);
    }
}

/// Heights and lengths in the CAD, and the heave in the controller's program that leads from there to neutral.
#[test]
fn rexroth_bases_stand_inside_their_stroke_in_the_cad_and_at_mid_stroke_when_neutral() {
    for (name, height, length, heave, half_stroke) in [
        ("rexroth_emotion8000", 1.618494, 2.686011, 0.9986208, 0.8),
        ("rexroth_emotion1500", 1.084863, 1.4555, 0.4663845, 0.4),
    ] {
        let geometry = bases::preset(name);
        let mut pose = geometry.home();
        pose.position.y = height;
        assert!(misfit(&geometry, &pose, &[length; 6]) < 1e-6, "{name}");
        let stroke = geometry.length_min_m()..geometry.length_max_m();
        assert!(stroke.contains(&length), "{name}");
        // The preset rounds the neutral height to a millimetre.
        assert_abs_diff_eq!(geometry.home_height_m(), height + heave, epsilon = 5e-4);
        let stroke = geometry.length_max_m() - geometry.length_min_m();
        assert_abs_diff_eq!(stroke, 2.0 * half_stroke, epsilon = 1e-9);
    }
}

#[test]
fn rexroth_presets_are_the_published_hinges() {
    for name in ["rexroth_emotion8000", "rexroth_emotion1500"] {
        let [lower, upper] = bases::hinges(name);
        let geometry = bases::preset(name);
        for jack in 0..6 {
            assert_abs_diff_eq!(geometry.lower()[jack], lower[jack], epsilon = 1e-9);
            assert_abs_diff_eq!(geometry.upper()[jack], upper[jack], epsilon = 1e-9);
        }
    }
}
