//! Amplitude and phase of every channel at a known drive frequency.
//!
//! Words: the *drive* is the frequency of the base's movement; *settle* is the time before summing, in which transients
//! pass; a *harmonic* k is the part of a signal at k times the drive frequency.
//!
//! The model of a signal is offset + drift + five harmonics, fitted by least squares:
//!
//! ```text
//! u[n] = c + d·n + Σₖ aₖ cos(kωn) + bₖ sin(kωn)      k = 1..5
//! amplitude Aₖ = √(aₖ² + bₖ²)      u ∝ Aₖ cos(kωn − φₖ), φₖ = atan2(bₖ, aₖ)
//! ```
//!
//! The offset column is needed because a signal rides on gravity, the drift column because sensors creep. Without them
//! a fraction of a period too much, or a creeping zero, would enter the amplitude.
//!
//! - [`drive`]: the frequency, and the blocks to settle and to sum.
//! - [`choice`]: the size of a block for it, and the cost of blocks.
//! - [`table`]: sines as integers, looked up by a 64-bit phase.
//! - [`sums`] and [`analyser`]: the sums that the board makes while it samples, integers only, the same work for every
//!   block.
//! - [`replay`]: the table's values over a window, from the drive alone.
//! - [`solution`]: from sums to harmonics, in `f64`, at report time, on the board and on the host.
//! - [`series`]: the same fit for a recorded series of `f64`, and the drive frequency found from it.

pub mod analyser;
pub mod choice;
pub mod drive;
mod factor;
pub mod replay;
pub mod series;
pub mod solution;
pub mod sums;
pub mod table;

pub use analyser::{Analyser, AnalyserState};
pub use choice::largest_block;
pub use drive::{Drive, DriveError, increment};
pub use replay::Replay;
pub use series::{Series, fit_frequency};
pub use solution::{Solver, solve, solve_channel};
pub use sums::{ChannelSums, Step};
pub use table::HARMONICS;

use serde::{Deserialize, Serialize};

/// Analysers of a board: the drive frequencies that it can estimate at once.
pub const ANALYSERS: usize = 3;
/// Regressors of the fit: offset, drift, and a cosine and a sine for each harmonic.
pub const REGRESSORS: usize = 2 + 2 * HARMONICS;

/// One harmonic: cosine·cos(kθ) + sine·sin(kθ), in the unit of the signal.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Harmonic {
    /// Coefficient of the cosine.
    pub cosine: f64,
    /// Coefficient of the sine.
    pub sine: f64,
}

impl Harmonic {
    /// Amplitude, in the unit of the signal.
    #[must_use]
    #[inline(never)]
    pub fn amplitude(&self) -> f64 {
        libm::sqrt(self.cosine * self.cosine + self.sine * self.sine)
    }

    /// Phase φ of amplitude·cos(kθ − φ), rad in −π..π.
    #[must_use]
    #[inline(never)]
    pub fn phase(&self) -> f64 {
        libm::atan2(self.sine, self.cosine)
    }
}

/// A fitted signal.
#[derive(Debug, Clone, PartialEq)]
pub struct Harmonics {
    /// Mean over the window, in the unit of the signal.
    pub offset: f64,
    /// Change from the window's start to its end.
    pub drift: f64,
    /// The drive frequency and its multiples.
    pub harmonics: [Harmonic; HARMONICS],
    /// Root mean square of the residuals (for sums in blocks: of the block means).
    pub residual_rms: f64,
    /// Standard uncertainties of all results; the residuals count as white noise.
    pub uncertainty: Uncertainty,
}

/// Standard uncertainties of a fit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Uncertainty {
    /// Of the mean over the window, in the unit of the signal.
    pub offset: f64,
    /// Of the change from the window's start to its end.
    pub drift: f64,
    /// Of the harmonics' amplitudes.
    pub amplitude: [f64; HARMONICS],
    /// Of the harmonics' phases, rad; π/√3, that of an unknown phase, for a harmonic that is lost in noise.
    pub phase: [f64; HARMONICS],
}

