//! The truth of a sine run, against the motion of the sensor's place differentiated numerically.
//!
//! The core computes ω×(ω×r) and similar terms. This test differentiates the path of the sensor block itself, x = p +
//! A·r, and f = Aᵀ(ẍ + g·up). Rotations are matrices by Rodrigues' formula, nothing else.

use std::f64::consts::TAU;

use hexsense_core::calibration::truth::{Site, coordinates, sine_truth, specific_force_at_rest};
use hexsense_core::excitation::{DegreeOfFreedom, Program, Signal, Sine};
use hexsense_core::harmonics::{Harmonic, Harmonics, Series, Uncertainty};
use hexsense_core::kinematics::{Angles, Convention, Geometry, Pose};
use host_tests::reference::six_three;
use nalgebra::{Complex, Matrix3, Rotation3, UnitQuaternion, Vector3};

const G: f64 = 9.81;
const SITE: Site = Site {
    lever_arm_m: Vector3::new(1.2, -0.8, 0.9),
    gravity_m_s2: G,
};

/// Position and rotation, body to earth, at a phase of the drive.
trait Motion {
    fn position(&self, theta: f64) -> Vector3<f64>;
    fn rotation(&self, theta: f64) -> Matrix3<f64>;
}

/// First and second derivative by differences of fourth order.
fn derivatives<T>(f: impl Fn(f64) -> T, at: f64) -> (T, T)
where
    T: std::ops::Add<Output = T>
        + std::ops::Sub<Output = T>
        + std::ops::Mul<f64, Output = T>
        + Copy,
{
    let h = 0.01;
    let [a, b, c, d, e] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|step| f(at + step * h));
    let first = (a - e + (d - b) * 8.0) * (1.0 / (12.0 * h));
    let second = ((b + d) * 16.0 - (a + e) - c * 30.0) * (1.0 / (12.0 * h * h));
    (first, second)
}

/// The vector v of a matrix whose skew part is [v]×.
fn axial(matrix: &Matrix3<f64>) -> Vector3<f64> {
    let skew = (matrix - matrix.transpose()) * 0.5;
    Vector3::new(skew.m32, skew.m13, skew.m21)
}

/// Specific force, angular acceleration and rate at a phase.
fn felt(motion: &impl Motion, omega: f64, site: &Site, theta: f64) -> [Vector3<f64>; 3] {
    let turn = motion.rotation(theta).transpose();
    let (_, acceleration) = derivatives(
        |at| motion.position(at) + motion.rotation(at) * site.lever_arm_m,
        theta,
    );
    let (first, second) = derivatives(|at| motion.rotation(at), theta);
    [
        turn * (acceleration * omega * omega + Vector3::new(0.0, site.gravity_m_s2, 0.0)),
        axial(&(turn * second)) * omega * omega,
        axial(&(turn * first)) * omega,
    ]
}

/// First and second harmonic of the specific force, first of angular acceleration and rate.
type Amplitudes = [[Complex<f64>; 3]; 4];

fn found(fits: &[Harmonics; 6], omega: f64, site: &Site) -> Amplitudes {
    let truth = sine_truth(fits, omega, site.gravity_m_s2);
    let [first, second] = truth.specific_force(&site.lever_arm_m);
    [
        first,
        second,
        truth.angular_acceleration,
        truth.angular_rate,
    ]
}

fn expected(motion: &impl Motion, omega: f64, site: &Site) -> Amplitudes {
    const POINTS: usize = 360;
    let mut sums = Amplitudes::default();
    for point in 0..POINTS {
        let theta = TAU * point as f64 / POINTS as f64;
        let [force, acceleration, rate] = felt(motion, omega, site, theta);
        let values = [(force, 1.0), (force, 2.0), (acceleration, 1.0), (rate, 1.0)];
        for (sums, (value, k)) in sums.iter_mut().zip(values) {
            let turned = Complex::cis(-k * theta) * (2.0 / POINTS as f64);
            for axis in 0..3 {
                sums[axis] += turned * value[axis];
            }
        }
    }
    sums
}

/// Largest difference of any amplitude, relative to the largest amplitude of its kind.
fn worst(found: &Amplitudes, expected: &Amplitudes) -> f64 {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let pairs = found.iter().zip(expected);
    let relative = pairs.map(|(found, expected)| {
        let size = largest(&mut expected.iter().map(|value| value.norm()));
        largest(&mut (0..3).map(|axis| (found[axis] - expected[axis]).norm())) / size
    });
    largest(&mut relative.into_iter())
}

