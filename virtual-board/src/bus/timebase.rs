//! From core cycles to true time.
//!
//! The core's clock has the error of its source, so cycles and seconds differ:
//!
//! ```text
//! t = t0 + (cycles − cycles0) / (HCLK · (1 + error of the source))
//! ```
//!
//! with a new origin (t0, cycles0) whenever the clock tree changes.

use crate::peripherals::Cycles;
use crate::peripherals::rcc::Source;

/// Relative errors of the board's oscillators.
#[derive(Debug, Clone, Copy)]
pub struct OscillatorErrors {
    /// Of the internal RC oscillator.
    pub internal: f64,
    /// Of the crystal.
    pub crystal: f64,
}

/// The relation of core cycles to true time.
#[derive(Debug, Clone)]
pub struct Timebase {
    errors: OscillatorErrors,
    origin_cycles: Cycles,
    origin_s: f64,
    core_hz: f64,
}

impl Timebase {
    /// Time begins with the core on the internal oscillator at `nominal_hz`.
    pub fn new(errors: OscillatorErrors, nominal_hz: u32) -> Self {
        let core_hz = f64::from(nominal_hz) * (1.0 + errors.internal);
        Self {
            errors,
            origin_cycles: 0,
            origin_s: 0.0,
            core_hz,
        }
    }

    /// From `now` on the core runs at another frequency.
    pub fn change(&mut self, now: Cycles, nominal_hz: u32, source: Source) {
        self.origin_s = self.seconds(now);
        self.origin_cycles = now;
        self.core_hz = f64::from(nominal_hz)
            * match source {
                Source::Internal => 1.0 + self.errors.internal,
                Source::Crystal => 1.0 + self.errors.crystal,
            };
    }

    /// True time since power-on, s, at an instant after the last change (or a little before it, where the newer
    /// frequency is used).
    pub fn seconds(&self, at: Cycles) -> f64 {
        let elapsed = at as f64 - self.origin_cycles as f64;
        self.origin_s + elapsed / self.core_hz
    }

    /// The first cycle that is not before true time `seconds`.
    pub fn cycles(&self, seconds: f64) -> Cycles {
        let elapsed = (seconds - self.origin_s) * self.core_hz;
        (self.origin_cycles as f64 + elapsed.ceil()).max(0.0) as Cycles
    }

    /// True frequency of the core, Hz.
    pub fn core_hz(&self) -> f64 {
        self.core_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ERRORS: OscillatorErrors = OscillatorErrors {
        internal: 0.005,
        crystal: 20e-6,
    };

    #[test]
    fn crystal_error_scales_true_time() {
        let mut timebase = Timebase::new(ERRORS, 16_000_000);
        timebase.change(0, 150_000_000, Source::Crystal);
        // At true time t the core has done 150e6 · (1 + 20e-6) · t cycles.
        assert!((timebase.seconds(150_003_000) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn time_is_continuous_over_a_change_of_clock() {
        let mut timebase = Timebase::new(ERRORS, 16_000_000);
        let before = timebase.seconds(1_000_000);
        timebase.change(1_000_000, 150_000_000, Source::Crystal);
        assert!((timebase.seconds(1_000_000) - before).abs() < 1e-15);
        let later = timebase.cycles(before + 1e-3);
        assert!(later.abs_diff(1_000_000 + 150_003) <= 1, "{later}");
    }
}
