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

/// Where the sensors sit and what pulls on them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site {
    /// Place of the sensor block from O in body axes, m.
    pub lever_arm_m: Vector3<f64>,
    /// Local gravity, m/s².
    pub gravity_m_s2: f64,
}

/// First harmonics of the truth in a sine run as complex amplitudes a − i·b of a·cos θ + b·sin θ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineTruth {
    /// Specific force at the sensor block, m/s².
    pub specific_force: [Complex<f64>; AXES],
    /// Angular acceleration, rad/s².
    pub angular_acceleration: [Complex<f64>; AXES],
    /// Angular rate, rad/s.
    pub angular_rate: [Complex<f64>; AXES],
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

/// Truth of a sine run from the fits of the six [`coordinates`], driven at `omega` rad/s.
#[must_use]
pub fn sine_truth(fits: &[Harmonics; 6], omega: f64, site: &Site) -> SineTruth {
    let (position, turn) = (
        Path::new([&fits[0], &fits[1], &fits[2]]),
        Path::new([&fits[3], &fits[4], &fits[5]]),
    );
    let mut rate = Decomposition::default();
    for theta in points() {
        rate.add(
            theta,
            &(right_jacobian(&turn.at(theta)) * turn.derivative(theta, 1) * omega),
        );
    }
    let rate = rate.finish();
    let (mut force, mut acceleration) = (Decomposition::default(), Decomposition::default());
    for theta in points() {
        let (w, w_dot) = (rate.at(theta), rate.derivative(theta, 1) * omega);
        let inertial =
            position.derivative(theta, 2) * (omega * omega) + Vector3::y() * site.gravity_m_s2;
        let arm = site.lever_arm_m;
        let felt = UnitQuaternion::from_scaled_axis(turn.at(theta))
            .inverse_transform_vector(&inertial)
            + w_dot.cross(&arm)
            + w.cross(&w.cross(&arm));
        force.add(theta, &felt);
        acceleration.add(theta, &w_dot);
    }
    SineTruth {
        specific_force: force.finish().first(),
        angular_acceleration: acceleration.finish().first(),
        angular_rate: rate.first(),
    }
}

fn points() -> impl Iterator<Item = f64> {
    (0..POINTS).map(|point| TAU * point as f64 / POINTS as f64)
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

    fn at(&self, theta: f64) -> Vector3<f64> {
        self.mean + self.derivative(theta, 0)
    }

    /// The `order`-th derivative of the harmonics with respect to the phase θ.
    fn derivative(&self, theta: f64, order: i32) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for k in 0..HARMONICS {
            let factor = (k + 1) as f64;
            let (sine, cosine) = libm::sincos(factor * theta + f64::from(order) * TAU / 4.0);
            sum += (self.cosine[k] * cosine + self.sine[k] * sine)
                * libm::pow(factor, f64::from(order));
        }
        sum
    }

    fn first(&self) -> [Complex<f64>; AXES] {
        core::array::from_fn(|axis| Complex::new(self.cosine[0][axis], -self.sine[0][axis]))
    }
}

/// Fourier decomposition of a vector known at all [`points`].
#[derive(Debug, Default)]
struct Decomposition(Path);

impl Decomposition {
    fn add(&mut self, theta: f64, value: &Vector3<f64>) {
        self.0.mean += value / POINTS as f64;
        for k in 0..HARMONICS {
            let (sine, cosine) = libm::sincos((k + 1) as f64 * theta);
            self.0.cosine[k] += value * (2.0 * cosine / POINTS as f64);
            self.0.sine[k] += value * (2.0 * sine / POINTS as f64);
        }
    }

    fn finish(self) -> Path {
        self.0
    }
}
