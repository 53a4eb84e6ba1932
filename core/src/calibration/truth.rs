//! The true inputs of the sensors, from the pose of the base.
//!
//! With A the rotation body to earth, p the position of O, r the sensor block's place in the body and g gravity,
//! the sensors feel, in body axes,
//!
//! ```text
//! ω = J(φ)·φ̇                                     angular rate
//! ω̇                                              angular acceleration
//! f = Aᵀ(p̈ + g·up) + ω̇×r + ω×(ω×r)              specific force at r
//! ```
//!
//! where φ is the rotation vector of A and J its right Jacobian,
//!
//! ```text
//! J(φ) = 1 − (1 − cos|φ|)/|φ|²·[φ]× + (|φ| − sin|φ|)/|φ|³·[φ]×²
//! ```
//!
//! (e.g. G. S. Chirikjian, Stochastic Models, Information Theory, and Lie Groups 2, 10.6). In a sine run position and
//! rotation vector are fitted by five harmonics each, which differentiate without noise; the products are formed at
//! points of one period and decomposed again.

use core::f64::consts::TAU;

use nalgebra::{Complex, Matrix3, UnitQuaternion, Vector3};

use super::AXES;
use crate::harmonics::{HARMONICS, Harmonics};
use crate::kinematics::Pose;

/// Points of a period at which products are formed: enough for products of three five-harmonic signals.
const POINTS: usize = 64;

/// Where the sensors are, and gravity there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site {
    /// Place of the sensor block from O in body axes, m.
    pub lever_arm_m: Vector3<f64>,
    /// Local gravity, m/s².
    pub gravity_m_s2: f64,
}

/// First and second harmonic of a vector as complex amplitudes a − i·b of a·cos kθ + b·sin kθ.
pub type Overtones = [[Complex<f64>; AXES]; 2];

/// The truth in a sine run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineTruth {
    /// Specific force at O, m/s².
    pub centre_force: Overtones,
    /// What a lever arm of 1 m along each body axis adds to it, 1/s²: ω̇×e + ω×(ω×e).
    pub arm_force: [Overtones; AXES],
    /// First harmonic of the angular acceleration, rad/s².
    pub angular_acceleration: [Complex<f64>; AXES],
    /// First harmonic of the angular rate, rad/s.
    pub angular_rate: [Complex<f64>; AXES],
}

impl SineTruth {
    /// First and second harmonic of the specific force at a place of the body, m from O; m/s².
    #[must_use]
    pub fn specific_force(&self, lever_arm_m: &Vector3<f64>) -> Overtones {
        core::array::from_fn(|k| {
            core::array::from_fn(|axis| {
                let arm = (0..AXES).map(|i| self.arm_force[i][k][axis] * lever_arm_m[i]);
                self.centre_force[k][axis] + arm.sum::<Complex<f64>>()
            })
        })
    }
}

/// Specific force of a body at rest in this pose, m/s² in body axes: +g along Y when level.
#[must_use]
pub fn specific_force_at_rest(rotation: &UnitQuaternion<f64>, site: &Site) -> Vector3<f64> {
    rotation.inverse_transform_vector(&(Vector3::y() * site.gravity_m_s2))
}

/// The six coordinates that a sine run is fitted in: position (m) and rotation vector (rad) of a pose.
#[must_use]
pub fn coordinates(pose: &Pose<f64>) -> [f64; 6] {
    let (p, turn) = (pose.position, pose.rotation.scaled_axis());
    [p.x, p.y, p.z, turn.x, turn.y, turn.z]
}

