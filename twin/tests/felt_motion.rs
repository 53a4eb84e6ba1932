//! The sensors on the platform: the sign of gravity, turning, vibration, and where the base stands.

mod support;

use support::{X, Y, Z, an74, close, close3, pass};
use twin::Bench;
use twin::algebra::{Rotation, Vec3};
use twin::geometry::Geometry;
use twin::mechanism::{Pose, Twist};
use twin::motion::{Felt, Place};

const G: f64 = 9.80665;
const STILL: Twist = Twist {
    linear: Vec3::ZERO,
    angular: Vec3::ZERO,
};

fn at(lever_arm_m: Vec3) -> Place {
    Place {
        lever_arm_m,
        gravity_m_s2: G,
    }
}

#[test]
fn at_rest_and_level_specific_force_points_up() {
    let bench = Bench::with_geometry(5, &an74()).unwrap();
    let force = bench.motion().felt.specific_force;
    // Hinges off by half a millimetre tilt the true home a little.
    let gravity = twin::truth::gravity_m_s2(5);
    close(gravity, G, 0.003, "local gravity");
    close3(force, [0.0, gravity, 0.0], 0.02, "force at home");
    close(force.norm(), gravity, 1e-12, "size");
}

#[test]
fn tilted_at_rest_specific_force_is_gravitys_projection() {
    for (roll, yaw, pitch) in [(0.0, 0.0, 0.3), (0.3, 0.0, 0.0), (-0.2, 0.7, 0.25)] {
        let attitude = Rotation::about(Y, yaw)
            .after(Rotation::about(Z, pitch))
            .after(Rotation::about(X, roll));
        let pose = Pose {
            position_m: Vec3::ZERO,
            attitude,
        };
        let felt = Felt::at(&pose, &STILL, &STILL, &at(Vec3([1.0, -1.0, 0.5])));
        let want = [
            G * f64::sin(pitch),
            G * f64::cos(pitch) * f64::cos(roll),
            -G * f64::cos(pitch) * f64::sin(roll),
        ];
        close3(felt.specific_force, want, 1e-12, "tilt");
    }
}

#[test]
fn body_to_earth_is_the_matrix_of_gost_20058() {
    let (roll, yaw, pitch) = (0.4_f64, -0.7_f64, 0.3_f64);
    let ((sg, cg), (sy, cy), (st, ct)) = (roll.sin_cos(), yaw.sin_cos(), pitch.sin_cos());
    let published = [
        [cy * ct, sy * sg - cy * st * cg, sy * cg + cy * st * sg],
        [st, ct * cg, -ct * sg],
        [-sy * ct, cy * sg + sy * st * cg, cy * cg - sy * st * sg],
    ];
    let attitude = Rotation::about(Y, yaw)
        .after(Rotation::about(Z, pitch))
        .after(Rotation::about(X, roll));
    for (column, axis) in [X, Y, Z].into_iter().enumerate() {
        let want = published.map(|row| row[column]);
        close3(attitude.to_earth(axis), want, 1e-14, "column");
    }
}

#[test]
fn rates_are_felt_in_body_axes_as_gost_20058_has_them() {
    let (roll, yaw, pitch) = (0.4_f64, -0.7_f64, 0.3_f64);
    let (roll_rate, yaw_rate, pitch_rate) = (0.5, -0.8, 0.6);
    let (about_y, about_z) = (Rotation::about(Y, yaw), Rotation::about(Z, pitch));
    let pose = Pose {
        position_m: Vec3::ZERO,
        attitude: about_y.after(about_z).after(Rotation::about(X, roll)),
    };
    let turning = Y * yaw_rate
        + about_y.to_earth(Z) * pitch_rate
        + about_y.after(about_z).to_earth(X) * roll_rate;
    let velocity = Twist {
        linear: Vec3::ZERO,
        angular: turning,
    };
    let want = [
        roll_rate + yaw_rate * pitch.sin(),
        yaw_rate * pitch.cos() * roll.cos() + pitch_rate * roll.sin(),
        -yaw_rate * pitch.cos() * roll.sin() + pitch_rate * roll.cos(),
    ];
    let at_origin = Felt::at(&pose, &velocity, &STILL, &at(Vec3::ZERO));
    close3(at_origin.angular_rate, want, 1e-14, "rate");
    // On an arm along the axis of turning there is no centripetal acceleration; across it, it is the square of the
    // rate.
    let arm = Vec3([want[1], -want[0], 0.0]);
    let pull =
        Felt::at(&pose, &velocity, &STILL, &at(arm)).specific_force - at_origin.specific_force;
    close3(pull, (arm * -turning.dot(turning)).0, 1e-14, "pull");
}

/// The quantities felt at `arm` when the jacks of a base move for this motion about the vertical; differences of their
/// speeds give their accelerations.
fn felt_in_yaw(angle: impl Fn(f64) -> f64, rate: impl Fn(f64) -> f64, arm: Vec3) -> Felt {
    let geometry = an74();
    let pose = |t: f64| Pose {
        position_m: geometry.home.position_m,
        attitude: Rotation::about(Y, angle(t)),
    };
    let speeds = |t: f64| {
        let twist = Twist {
            linear: Vec3::ZERO,
            angular: Y * rate(t),
        };
        geometry.nominal.length_rates(&pose(t), &twist)
    };
    let (t, h) = (0.4, 1e-3);
    let accelerations = std::array::from_fn(|k| {
        let at = |n: f64| speeds(t + n * h)[k];
        (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h)
    });
    let linearised = geometry.nominal.linearised(&pose(t)).unwrap();
    let velocity = linearised.velocity(&speeds(t));
    let acceleration = linearised.acceleration(&velocity, &speeds(t), &accelerations);
    Felt::at(&pose(t), &velocity, &acceleration, &at(arm))
}