/// Standard deviation of an unknown angle: π/√3.
const ANY_PHASE: f64 = 1.813_799_364_234_218;

impl Harmonics {
    /// Of a signal that is zero.
    pub const NONE: Self = Self {
        offset: 0.0,
        drift: 0.0,
        harmonics: [Harmonic {
            cosine: 0.0,
            sine: 0.0,
        }; HARMONICS],
        residual_rms: 0.0,
        uncertainty: Uncertainty {
            offset: 0.0,
            drift: 0.0,
            amplitude: [0.0; HARMONICS],
            phase: [0.0; HARMONICS],
        },
    };

    /// The harmonic at the drive frequency.
    #[must_use]
    pub fn first(&self) -> Harmonic {
        self.harmonics[0]
    }

    /// Total harmonic distortion: √(A₂² + … + A₅²) / A₁; 0 for a signal that stands still.
    #[must_use]
    pub fn distortion(&self) -> f64 {
        let overtones = self.harmonics[1..]
            .iter()
            .map(|h| h.amplitude() * h.amplitude())
            .sum::<f64>();
        let distortion = libm::sqrt(overtones) / self.first().amplitude();
        if distortion.is_finite() {
            distortion
        } else {
            0.0
        }
    }

    /// The same signal with the phases of samples taken earlier by `early_rad` of the drive's phase. A channel that is
    /// converted τ after the trigger reads every phase too small by ωτ; `early_rad` = ωτ refers it to the trigger. Five
    /// times `early_rad` is at most half a turn.
    #[must_use]
    #[inline(never)]
    pub fn sampled_earlier(mut self, early_rad: f64) -> Self {
        for (k, harmonic) in (1..).zip(&mut self.harmonics) {
            let (sine, cosine) = table::sine_cosine(f64::from(k) * early_rad);
            *harmonic = Harmonic {
                cosine: harmonic.cosine * cosine - harmonic.sine * sine,
                sine: harmonic.cosine * sine + harmonic.sine * cosine,
            };
        }
        self
    }
}

/// The parts of the inverted normal equations from which a fit's uncertainties come: times the variance of a row,
/// (co)variances.
#[derive(Debug, Clone, Copy)]
struct Cofactors {
    offset: f64,
    drift: f64,
    /// Of the cosine, of cosine and sine together, of the sine.
    harmonics: [[f64; 3]; HARMONICS],
}

impl Cofactors {
    #[inline(never)]
    fn uncertainty(&self, harmonics: &[Harmonic; HARMONICS], variance: f64) -> Uncertainty {
        let deviation = |cofactor: f64| libm::sqrt((cofactor * variance).max(0.0));
        // The harmonic's own direction gives the amplitude, the direction across it the phase.
        let along = |k: usize, [cosine, sine]: [f64; 2]| {
            let [of_cosine, of_both, of_sine] = self.harmonics[k];
            let of_sum = of_cosine * cosine * cosine + of_sine * sine * sine;
            deviation(of_sum + 2.0 * of_both * cosine * sine)
        };
        let unit = |k: usize| {
            let (harmonic, amplitude) = (&harmonics[k], harmonics[k].amplitude());
            if amplitude > 0.0 {
                [harmonic.cosine / amplitude, harmonic.sine / amplitude]
            } else {
                [1.0, 0.0]
            }
        };
        let of_phase = |k: usize| {
            let [cosine, sine] = unit(k);
            let across = along(k, [-sine, cosine]);
            // Not a number when both are zero: then nothing is known.
            let phase = across / harmonics[k].amplitude();
            if phase < ANY_PHASE { phase } else { ANY_PHASE }
        };
        Uncertainty {
            offset: deviation(self.offset),
            drift: deviation(self.drift),
            amplitude: core::array::from_fn(|k| along(k, unit(k))),
            phase: core::array::from_fn(of_phase),
        }
    }
}
