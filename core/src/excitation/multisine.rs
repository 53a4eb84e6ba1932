//! A multisine: several sines of one degree of freedom, all whole multiples of one fundamental frequency.
//!
//! ```text
//! u(t) = w(t)·Σ A_n·cos(2π·h_n·f₀·t + φ_n)      w rises over fade, stays one, falls over fade
//! ```
//!
//! At full amplitude it repeats after 1/f₀, so that a window of whole periods of the fundamental holds whole periods of
//! every line, and no line leaks into another. So degrees of freedom that share f₀ and no harmonic can move at the same
//! time and be told apart afterwards; [`shared`] finds a common harmonic. The phases are those of [`low_crest_phases`].

use core::f64::consts::TAU;

use heapless::Vec;

use super::crest::{self, Line, low_crest_phases};
use super::envelope;

/// Most lines of one degree of freedom.
pub const MAX_LINES: usize = 12;

/// When a multisine fades in, stays and fades out; degrees of freedom that move together share it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// Fundamental frequency f₀, Hz, above 0.
    pub fundamental_hz: f64,
    /// Time to fade in, and again to fade out, s.
    pub fade_s: f64,
    /// Periods of the fundamental at full amplitude in which transients die away.
    pub settle_periods: u16,
    /// Periods of the fundamental at full amplitude for the estimate.
    pub estimate_periods: u16,
}

/// Sines of one degree of freedom that fade in, stay, and fade out together.
#[derive(Debug, Clone, PartialEq)]
pub struct Multisine {
    timing: Timing,
    lines: Vec<Line, MAX_LINES>,
}

impl Multisine {
    /// The multisine with `tones`, harmonic and amplitude (m or rad) of each, and phases for a low crest factor. Tones
    /// beyond [`MAX_LINES`] are left out.
    #[must_use]
    pub fn new(timing: Timing, tones: impl IntoIterator<Item = (u16, f64)>) -> Self {
        let line = |(harmonic, amplitude)| Line {
            harmonic,
            amplitude,
            phase_rad: 0.0,
        };
        let mut lines: Vec<Line, MAX_LINES> = tones.into_iter().take(MAX_LINES).map(line).collect();
        low_crest_phases(&mut lines);
        Self { timing, lines }
    }

    /// When it fades in, stays and fades out.
    #[must_use]
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// Its lines with their phases; amplitudes in m or rad.
    #[must_use]
    pub fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// Peak over root mean square at full amplitude, without unit; 0 without movement.
    #[must_use]
    pub fn crest_factor(&self) -> f64 {
        crest::crest_factor(&self.lines)
    }

    /// Displacement at `t_s` seconds, m or rad; zero outside the multisine.
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        let Timing {
            fundamental_hz,
            fade_s,
            ..
        } = self.timing;
        let line = |line: &Line| {
            let turns = f64::from(line.harmonic) * fundamental_hz * t_s;
            line.amplitude * libm::cos(TAU * turns + line.phase_rad)
        };
        let sum: f64 = self.lines.iter().map(line).sum();
        envelope(t_s, self.timing.duration_s(), fade_s) * sum
    }
}

impl Timing {
    /// Start of the time for the estimate, s from the start.
    #[must_use]
    pub fn estimate_start_s(&self) -> f64 {
        self.fade_s + f64::from(self.settle_periods) / self.fundamental_hz
    }

    /// Time for the estimate, s: whole periods of every line.
    #[must_use]
    pub fn estimate_s(&self) -> f64 {
        f64::from(self.estimate_periods) / self.fundamental_hz
    }

    /// Length with both fades, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.estimate_start_s() + self.estimate_s() + self.fade_s
    }
}

/// The first harmonic that occurs twice in `harmonics`, those of all degrees of freedom that move together; `None` when
/// no harmonic is shared.
#[must_use]
pub fn shared(harmonics: &[u16]) -> Option<u16> {
    let mut before = harmonics.iter().enumerate();
    before
        .find(|(index, harmonic)| {
            harmonics
                .iter()
                .take(*index)
                .any(|other| other == *harmonic)
        })
        .map(|(_, harmonic)| *harmonic)
}
