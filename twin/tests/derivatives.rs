//! Velocities and accelerations against differences of the pose.

mod support;

use support::{X, Y, Z, an74, close, close3, pass};
use twin::Bench;
use twin::algebra::{Rotation, Vec3};
use twin::jack::JackMotion;
use twin::mechanism::{Mechanism, Pose};
use twin::motion::Motion;
use twin::vibration::Vibration;

/// Derivative of a vector from values two steps around (five points).
fn slope(values: [Vec3; 5], h: f64) -> Vec3 {
    ((values[3] - values[1]) * 8.0 - (values[4] - values[0])) * (1.0 / (12.0 * h))
}

/// Angular velocity from five attitudes: ω = ½ Σ a × a' over the three body axes a in the earth frame.
fn turning(attitudes: [Rotation; 5], h: f64) -> Vec3 {
    [X, Y, Z].into_iter().fold(Vec3::ZERO, |sum, axis| {
        let moved = attitudes.map(|attitude| attitude.to_earth(axis));
        sum + moved[2].cross(slope(moved, h)) * 0.5
    })
}

/// Displacement, speed and acceleration of smooth, unlike jacks.
fn smooth_jacks(mechanism: &Mechanism, home: &Pose, t: f64) -> [[f64; 6]; 3] {
    let rest = mechanism.lengths(home);
    let wave = |k: usize| (0.05 + 0.02 * k as f64, 2.0 + 0.7 * k as f64, 0.9 * k as f64);
    let derivative = |order: i32| -> [f64; 6] {
        std::array::from_fn(|k| {
            let (amplitude, omega, phase) = wave(k);
            let quarter = f64::from(order) * std::f64::consts::FRAC_PI_2;
            amplitude * omega.powi(order) * (omega * t + phase + quarter).sin()
        })
    };
    let displacement = derivative(0);
    [
        std::array::from_fn(|k| rest[k] + displacement[k]),
        derivative(1),
        derivative(2),
    ]
}

#[test]
fn velocity_and_acceleration_are_the_derivatives_of_the_pose() {
    let geometry = an74();
    let mechanism = &geometry.nominal;
    let at = |t: f64| {
        let [lengths, speeds, accelerations] = smooth_jacks(mechanism, &geometry.home, t);
        let pose = mechanism.solve_pose(&lengths, geometry.home).unwrap();
        let linearised = mechanism.linearised(&pose).unwrap();
        let velocity = linearised.velocity(&speeds);
        (
            pose,
            velocity,
            linearised.acceleration(&velocity, &speeds, &accelerations),
        )
    };
    let h = 1e-3;
    for t in [0.3, 1.1, 1.9, 2.7] {
        let around = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|n| at(t + n * h));
        let (_, velocity, acceleration) = around[2];
        assert!(acceleration.angular.norm() > 0.1 && velocity.angular.norm() > 0.05);
        let position = around.map(|(pose, ..)| pose.position_m);
        close3(velocity.linear, slope(position, h).0, 1e-8, "p'");
        let attitude = around.map(|(pose, ..)| pose.attitude);
        close3(velocity.angular, turning(attitude, h).0, 1e-8, "ω");
        let linear = around.map(|(_, velocity, _)| velocity.linear);
        close3(acceleration.linear, slope(linear, h).0, 1e-8, "p''");
        let angular = around.map(|(_, velocity, _)| velocity.angular);
        close3(acceleration.angular, slope(angular, h).0, 1e-8, "ω'");
    }
}

#[test]
fn vibration_is_its_own_derivative_while_it_swells() {
    let geometry = an74();
    let mechanism = &geometry.nominal;
    let mut vibration = Vibration::draw(1, mechanism, &geometry.home, X);
    let swelling: Vec<JackMotion> = (1..400)
        .map(|n| {
            vibration.advance(&[0.1; 6], 1e-3);
            vibration.added_to(&JackMotion::default(), f64::from(n) * 1e-3)
        })
        .collect();
    let jack = |n: usize, of: fn(&JackMotion) -> &[f64; 6]| of(&swelling[n])[0];
    let slope = |n: usize, of: fn(&JackMotion) -> &[f64; 6]| {
        (8.0 * (jack(n + 1, of) - jack(n - 1, of)) - (jack(n + 2, of) - jack(n - 2, of))) / 0.012
    };
    let largest = swelling
        .iter()
        .fold(0.0, |max: f64, m| max.max(m.acceleration_m_s2[0].abs()));
    assert!(largest > 0.02);
    for n in 2..390 {
        let (speed, acceleration) = (jack(n, |m| &m.speed_m_s), jack(n, |m| &m.acceleration_m_s2));
        close(slope(n, |m| &m.displacement_m), speed, 1e-6, "speed");
        close(
            slope(n, |m| &m.speed_m_s),
            acceleration,
            2e-4,
            "acceleration",
        );
    }
}

/// Root of the mean square over a run of the difference between a value and the slope of another.
fn mismatch(
    run: &[Motion],
    of: impl Fn(&Motion) -> Vec3,
    is: impl Fn(&Motion) -> Vec3,
) -> (f64, f64) {
    let (mut wrong, mut size) = (0.0, 0.0);
    for five in run.windows(5) {
        let numeric = slope(std::array::from_fn(|n| of(&five[n])), twin::bench::STEP_S);
        wrong += (numeric - is(&five[2])).norm().powi(2);
        size += is(&five[2]).norm().powi(2);
    }
    let count = run.len() as f64;
    ((wrong / count).sqrt(), (size / count).sqrt())
}

#[test]
fn the_running_bench_differentiates_itself_vibration_and_friction_included() {
    let geometry = an74();
    let mut bench = Bench::with_geometry(3, &geometry).unwrap();
    bench.run("six", support::six_axes(&geometry, 4.0)).unwrap();
    let run = pass(&mut bench, 18.0);
    let (wrong, size) = mismatch(&run, |m| m.pose.position_m, |m| m.velocity.linear);
    assert!(size > 0.02 && wrong < 1e-6, "p': {wrong} of {size}");
    let (wrong, size) = mismatch(&run, |m| m.velocity.linear, |m| m.acceleration.linear);
    assert!(size > 0.1 && wrong < 1e-3, "p'': {wrong} of {size}");
    let (wrong, size) = mismatch(&run, |m| m.velocity.angular, |m| m.acceleration.angular);
    assert!(size > 0.1 && wrong < 1e-3, "ω': {wrong} of {size}");
}
