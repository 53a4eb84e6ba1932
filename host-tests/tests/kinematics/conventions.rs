//! The four conventions, each against matrices from other sources.

use std::f64::consts::FRAC_PI_2;

use approx::{assert_abs_diff_eq, assert_abs_diff_ne};
use hexsense_core::kinematics::convention::{from_z_down, from_z_up, to_z_down, to_z_up};
use hexsense_core::kinematics::{Angles, Convention, inverse};
use host_tests::reference::gost;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::bases::{hinges, numbers, preset, rows};

const ALL: [Convention; 4] = [
    Convention::Gost,
    Convention::Zyx,
    Convention::Xyz,
    Convention::ZDown,
];

fn rx(a: f64) -> Matrix3<f64> {
    Matrix3::new(1.0, 0.0, 0.0, 0.0, a.cos(), -a.sin(), 0.0, a.sin(), a.cos())
}

fn ry(a: f64) -> Matrix3<f64> {
    Matrix3::new(a.cos(), 0.0, a.sin(), 0.0, 1.0, 0.0, -a.sin(), 0.0, a.cos())
}

fn rz(a: f64) -> Matrix3<f64> {
    Matrix3::new(a.cos(), -a.sin(), 0.0, a.sin(), a.cos(), 0.0, 0.0, 0.0, 1.0)
}

/// The rotation of a pose in axes with z up.
fn z_up(rotation: &UnitQuaternion<f64>) -> Matrix3<f64> {
    let columns = [Vector3::x(), Vector3::y(), Vector3::z()];
    Matrix3::from_columns(&columns.map(|e| to_z_up(rotation * from_z_up(e))))
}

/// A rotation given with z up, in the frame with Y up.
fn y_up(r: &Matrix3<f64>) -> UnitQuaternion<f64> {
    let columns = [Vector3::x(), Vector3::y(), Vector3::z()];
    let a = Matrix3::from_columns(&columns.map(|e| from_z_up(r * to_z_up(e))));
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(a))
}

const ANGLES: Angles<f64> = Angles {
    roll: 0.3,
    pitch: -0.4,
    yaw: 0.5,
};

/// GOST 20058-80: the matrix written out term by term.
#[test]
fn gost_is_the_matrix_of_the_standard() {
    let standard = gost(ANGLES.roll, ANGLES.yaw, ANGLES.pitch);
    let rotation = Convention::Gost.rotation(ANGLES);
    assert_abs_diff_eq!(
        *rotation.to_rotation_matrix().matrix(),
        standard,
        epsilon = 1e-15
    );
}

#[test]
fn zyx_and_xyz_are_products_of_turns_about_z_up_axes() {
    let Angles { roll, pitch, yaw } = ANGLES;
    let zyx = z_up(&Convention::Zyx.rotation(ANGLES));
    assert_abs_diff_eq!(zyx, rz(yaw) * ry(pitch) * rx(roll), epsilon = 1e-15);
    let xyz = z_up(&Convention::Xyz.rotation(ANGLES));
    assert_abs_diff_eq!(xyz, rx(roll) * ry(pitch) * rz(yaw), epsilon = 1e-15);
}

#[test]
fn z_down_is_a_product_of_turns_about_z_down_axes() {
    let Angles { roll, pitch, yaw } = ANGLES;
    let rotation = Convention::ZDown.rotation(ANGLES);
    let columns = [Vector3::x(), Vector3::y(), Vector3::z()];
    let r = Matrix3::from_columns(&columns.map(|e| to_z_down(rotation * from_z_down(e))));
    assert_abs_diff_eq!(r, rz(yaw) * ry(pitch) * rx(roll), epsilon = 1e-15);
}

