//! The mechanism against published numbers.

mod support;

use support::{X, Y, Z, close, published};
use twin::algebra::{Rotation, Vec3};
use twin::geometry::Geometry;
use twin::mechanism::{CLOSURE_M, Pose, Twist};

/// One of the forty poses: position, rotation matrix by rows, condition number of the Jacobian.
type Posture = ([f64; 3], [[f64; 3]; 3], f64);

const DIETMAIER_LEGS: [f64; 6] = [1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071];

fn dietmaier() -> Vec<Posture> {
    let text = include_str!("data/dietmaier40_poses.csv");
    let rows = text.lines().skip(1).map(|line| {
        let v: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let matrix = std::array::from_fn(|i| [v[4 + 3 * i], v[5 + 3 * i], v[6 + 3 * i]]);
        ([v[1], v[2], v[3]], matrix, v[15])
    });
    rows.collect()
}

/// The rotation with this matrix: axis and angle from its skew part and trace.
fn rotation(m: &[[f64; 3]; 3]) -> Rotation {
    let skew = Vec3([m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]]);
    let angle = skew.norm().atan2(m[0][0] + m[1][1] + m[2][2] - 1.0);
    Rotation::about(skew * (1.0 / skew.norm()), angle)
}

#[test]
fn lengths_of_the_forty_dietmaier_postures_are_the_published_ones() {
    let mechanism = published("dietmaier40");
    let postures = dietmaier();
    assert_eq!(postures.len(), 40);
    for (position, matrix, _) in postures {
        let pose = Pose {
            position_m: Vec3(position),
            attitude: rotation(&matrix),
        };
        for (got, want) in mechanism.lengths(&pose).into_iter().zip(DIETMAIER_LEGS) {
            close(got, want, 2e-6, "leg");
        }
    }
}

#[test]
fn newton_returns_to_each_well_conditioned_dietmaier_posture() {
    let mechanism = published("dietmaier40");
    let nudge = Twist {
        linear: Vec3([0.004, -0.003, 0.005]),
        angular: Vec3([-0.004, 0.005, 0.003]),
    };
    let mut tried = 0;
    for (position, matrix, condition) in dietmaier() {
        if condition > 100.0 {
            continue;
        }
        let posture = Pose {
            position_m: Vec3(position),
            attitude: rotation(&matrix),
        };
        let found = mechanism
            .solve_pose(&DIETMAIER_LEGS, posture.moved(nudge))
            .unwrap();
        for (got, want) in mechanism.lengths(&found).into_iter().zip(DIETMAIER_LEGS) {
            close(got, want, CLOSURE_M, "closure");
        }
        let off = (found.position_m - posture.position_m).norm();
        close(off, 0.0, 1e-6 * condition, "position");
        tried += 1;
    }
    assert!(tried >= 10, "only {tried} postures are well conditioned");
}

#[test]
fn nasa_cdsl_lengths_are_the_published_ones() {
    let text = include_str!("data/nasa_cdsl_legs.csv");
    let row: Vec<f64> = text
        .lines()
        .nth(1)
        .unwrap()
        .split(',')
        .map(|x| x.parse().unwrap())
        .collect();
    let about = |axis, degrees: f64| Rotation::about(axis, degrees.to_radians());
    let pose = Pose {
        position_m: Vec3([row[3], row[4], row[5] - 111.31]),
        attitude: about(X, row[0])
            .after(about(Y, row[1]))
            .after(about(Z, row[2])),
    };
    let lengths = published("nasa_msfc_cdsl").lengths(&pose);
    for (got, want) in lengths.into_iter().zip(&row[6..]) {
        close(got, *want, 0.005, "leg");
    }
}

#[test]
fn home_lengths_of_published_platforms_are_the_published_ones() {
    for (preset, height, length) in [
        ("rexroth_emotion8000", 1618.494, 2686.011),
        ("rexroth_emotion1500", 1084.863, 1455.500),
        ("mathworks_demo", 2.0, 3.153800684),
    ] {
        let pose = Pose {
            position_m: Vec3([0.0, 0.0, height]),
            attitude: Rotation::LEVEL,
        };
        for got in published(preset).lengths(&pose) {
            close(got / length, 1.0, 5e-7, preset);
        }
    }
}

#[test]
fn presets_turned_from_z_up_have_the_lengths_of_the_published_hinges() {
    for preset in ["rexroth_emotion8000", "rexroth_emotion1500"] {
        let source = published(preset);
        let ours = Geometry::load(preset).unwrap().nominal;
        // One motion in both frames: X forward; Y up is z up; Z right is −y.
        let z_up = Pose {
            position_m: Vec3([120.0, -70.0, 1900.0]),
            attitude: Rotation::about(Vec3([0.0, 1.0, 0.0]), 0.2)
                .after(Rotation::about(Vec3([0.0, 0.0, 1.0]), 0.3)),
        };
        let y_up = Pose {
            position_m: Vec3([0.120, 1.900, 0.070]),
            attitude: Rotation::about(Vec3([0.0, 0.0, -1.0]), 0.2)
                .after(Rotation::about(Vec3([0.0, 1.0, 0.0]), 0.3)),
        };
        for (mm, m) in source.lengths(&z_up).into_iter().zip(ours.lengths(&y_up)) {
            close(m, 1e-3 * mm, 1e-8, preset);
        }
    }
}

#[test]
fn coincident_hinges_are_solved() {
    let mechanism = published("linuxcnc_genhexkins");
    let pose = Pose {
        position_m: Vec3([1.0, -2.0, 20.0]),
        attitude: Rotation::about(X, 0.1).after(Rotation::about(Y, -0.15)),
    };
    let start = Pose {
        position_m: Vec3([0.0, 0.0, 20.0]),
        attitude: Rotation::LEVEL,
    };
    let found = mechanism
        .solve_pose(&mechanism.lengths(&pose), start)
        .unwrap();
    close(
        (found.position_m - pose.position_m).norm(),
        0.0,
        1e-9,
        "position",
    );
}

#[test]
fn impossible_lengths_and_singular_poses_are_errors() {
    let geometry = support::an74();
    let impossible = [0.3, 3.0, 0.3, 3.0, 0.3, 3.0];
    assert!(
        geometry
            .nominal
            .solve_pose(&impossible, geometry.home)
            .is_err()
    );
    assert!(
        geometry
            .nominal
            .solve_pose(&[f64::NAN; 6], geometry.home)
            .is_err()
    );
    let flat = Pose {
        position_m: Vec3::ZERO,
        attitude: Rotation::LEVEL,
    };
    assert!(geometry.nominal.linearised(&flat).is_err());
}