/// Truth of a sine run from the fits of the six [`coordinates`], driven at `omega` rad/s under `gravity_m_s2`.
#[must_use]
pub fn sine_truth(fits: &[Harmonics; 6], omega: f64, gravity_m_s2: f64) -> SineTruth {
    let circle = Circle::new();
    let (position, turn) = (
        Path::new([&fits[0], &fits[1], &fits[2]]),
        Path::new([&fits[3], &fits[4], &fits[5]]),
    );
    let mut rate = Path::default();
    for point in 0..POINTS {
        let turning = turn.derivative(&circle, point, 1) * omega;
        rate.decompose(
            &circle,
            point,
            &(right_jacobian(&turn.at(&circle, point)) * turning),
        );
    }
    let (mut force, mut acceleration) = (Path::default(), Path::default());
    let mut arms: [Path; AXES] = Default::default();
    for point in 0..POINTS {
        let w = rate.at(&circle, point);
        let w_dot = rate.derivative(&circle, point, 1) * omega;
        let inertial =
            position.derivative(&circle, point, 2) * (omega * omega) + Vector3::y() * gravity_m_s2;
        let attitude = UnitQuaternion::from_scaled_axis(turn.at(&circle, point));
        let felt = attitude.inverse_transform_vector(&inertial);
        force.decompose(&circle, point, &felt);
        acceleration.decompose(&circle, point, &w_dot);
        for (axis, arm) in arms.iter_mut().enumerate() {
            let unit = Vector3::ith(axis, 1.0);
            arm.decompose(
                &circle,
                point,
                &(w_dot.cross(&unit) + w.cross(&w.cross(&unit))),
            );
        }
    }
    let overtones = |path: &Path| [path.harmonic(0), path.harmonic(1)];
    SineTruth {
        centre_force: overtones(&force),
        arm_force: arms.each_ref().map(overtones),
        angular_acceleration: acceleration.harmonic(0),
        angular_rate: rate.harmonic(0),
    }
}

fn right_jacobian(turn: &Vector3<f64>) -> Matrix3<f64> {
    let (cross, angle) = (turn.cross_matrix(), turn.norm());
    // Below 1e-4 rad the series is exact to 1e-17 and the quotients are not.
    let (first, second) = if angle < 1e-4 {
        (
            0.5 - angle * angle / 24.0,
            1.0 / 6.0 - angle * angle / 120.0,
        )
    } else {
        let square = angle * angle;
        (
            (1.0 - libm::cos(angle)) / square,
            (angle - libm::sin(angle)) / (square * angle),
        )
    };
    Matrix3::identity() - cross * first + cross * cross * second
}

/// A periodic path of a vector: mean and five harmonics.
#[derive(Debug, Clone, Default)]
struct Path {
    mean: Vector3<f64>,
    cosine: [Vector3<f64>; HARMONICS],
    sine: [Vector3<f64>; HARMONICS],
}

impl Path {
    fn new(fits: [&Harmonics; 3]) -> Self {
        let gather =
            |part: fn(&Harmonics, usize) -> f64, k| Vector3::from(fits.map(|fit| part(fit, k)));
        Self {
            mean: Vector3::from(fits.map(|fit| fit.offset)),
            cosine: core::array::from_fn(|k| gather(|fit, k| fit.harmonics[k].cosine, k)),
            sine: core::array::from_fn(|k| gather(|fit, k| fit.harmonics[k].sine, k)),
        }
    }

    fn at(&self, circle: &Circle, point: usize) -> Vector3<f64> {
        self.mean + self.derivative(circle, point, 0)
    }

    /// The `order`-th derivative of the harmonics with respect to the phase θ, at a point of the circle.
    fn derivative(&self, circle: &Circle, point: usize, order: usize) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for k in 0..HARMONICS {
            let factor = (k + 1) as f64;
            let (sine, cosine) = circle.sincos((k + 1) * point + order * POINTS / 4);
            let size = (0..order).fold(1.0, |size, _| size * factor);
            sum += (self.cosine[k] * cosine + self.sine[k] * sine) * size;
        }
        sum
    }

    /// Adds the value at a point to the decomposition of a vector known at all points.
    fn decompose(&mut self, circle: &Circle, point: usize, value: &Vector3<f64>) {
        const SHARE: f64 = 1.0 / POINTS as f64;
        self.mean += value * SHARE;
        for k in 0..HARMONICS {
            let (sine, cosine) = circle.sincos((k + 1) * point);
            self.cosine[k] += value * (2.0 * cosine * SHARE);
            self.sine[k] += value * (2.0 * sine * SHARE);
        }
    }

    fn harmonic(&self, k: usize) -> [Complex<f64>; AXES] {
        core::array::from_fn(|axis| Complex::new(self.cosine[k][axis], -self.sine[k][axis]))
    }
}

/// Cosines of the points of one turn: all angles that occur are whole multiples of a point's.
struct Circle([f64; POINTS]);

impl Circle {
    fn new() -> Self {
        Self(core::array::from_fn(|point| {
            libm::cos(TAU * point as f64 / POINTS as f64)
        }))
    }

    /// Sine and cosine of `points` points of the circle.
    fn sincos(&self, points: usize) -> (f64, f64) {
        (
            self.0[(points + 3 * POINTS / 4) % POINTS],
            self.0[points % POINTS],
        )
    }
}