/// What every pilot knows: from the seat, x forward, y right, z down.
#[test]
fn z_down_pitches_nose_up_rolls_right_wing_down_and_yaws_nose_right() {
    let turned = |roll, pitch, yaw, axis: Vector3<f64>| {
        Convention::ZDown.rotation(Angles { roll, pitch, yaw }) * axis
    };
    let (forward, up, right) = (Vector3::x(), Vector3::y(), Vector3::z());
    assert_abs_diff_eq!(turned(0.0, FRAC_PI_2, 0.0, forward), up, epsilon = 1e-15);
    assert_abs_diff_eq!(turned(FRAC_PI_2, 0.0, 0.0, right), -up, epsilon = 1e-15);
    assert_abs_diff_eq!(turned(0.0, 0.0, FRAC_PI_2, forward), right, epsilon = 1e-15);
}

/// Dietmaier's published rotation matrices: angles in each convention give the matrix back by that convention's product
/// of turns, and a mixture of two conventions gives another matrix.
#[test]
fn published_rotations_come_back_in_their_own_convention_only() {
    for row in rows("dietmaier40_poses.csv") {
        let r = Matrix3::from_row_slice(&numbers(&row)[4..13]);
        let zyx = Convention::Zyx.angles(&y_up(&r));
        let xyz = Convention::Xyz.angles(&y_up(&r));
        let gost = Convention::Gost.angles(&y_up(&r));
        let by_zyx = |a: Angles<f64>| rz(a.yaw) * ry(a.pitch) * rx(a.roll);
        let by_xyz = |a: Angles<f64>| rx(a.roll) * ry(a.pitch) * rz(a.yaw);
        assert_abs_diff_eq!(by_zyx(zyx), r, epsilon = 1e-9);
        assert_abs_diff_eq!(by_xyz(xyz), r, epsilon = 1e-9);
        assert_abs_diff_eq!(
            by_zyx(Angles {
                pitch: -gost.pitch,
                ..gost
            }),
            r,
            epsilon = 1e-9
        );
        assert_abs_diff_ne!(by_xyz(zyx), r, epsilon = 3e-2);
        assert_abs_diff_ne!(by_zyx(xyz), r, epsilon = 3e-2);
        if gost.pitch.abs() > 0.05 {
            assert_abs_diff_ne!(by_zyx(gost), r, epsilon = 3e-2);
        }
    }
}

#[test]
fn ten_degrees_read_in_the_wrong_convention_are_off_by_three_hundredths() {
    let ten = 10_f64.to_radians();
    let angles = Angles {
        roll: ten,
        pitch: ten,
        yaw: ten,
    };
    for (a, b) in [(0, 1), (1, 2), (2, 0), (3, 0), (3, 1), (3, 2)] {
        let wrong = ALL[a].rotation(angles).angle_to(&ALL[b].rotation(angles));
        assert!(wrong > 3e-2, "{:?} as {:?}: {wrong}", ALL[a], ALL[b]);
    }
}

#[test]
fn positions_turn_with_the_axes() {
    let z_up_point = Vector3::new(1.0, 2.0, 3.0);
    assert_eq!(from_z_up(z_up_point), Vector3::new(1.0, 3.0, -2.0));
    for convention in [Convention::Zyx, Convention::Xyz] {
        let pose = convention.pose(z_up_point, ANGLES);
        assert_eq!(pose.position, Vector3::new(1.0, 3.0, -2.0));
        assert_eq!(convention.coordinates(&pose).0, z_up_point);
    }
    let pose = Convention::ZDown.pose(z_up_point, ANGLES);
    assert_eq!(pose.position, Vector3::new(1.0, -3.0, 2.0));
    assert_eq!(Convention::ZDown.coordinates(&pose).0, z_up_point);
    assert_eq!(
        Convention::Gost.pose(z_up_point, ANGLES).position,
        z_up_point
    );
}

#[test]
fn gimbal_lock_gives_angles_of_the_same_rotation_and_no_roll() {
    for convention in ALL {
        for pitch in [FRAC_PI_2, -FRAC_PI_2] {
            let rotation = convention.rotation(Angles {
                roll: 0.3,
                pitch,
                yaw: 0.7,
            });
            let angles = convention.angles(&rotation);
            assert_eq!(angles.roll, 0.0, "{convention:?}");
            let again = convention.rotation(angles);
            let wrong =
                rotation.to_rotation_matrix().matrix() - again.to_rotation_matrix().matrix();
            assert!(wrong.amax() < 1e-14, "{convention:?} {angles:?}");
        }
    }
}

