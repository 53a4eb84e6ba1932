//! Jacobian, twist, acceleration and body rates against automatic and numerical differentiation.

use approx::assert_abs_diff_eq;
use hexsense_core::kinematics::rates::{
    Acceleration, SingularPose, Twist, acceleration, angle_rates, body_rates, jack_accelerations,
    jack_speeds, twist,
};
use hexsense_core::kinematics::{Angles, Convention, Geometry, Pose, inverse, jacobian};
use nalgebra::{Matrix3, Matrix6, Vector3};
use num_dual::{Dual64, DualNum};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::bases::{ball, dietmaier, presets, signed};

/// Length of jack `k` at (x, y, z, roll, yaw, pitch) in `gost`, written out for a number that differentiates itself.
fn dual_length(geometry: &Geometry<f64>, k: usize, q: [Dual64; 6]) -> Dual64 {
    let (sg, cg) = q[3].sin_cos();
    let (sp, cp) = q[4].sin_cos();
    let (st, ct) = q[5].sin_cos();
    let rotation = [
        [cp * ct, sp * sg - cp * st * cg, sp * cg + cp * st * sg],
        [st, ct * cg, -ct * sg],
        [-sp * ct, cp * sg + sp * st * cg, cp * cg - sp * st * sg],
    ];
    let (a, b) = (geometry.lower()[k], geometry.upper()[k]);
    let mut square = Dual64::from(0.0);
    for i in 0..3 {
        let d = q[i] + rotation[i][0] * b.x + rotation[i][1] * b.y + rotation[i][2] * b.z - a[i];
        square += d * d;
    }
    square.sqrt()
}

/// Derivatives of the six lengths with respect to the six coordinates.
fn automatic_jacobian(geometry: &Geometry<f64>, q: [f64; 6]) -> Matrix6<f64> {
    Matrix6::from_fn(|k, column| {
        let seeded = |i: usize| Dual64::new(q[i], if i == column { 1.0 } else { 0.0 });
        dual_length(geometry, k, core::array::from_fn(seeded)).eps
    })
}

fn random_coordinates(geometry: &Geometry<f64>, random: &mut ChaCha8Rng) -> [f64; 6] {
    let shift = ball(random) * 0.5;
    let angle = ball(random);
    [
        shift.x,
        geometry.home_height_m() + shift.y,
        shift.z,
        angle.x,
        angle.y,
        angle.z,
    ]
}

fn pose(q: [f64; 6]) -> Pose<f64> {
    Convention::Gost.pose(
        Vector3::new(q[0], q[1], q[2]),
        Angles {
            roll: q[3],
            yaw: q[4],
            pitch: q[5],
        },
    )
}

/// The automatic derivatives are by angles. One angle at a time turning at 1 rad/s, [`body_rates`] gives the rotation
/// in body axes, and the body's rotation turns it into the earth frame, where J wants it.
#[test]
fn jacobian_and_body_rates_agree_with_automatic_differentiation() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for (name, geometry) in presets().into_iter().chain([("dietmaier40", dietmaier())]) {
        for _ in 0..200 {
            let q = random_coordinates(&geometry, &mut random);
            let pose = pose(q);
            let angles = Angles {
                roll: q[3],
                yaw: q[4],
                pitch: q[5],
            };
            let rate = |roll, yaw, pitch| {
                pose.rotation * body_rates(&angles, &Angles { roll, yaw, pitch })
            };
            let mut chain = Matrix6::identity();
            let turns = Matrix3::from_columns(&[
                rate(1.0, 0.0, 0.0),
                rate(0.0, 1.0, 0.0),
                rate(0.0, 0.0, 1.0),
            ]);
            chain.fixed_view_mut::<3, 3>(3, 3).copy_from(&turns);
            let difference = jacobian(&geometry, &pose) * chain - automatic_jacobian(&geometry, q);
            assert!(difference.amax() < 1e-12, "{name}: {difference}");
        }
    }
}

/// A movement of all six coordinates at once, and its pose at time `t`.
fn moving(geometry: &Geometry<f64>, phases: &[f64; 6], t: f64) -> Pose<f64> {
    let at = |i: usize, amplitude: f64| amplitude * (3.0 * t + phases[i]).sin();
    let y = geometry.home_height_m() + at(1, 0.1);
    pose([
        at(0, 0.2),
        y,
        at(2, 0.2),
        at(3, 0.2),
        at(4, 0.25),
        at(5, 0.2),
    ])
}

const H: f64 = 1e-4;

/// Fourth-order central differences of `f` at 0: first and second derivative.
fn differences<const N: usize>(f: impl Fn(f64) -> [f64; N]) -> ([f64; N], [f64; N]) {
    let [m2, m1, zero, p1, p2] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|n| f(n * H));
    let first = |i: usize| (m2[i] - 8.0 * m1[i] + 8.0 * p1[i] - p2[i]) / (12.0 * H);
    let second =
        |i: usize| (-m2[i] + 16.0 * m1[i] - 30.0 * zero[i] + 16.0 * p1[i] - p2[i]) / (12.0 * H * H);
    (core::array::from_fn(first), core::array::from_fn(second))
}

