//! A sine with a smooth start and end.
//!
//! ```text
//! u(t) = w(t)·A·sin(2πft + φ)      w rises over fade, stays one, falls over fade
//! ```
//!
//! For several frequencies at once see [`super::multisine`].

use core::f64::consts::TAU;

use super::envelope;

/// A sine that fades in, stays, and fades out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine {
    /// Amplitude A, m or rad.
    pub amplitude: f64,
    /// Drive frequency f, Hz.
    pub frequency_hz: f64,
    /// Phase φ at the start, rad.
    pub phase_rad: f64,
    /// Time to fade in, and again to fade out, s.
    pub fade_s: f64,
    /// Time at full amplitude in which transients die away, s.
    pub settle_s: f64,
    /// Time at full amplitude for the estimate, s.
    pub estimate_s: f64,
}

impl Sine {
    /// A sine of `settle` and `estimate` whole periods at full amplitude, with a fade of one period at each end.
    #[must_use]
    pub fn of_periods(amplitude: f64, frequency_hz: f64, settle: u32, estimate: u32) -> Self {
        let period_s = 1.0 / frequency_hz;
        Self {
            amplitude,
            frequency_hz,
            phase_rad: 0.0,
            fade_s: period_s,
            settle_s: f64::from(settle) * period_s,
            estimate_s: f64::from(estimate) * period_s,
        }
    }

    /// Start of the time for the estimate, s from the start.
    #[must_use]
    pub fn estimate_start_s(&self) -> f64 {
        self.fade_s + self.settle_s
    }

    /// Length with both fades, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        2.0 * self.fade_s + self.settle_s + self.estimate_s
    }

    /// Displacement at `t_s` seconds; zero outside the sine.
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        envelope(t_s, self.duration_s(), self.fade_s)
            * self.amplitude
            * libm::sin(TAU * self.frequency_hz * t_s + self.phase_rad)
    }
}
