//! Structural vibration: the platform rings a little at 12 to 30 Hz while it moves.
//!
//! It is real motion, so that sensors and jacks feel the same of it: every jack's length swings by its share of
//!
//! ```text
//! η = E·sin(Ωt + φ)
//! ```
//!
//! The shares are such that, at home, the vibration shakes the sensor block with 0.02 g in one direction while the
//! platform also rocks a little. The envelope E goes from 0 at rest to 1 in motion and lags behind by a critically
//! damped filter E'' = w²(m − E) − 2wE', so that E' and E'' and with them η' and η'' are exact. m = v²/(v² + v0²) is
//! the measure of the jacks' motion, with v the rms of their speeds.

use std::f64::consts::TAU;

use crate::algebra::Vec3;
use crate::jack::JackMotion;
use crate::mechanism::{Mechanism, Pose, Twist};
use crate::random::Stream;

/// Acceleration of the sensor block in full motion, peak, m/s²: 0.02 g.
pub const ACCELERATION_M_S2: f64 = 0.02 * crate::sheet::STANDARD_GRAVITY_M_S2;
/// Frequency, Hz.
pub const FREQUENCY_HZ: [f64; 2] = [12.0, 30.0];
/// Greatest rocking of the platform for 1 m/s² at the sensor block, rad/s².
const ROCKING: f64 = 0.5;
/// Rms speed of the jacks at which the vibration has half its size, m/s.
const HALF_SPEED_M_S: f64 = 0.01;
/// Corner of the envelope, rad/s.
const ENVELOPE: f64 = TAU * 1.0;

/// The vibration of one base.
#[derive(Debug, Clone)]
pub struct Vibration {
    /// Angular frequency, rad/s.
    omega: f64,
    phase: f64,
    /// Swing of each jack at envelope 1, m.
    swing_m: [f64; 6],
    /// E and E'.
    envelope: [f64; 2],
    /// m.
    moving: f64,
}

impl Vibration {
    /// The vibration of a base with these hinges, felt at `lever_arm_m` from O (body axes).
    #[must_use]
    pub fn draw(seed: u64, mechanism: &Mechanism, home: &Pose, lever_arm_m: Vec3) -> Self {
        let stream = |quantity: &str| Stream::new(seed, &format!("vibration.{quantity}"));
        let [low, high] = FREQUENCY_HZ;
        let omega = TAU * stream("frequency").uniform(low, high);
        let amplitude_m = ACCELERATION_M_S2 / (omega * omega);
        let block = Vec3(stream("direction").direction());
        let rocking =
            Vec3(stream("rocking.axis").direction()) * stream("rocking").uniform(0.0, ROCKING);
        let mode = Twist {
            linear: block - rocking.cross(lever_arm_m),
            angular: rocking,
        };
        Self {
            omega,
            phase: stream("phase").uniform(0.0, TAU),
            swing_m: mechanism
                .length_rates(home, &mode)
                .map(|share| share * amplitude_m),
            envelope: [0.0; 2],
            moving: 0.0,
        }
    }

    /// Moves the envelope by one step, in which the jacks have about these speeds.
    pub fn advance(&mut self, speed_m_s: &[f64; 6], step_s: f64) {
        let square = speed_m_s.iter().map(|v| v * v).sum::<f64>() / 6.0;
        self.moving = square / (square + HALF_SPEED_M_S * HALF_SPEED_M_S);
        // Exact for a constant m: the deviation of a critically damped filter is (c0 + c1·t)·exp(−wt).
        let [e, rate] = self.envelope;
        let (c0, decay) = (e - self.moving, libm::exp(-ENVELOPE * step_s));
        let c1 = rate + ENVELOPE * c0;
        let deviation = (c0 + c1 * step_s) * decay;
        self.envelope = [self.moving + deviation, c1 * decay - ENVELOPE * deviation];
    }

    /// Adds the vibration at `time_s` to the motion of the servos.
    #[must_use]
    pub fn added_to(&self, servo: &JackMotion, time_s: f64) -> JackMotion {
        let [e, e1] = self.envelope;
        let e2 = ENVELOPE * (ENVELOPE * (self.moving - e) - 2.0 * e1);
        let (sine, cosine) = libm::sincos(self.omega * time_s + self.phase);
        let eta = e * sine;
        let eta1 = e1 * sine + e * self.omega * cosine;
        let eta2 = (e2 - e * self.omega * self.omega) * sine + 2.0 * e1 * self.omega * cosine;
        let plus = |base: &[f64; 6], part: f64| -> [f64; 6] {
            std::array::from_fn(|k| base[k] + self.swing_m[k] * part)
        };
        JackMotion {
            displacement_m: plus(&servo.displacement_m, eta),
            speed_m_s: plus(&servo.speed_m_s, eta1),
            acceleration_m_s2: plus(&servo.acceleration_m_s2, eta2),
        }
    }
}