/// Twist and acceleration of a movement by numerical differentiation of its position and of its rotation against
/// that at 0; a rotation vector's second derivative at 0 is the angular acceleration.
fn differentiated(path: impl Fn(f64) -> Pose<f64>) -> (Twist<f64>, Acceleration<f64>) {
    let start = path(0.0);
    let coordinates = |t: f64| -> [f64; 6] {
        let pose = path(t);
        let turn = (pose.rotation * start.rotation.inverse()).scaled_axis();
        let p = pose.position;
        [p.x, p.y, p.z, turn.x, turn.y, turn.z]
    };
    let (first, second) = differences(coordinates);
    let halves = |v: [f64; 6]| {
        (
            Vector3::new(v[0], v[1], v[2]),
            Vector3::new(v[3], v[4], v[5]),
        )
    };
    let ((linear, angular), (linear2, angular2)) = (halves(first), halves(second));
    (
        Twist { linear, angular },
        Acceleration {
            linear: linear2,
            angular: angular2,
        },
    )
}

#[test]
fn twist_and_acceleration_agree_with_numerical_differentiation() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    for (name, geometry) in presets() {
        for _ in 0..50 {
            let phases: [f64; 6] = core::array::from_fn(|_| 3.0 * signed(&mut random));
            let path = |t: f64| moving(&geometry, &phases, t);
            let (speeds, accelerations) = differences(|t| inverse(&geometry, &path(t)));
            let (true_twist, true_acceleration) = differentiated(path);

            let here = path(0.0);
            let found = twist(&geometry, &here, &speeds).unwrap();
            assert_abs_diff_eq!(found.linear, true_twist.linear, epsilon = 1e-9);
            assert_abs_diff_eq!(found.angular, true_twist.angular, epsilon = 1e-9);
            let found = acceleration(&geometry, &here, &true_twist, &accelerations).unwrap();
            let message = format!("{name}: {found:?} {true_acceleration:?}");
            assert!(
                (found.linear - true_acceleration.linear).amax() < 2e-6,
                "{message}"
            );
            assert!(
                (found.angular - true_acceleration.angular).amax() < 2e-6,
                "{message}"
            );
        }
    }
}

#[test]
fn jack_speeds_and_accelerations_undo_twist_and_acceleration() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for (_, geometry) in presets() {
        let pose = moving(&geometry, &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6], 0.0);
        let velocity = Twist {
            linear: ball(&mut random),
            angular: ball(&mut random),
        };
        let change = Acceleration {
            linear: ball(&mut random),
            angular: ball(&mut random),
        };
        let speeds = jack_speeds(&geometry, &pose, &velocity);
        let found = twist(&geometry, &pose, &speeds).unwrap();
        assert_abs_diff_eq!(found.linear, velocity.linear, epsilon = 1e-12);
        assert_abs_diff_eq!(found.angular, velocity.angular, epsilon = 1e-12);
        let accelerations = jack_accelerations(&geometry, &pose, &velocity, &change);
        let found = acceleration(&geometry, &pose, &velocity, &accelerations).unwrap();
        assert_abs_diff_eq!(found.linear, change.linear, epsilon = 1e-12);
        assert_abs_diff_eq!(found.angular, change.angular, epsilon = 1e-12);
    }
}

#[test]
fn body_rates_agree_with_numerical_differentiation_of_the_rotation() {
    let start = Angles {
        roll: 0.3,
        pitch: -0.5,
        yaw: 0.7,
    };
    let rates = Angles {
        roll: 0.9,
        pitch: 0.6,
        yaw: -1.1,
    };
    let path = |t: f64| {
        let angles = Angles {
            roll: start.roll + rates.roll * t,
            pitch: start.pitch + rates.pitch * t,
            yaw: start.yaw + rates.yaw * t,
        };
        Convention::Gost.pose(Vector3::zeros(), angles)
    };
    let (differentiated, _) = differentiated(path);
    let in_body_axes = path(0.0).rotation.inverse() * differentiated.angular;
    assert_abs_diff_eq!(body_rates(&start, &rates), in_body_axes, epsilon = 1e-9);

    let back = angle_rates(&start, &in_body_axes).unwrap();
    assert_abs_diff_eq!(back.roll, rates.roll, epsilon = 1e-9);
    assert_abs_diff_eq!(back.pitch, rates.pitch, epsilon = 1e-9);
    assert_abs_diff_eq!(back.yaw, rates.yaw, epsilon = 1e-9);
}

#[test]
fn singular_poses_and_gimbal_lock_are_told() {
    let up = Angles {
        roll: 0.0,
        pitch: core::f64::consts::FRAC_PI_2,
        yaw: 0.0,
    };
    assert!(angle_rates(&up, &Vector3::y()).is_none_or(|rates| rates.yaw.abs() > 1e15));
    let geometry = presets()[0].1;
    let mut broken = geometry.home();
    broken.position.x = f64::NAN;
    assert_eq!(twist(&geometry, &broken, &[0.1; 6]), Err(SingularPose));
}