/// Six coordinates, each with a mean and some harmonics.
struct Fitted([Harmonics; 6]);

impl Fitted {
    fn value(&self, first: usize, theta: f64) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| {
            let fit = &self.0[first + axis];
            let wave = |(k, harmonic): (u32, &Harmonic)| {
                let angle = f64::from(k) * theta;
                harmonic.cosine * angle.cos() + harmonic.sine * angle.sin()
            };
            fit.offset + (1..).zip(&fit.harmonics).map(wave).sum::<f64>()
        })
    }
}

impl Motion for Fitted {
    fn position(&self, theta: f64) -> Vector3<f64> {
        self.value(0, theta)
    }

    fn rotation(&self, theta: f64) -> Matrix3<f64> {
        let turn = self.value(3, theta);
        let (angle, cross) = (turn.norm(), turn.cross_matrix());
        Matrix3::identity()
            + cross * (angle.sin() / angle)
            + cross * cross * ((1.0 - angle.cos()) / (angle * angle))
    }
}

fn harmonics(offset: f64, waves: &[(f64, f64)]) -> Harmonics {
    let mut harmonics = [Harmonic::default(); 5];
    for (harmonic, (cosine, sine)) in harmonics.iter_mut().zip(waves) {
        *harmonic = Harmonic {
            cosine: *cosine,
            sine: *sine,
        };
    }
    Harmonics {
        offset,
        drift: 0.0,
        harmonics,
        residual_rms: 0.0,
        uncertainty: Uncertainty::default(),
    }
}

/// All at once: 14° of turn about three axes out of phase, off the level, with overtones.
fn tumble() -> Fitted {
    Fitted([
        harmonics(0.1, &[(0.2, -0.1), (0.01, 0.0)]),
        harmonics(2.3, &[(0.0, 0.3)]),
        harmonics(-0.2, &[(-0.1, 0.05), (0.0, 0.004), (0.002, 0.0)]),
        harmonics(0.03, &[(0.15, 0.1), (0.0, -0.01)]),
        harmonics(-0.05, &[(-0.05, 0.2)]),
        harmonics(0.08, &[(0.1, -0.12), (0.005, 0.0), (0.0, 0.003)]),
    ])
}

#[test]
fn truth_is_that_of_the_sensors_own_path_differentiated() {
    let omega = TAU * 0.5;
    let motion = tumble();
    let off = worst(
        &found(&motion.0, omega, &SITE),
        &expected(&motion, omega, &SITE),
    );
    assert!(off < 1e-8, "{off:e}");
}

#[test]
fn one_axis_alone_has_the_amplitudes_of_the_book() {
    // A_p = A_u·2πf and A_u·(2πf)² (methods 6 and 7), and gravity turning under the sensor.
    let (omega, amplitude) = (TAU * 0.4, 0.02);
    for axis in 0..3 {
        let mut fits = std::array::from_fn(|_| harmonics(0.0, &[]));
        fits[3 + axis] = harmonics(0.0, &[(0.0, amplitude)]);
        let found = sine_truth(&fits, omega, G);
        // a·cos θ + b·sin θ is a − ib: a sine's rate is a cosine, its acceleration a sine turned over.
        let rate = Complex::new(amplitude * omega, 0.0);
        let acceleration = Complex::new(0.0, amplitude * omega * omega);
        assert!((found.angular_rate[axis] - rate).norm() < 1e-9);
        assert!((found.angular_acceleration[axis] - acceleration).norm() < 1e-9);
        for other in (0..3).filter(|other| *other != axis) {
            assert!(
                found.angular_rate[other].norm() + found.angular_acceleration[other].norm() < 1e-12
            );
        }
        // A roll to the right moves +Y's pull along −Z, pitch up along +X; yaw does not turn gravity.
        let bessel = 2.0 * (amplitude / 2.0 - amplitude.powi(3) / 16.0);
        let sway = Complex::new(0.0, -G * bessel);
        let zero = Complex::new(0.0, 0.0);
        let force = [[zero, zero, -sway], [zero, zero, zero], [sway, zero, zero]][axis];
        for (found, expected) in found.centre_force[0].iter().zip(force) {
            assert!(
                (found - expected).norm() < 1e-6,
                "{axis}: {found} for {expected}"
            );
        }
    }
}