/// Within a micro-radian of ±90° roll and yaw cannot be told apart, yet the three angles are the rotation.
#[test]
fn angles_beside_gimbal_lock_are_those_of_the_very_rotation() {
    for convention in ALL {
        for off in [0.0, 1e-16, 1e-15, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6] {
            for (roll, side, yaw) in [(0.3, 1.0, 0.7), (-2.0, -1.0, 1.1), (3.0, 1.0, -0.4)] {
                let pitch = side * (FRAC_PI_2 - off);
                let rotation = convention.rotation(Angles { roll, pitch, yaw });
                let again = convention.rotation(convention.angles(&rotation));
                let wrong =
                    rotation.to_rotation_matrix().matrix() - again.to_rotation_matrix().matrix();
                assert!(
                    wrong.amax() < 1e-14,
                    "{convention:?} {off:e}: {:e}",
                    wrong.amax()
                );
            }
        }
    }
}

proptest! {
    #[test]
    fn angles_come_back(roll in -3.1..3.1_f64, pitch in -1.5..1.5_f64, yaw in -3.1..3.1_f64) {
        for convention in ALL {
            let back = convention.angles(&convention.rotation(Angles { roll, pitch, yaw }));
            prop_assert!((back.roll - roll).abs() < 1e-12, "{convention:?} {back:?}");
            prop_assert!((back.pitch - pitch).abs() < 1e-12, "{convention:?} {back:?}");
            prop_assert!((back.yaw - yaw).abs() < 1e-12, "{convention:?} {back:?}");
        }
    }
}

/// The examples that docs/kinematics.md works out: printed lengths against published hinges and matrices written out
/// here, and against the core.
#[test]
fn the_worked_examples_of_the_documentation_are_true() {
    let text = include_str!("../../../docs/kinematics.md");
    let geometry = preset("rexroth_emotion8000");
    let [lower, upper] = hinges("rexroth_emotion8000");
    for (name, convention) in ["gost", "zyx", "xyz", "z-down"].into_iter().zip(ALL) {
        let start = format!("| `{name}` | `");
        let row = text.lines().find(|line| line.starts_with(&start)).unwrap();
        let cells: Vec<Vec<f64>> = row
            .split('`')
            .skip(3)
            .step_by(2)
            .map(|cell| cell.split(',').map(|n| n.parse().unwrap()).collect())
            .collect();
        let &[x, y, z, roll, pitch, yaw] = cells[0].as_slice() else {
            panic!("{row}");
        };
        // The hinges in the axes of the convention: z up is (x, −z, y) of Y up, z down is (x, z, −y).
        let axes = |v: Vector3<f64>| match convention {
            Convention::Gost => v,
            Convention::ZDown => Vector3::new(v.x, v.z, -v.y),
            _ => Vector3::new(v.x, -v.z, v.y),
        };
        let matrix = match convention {
            Convention::Gost => ry(yaw) * rz(pitch) * rx(roll),
            Convention::Zyx | Convention::ZDown => rz(yaw) * ry(pitch) * rx(roll),
            Convention::Xyz => rx(roll) * ry(pitch) * rz(yaw),
        };
        let pose = convention.pose(Vector3::new(x, y, z), Angles { roll, pitch, yaw });
        let core = inverse(&geometry, &pose);
        for jack in 0..6 {
            let d = Vector3::new(x, y, z) + matrix * axes(upper[jack]) - axes(lower[jack]);
            assert_abs_diff_eq!(cells[1][jack], d.norm(), epsilon = 1e-6);
            assert_abs_diff_eq!(cells[1][jack], core[jack], epsilon = 1e-6);
        }
    }
}
