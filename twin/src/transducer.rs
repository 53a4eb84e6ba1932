//! The displacement transducer of a jack: from the true displacement to volts.
//!
//! ```text
//! volts = 1.65 + s_v · ((1 + γ)·x + o + w)       s_v = 3.1 V / stroke
//! ```
//!
//! with the displacement x from mid-stroke, gain error γ, offset o and noise w.

use crate::random::Stream;
use crate::sheet;

/// The board interpolates between two steps of the twin, at any sampling instant: on average over all instants this
/// leaves 2/3 of the variance of independent steps. So the steps carry 3/2 of the variance in the data sheet.
const STEP_VARIANCE: f64 = 1.5;

/// One transducer and its noise.
#[derive(Debug, Clone)]
pub struct Transducer {
    volts_per_m: f64,
    gain: f64,
    offset_m: f64,
    noise: Stream,
    noise_m: f64,
}

impl Transducer {
    /// Draws the transducer of jack 0 to 5 of a base with this stroke (m).
    #[must_use]
    pub fn draw(seed: u64, jack: usize, stroke_m: f64) -> Self {
        let stream =
            |quantity: &str| Stream::new(seed, &format!("transducer.{}.{quantity}", jack + 1));
        Self {
            volts_per_m: sheet::JACK_SPAN_V / stroke_m,
            gain: 1.0 + stream("gain").within(sheet::JACK_GAIN_TOLERANCE),
            offset_m: stream("offset").within(sheet::JACK_OFFSET_TOLERANCE_M),
            noise: stream("noise"),
            noise_m: sheet::JACK_NOISE_RMS_M * STEP_VARIANCE.sqrt(),
        }
    }

    /// Output at a true displacement (m), with fresh noise, V.
    pub fn volts(&mut self, displacement_m: f64) -> f64 {
        let noise_m = self.noise_m * self.noise.normal();
        let shown_m = self.gain * displacement_m + self.offset_m + noise_m;
        sheet::ZERO_V + self.volts_per_m * shown_m
    }
}