#[test]
fn steady_turning_is_felt_as_centripetal_acceleration() {
    let (rate, arm) = (0.9, Vec3([1.2, -0.8, 0.7]));
    let felt = felt_in_yaw(|t| rate * t - 0.3, |_| rate, arm);
    let want = [-rate * rate * arm.0[0], G, -rate * rate * arm.0[2]];
    close3(felt.specific_force, want, 1e-9, "centripetal");
    close3(felt.angular_rate, [0.0, rate, 0.0], 1e-12, "rate");
    close3(
        felt.angular_acceleration,
        [0.0; 3],
        1e-9,
        "angular acceleration",
    );
}

#[test]
fn growing_turning_is_felt_as_euler_acceleration() {
    let (epsilon, arm) = (2.0, Vec3([1.2, -0.8, 0.7]));
    let felt = felt_in_yaw(|t| 0.5 * epsilon * t * t - 0.16, |t| epsilon * t, arm);
    let rate = epsilon * 0.4;
    let want = [
        epsilon * arm.0[2] - rate * rate * arm.0[0],
        G,
        -epsilon * arm.0[0] - rate * rate * arm.0[2],
    ];
    close3(felt.specific_force, want, 1e-8, "Euler");
    close3(
        felt.angular_acceleration,
        [0.0, epsilon, 0.0],
        1e-8,
        "angular acceleration",
    );
}

#[test]
fn a_moving_base_vibrates_and_a_still_one_does_not() {
    let geometry = an74();
    let mut bench = Bench::with_geometry(4, &geometry).unwrap();
    let ramp = support::program(&geometry, 9.0, |t| Pose {
        position_m: geometry.home.position_m + Y * (0.1 * (t - 0.5).clamp(0.0, 4.0)),
        attitude: Rotation::LEVEL,
    });
    bench.run("ramp", ramp).unwrap();
    let run = pass(&mut bench, 19.0);
    let moving: Vec<f64> = run
        .iter()
        .filter(|m| (m.velocity.linear.0[1] - 0.1).abs() < 0.01)
        .skip(3000)
        .take(3000)
        .map(|m| m.felt.specific_force.norm())
        .collect();
    let still: Vec<f64> = run[run.len() - 1000..]
        .iter()
        .map(|m| m.felt.specific_force.norm())
        .collect();
    let swing = |values: &[f64]| {
        values
            .iter()
            .fold(0.0, |max: f64, v| max.max((v - G).abs()))
    };
    assert!(moving.len() == 3000);
    // Only the part along gravity changes the size, so at most 0.02 g.
    assert!(
        swing(&moving) > 0.02 && swing(&moving) < 0.25,
        "{}",
        swing(&moving)
    );
    assert!(swing(&still) < 1e-3, "{}", swing(&still));
}

#[test]
fn every_preset_moves_in_six_axes_and_comes_home() {
    for (name, text) in geometries::PRESETS {
        let geometry = Geometry::parse(text).unwrap();
        for seed in [1, 2] {
            let mut bench = Bench::new(seed, text).unwrap();
            let home = bench.motion().pose.position_m;
            bench.run("six", support::six_axes(&geometry, 2.0)).unwrap();
            let run = pass(&mut bench, 16.0);
            let turned = run
                .iter()
                .map(|m| m.felt.angular_acceleration.norm())
                .fold(0.0, f64::max);
            assert!(turned > 0.3, "{name}: {turned} rad/s²");
            let off = (run[run.len() - 1].pose.position_m - home).norm();
            close(off, 0.0, 1e-4, name);
        }
    }
}

#[test]
fn true_hinges_put_home_beside_its_nominal_place() {
    let mut geometry = an74();
    let aside = |geometry: &Geometry, seed: u64| {
        let bench = Bench::with_geometry(seed, geometry).unwrap();
        (bench.motion().pose.position_m - geometry.home.position_m).norm()
    };
    let squares: Vec<f64> = (0..40).map(|seed| aside(&geometry, seed).powi(2)).collect();
    let rms = (squares.iter().sum::<f64>() / 40.0).sqrt();
    // Each jack is off by 0.5 mm · √2; six of them leave a position that is off by about as much.
    assert!((0.0003..0.003).contains(&rms), "{rms} m");
    geometry.hinge_tolerance_m = 0.0;
    assert!(aside(&geometry, 1) < 1e-11);
}

#[test]
fn the_time_of_a_board_begins_with_its_connection() {
    let mut bench = Bench::with_geometry(1, &an74()).unwrap();
    close(
        pass(&mut bench, 1.0).last().unwrap().time_s,
        1.0,
        1e-12,
        "first",
    );
    bench.connect();
    close(
        pass(&mut bench, 0.1).last().unwrap().time_s,
        0.1,
        1e-12,
        "second",
    );
}
