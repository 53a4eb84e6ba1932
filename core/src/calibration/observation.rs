//! What a triad is calibrated from: means on holds, amplitudes in sine runs, and the noise of both.

use nalgebra::{Complex, Vector3};

use super::AXES;

/// Means over one hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredHold {
    /// Which run with holds, 0 or 1.
    pub run: usize,
    /// Middle of the averaged stretch, s from any common origin.
    pub time_s: f64,
    /// Length of the averaged stretch, s.
    pub length_s: f64,
    /// Mean counts of the triad.
    pub counts: Vector3<f64>,
    /// True specific force, m/s².
    pub truth: Vector3<f64>,
}

/// First harmonics in one sine run as complex amplitudes a − i·b, phase zero at the same instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineRun {
    /// Drive frequency, rad/s.
    pub omega: f64,
    /// Length of the estimate, s.
    pub length_s: f64,
    /// Counts of the triad.
    pub counts: [Complex<f64>; AXES],
    /// Truth, in the triad's unit.
    pub truth: [Complex<f64>; AXES],
}

/// Random errors of a triad's sensors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// White noise at low frequencies, counts/√Hz (one-sided), for each sensor.
    pub density: [f64; AXES],
    /// Random walk of the bias, counts/√s, for each sensor.
    pub walk: [f64; AXES],
}

impl Noise {
    /// Variance of a mean over `length_s` by white noise, counts²: density²/2T.
    #[must_use]
    pub fn hold_variance(&self, sensor: usize, length_s: f64) -> f64 {
        self.density[sensor] * self.density[sensor] / (2.0 * length_s)
    }

    /// Variances of the real and the imaginary part of an amplitude at `omega` rad/s estimated over `length_s`,
    /// counts²: the density of all noise at that frequency, squared, over T. A walk has the density √2·walk/ω there. The
    /// imaginary part, a sine over whole periods from its zero on, shares the window with the drift that is fitted
    /// beside it: over P periods its variance is larger by 1/(1 − 6/π²P²).
    #[must_use]
    pub fn amplitude_variances(&self, sensor: usize, omega: f64, length_s: f64) -> [f64; 2] {
        let walk = self.walk[sensor] / omega;
        let density = self.density[sensor] * self.density[sensor] + 2.0 * walk * walk;
        // πP = ωT/2; a fit needs a period at least.
        let half_turns = (omega * length_s / 2.0).max(core::f64::consts::PI);
        let shared = 6.0 / (half_turns * half_turns);
        let variance = density / length_s;
        [variance, variance / (1.0 - shared)]
    }
}