#[test]
fn heave_is_felt_as_force_along_the_vertical() {
    let (omega, amplitude) = (TAU * 0.3, 0.2);
    let mut fits = std::array::from_fn(|_| harmonics(0.0, &[]));
    fits[1] = harmonics(2.0, &[(amplitude, 0.0)]);
    let found = sine_truth(&fits, omega, G);
    let [force, _] = found.specific_force(&SITE.lever_arm_m);
    assert!((force[1] - Complex::new(-amplitude * omega * omega, 0.0)).norm() < 1e-12);
    assert!(found.angular_rate.iter().all(|rate| rate.norm() == 0.0));
}

#[test]
fn the_whole_way_from_a_program_through_poses_and_fits_is_right() {
    let (rate_hz, frequency_hz) = (200.0, 0.5);
    let sine = |amplitude, phase_rad| {
        let steady = Sine::of_periods(amplitude, frequency_hz, 2, 3);
        Signal::Sine(Sine {
            phase_rad,
            ..steady
        })
    };
    use DegreeOfFreedom::{Heave, Pitch, Roll, Surge, Yaw};
    let program = Program {
        signals: [
            (Roll, sine(0.15, 0.0)),
            (Yaw, sine(0.1, 1.0)),
            (Pitch, sine(0.12, -2.0)),
            (Heave, sine(0.1, 0.4)),
            (Surge, sine(0.2, 2.2)),
        ]
        .into_iter()
        .collect(),
    };
    let geometry = six_three();
    let start_s = 3.0 / frequency_hz;
    let mut series: [Vec<f64>; 6] = Default::default();
    for n in 0..(3.0 * rate_hz / frequency_hz) as usize {
        let pose = program.pose(&geometry, start_s + n as f64 / rate_hz);
        let values = coordinates(&pose);
        series
            .iter_mut()
            .zip(values)
            .for_each(|(series, value)| series.push(value));
    }
    let cycles = frequency_hz / rate_hz;
    let fits = series.map(|values| Series::fit(TAU * cycles, &values).unwrap());

    struct Driven<'a>(&'a Program, &'a Geometry<f64>, f64, f64);
    impl Motion for Driven<'_> {
        fn position(&self, theta: f64) -> Vector3<f64> {
            self.0.pose(self.1, self.2 + theta / self.3).position
        }
        fn rotation(&self, theta: f64) -> Matrix3<f64> {
            let [_, _, _, roll, yaw, pitch] = self.0.displacement(self.2 + theta / self.3);
            let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle).into_inner();
            about(Vector3::y_axis(), yaw)
                * about(Vector3::z_axis(), pitch)
                * about(Vector3::x_axis(), roll)
        }
    }
    let omega = TAU * frequency_hz;
    // One period after the start, where differences stay inside the steady part.
    let motion = Driven(&program, &geometry, start_s + 1.0 / frequency_hz, omega);
    let off = worst(
        &found(&fits, omega, &SITE),
        &expected(&motion, omega, &SITE),
    );
    assert!(off < 1e-8, "{off:e}");
}

#[test]
fn gravity_on_a_hold_is_projected_as_the_book_says() {
    for (roll, yaw, pitch) in [
        (0.0, 0.0, 0.0),
        (0.3, 0.0, 0.0),
        (0.0, 0.7, -0.25),
        (-0.2, 1.0, 0.35),
    ] {
        let rotation: UnitQuaternion<f64> = Convention::Gost.rotation(Angles { roll, pitch, yaw });
        let force = specific_force_at_rest(&rotation, &SITE);
        // ax = g sinϑ, ay = g cosϑ cosγ, az = −g cosϑ sinγ
        let expected = Vector3::new(
            G * pitch.sin(),
            G * pitch.cos() * roll.cos(),
            -G * pitch.cos() * roll.sin(),
        );
        assert!((force - expected).norm() < 1e-12, "{force} for {expected}");
    }
}

#[test]
fn coordinates_are_position_and_rotation_vector() {
    let turn = Vector3::new(0.1, -0.2, 0.3);
    let pose = Pose {
        position: Vector3::new(1.0, 2.0, 3.0),
        rotation: UnitQuaternion::from_scaled_axis(turn),
    };
    let found = coordinates(&pose);
    for (found, expected) in found.into_iter().zip([1.0, 2.0, 3.0, 0.1, -0.2, 0.3]) {
        assert!((found - expected).abs() < 1e-12);
    }
}
