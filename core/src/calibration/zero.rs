//! Zero: the mean of each channel while the program signal is zero, refused when the base was not at rest.
//!
//! Sensors are noisy, so noise alone is no sign of movement. Two numbers are compared with limits that the caller gives:
//! the scatter of the means over *segments* of a tenth of the run, and the slope through these means.

use crate::least_squares::NormalEquations;
use nalgebra::Vector2;

/// Segments into which a zero run is cut.
pub const SEGMENTS: usize = 10;

/// Limits that a channel at rest keeps, counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZeroLimits {
    /// Largest standard deviation of the segment means.
    pub deviation: f64,
    /// Largest change from start to end.
    pub drift: f64,
}

/// A channel at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zero {
    /// Mean, counts.
    pub mean: f64,
    /// Standard deviation of the segment means about their line, counts.
    pub deviation: f64,
    /// Change from start to end, counts.
    pub drift: f64,
}

/// Why a zero run was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ZeroError {
    /// Fewer samples than segments.
    #[error("a zero run of {samples} samples is too short; record at least {SEGMENTS}")]
    Short {
        /// Samples given.
        samples: usize,
    },
    /// A sample is NaN or infinite.
    #[error("sample {sample} of a zero run is not a finite number; check the capture and repeat")]
    NotFinite {
        /// Its place in the run, from 0.
        sample: usize,
    },
    /// The signal scattered.
    #[error(
        "the signal scattered by {deviation:.1} counts (limit {limit:.1}); let the base come to rest and repeat"
    )]
    Moved {
        /// Standard deviation of the segment means, counts.
        deviation: f64,
        /// The limit.
        limit: f64,
    },
    /// The signal drifted.
    #[error(
        "the signal drifted by {drift:.1} counts (limit {limit:.1}); let base and sensors settle and repeat"
    )]
    Drifted {
        /// Change over the run, counts.
        drift: f64,
        /// The limit.
        limit: f64,
    },
}

/// Judges one channel of a zero run; `samples` are counts at nominal supply.
///
/// # Errors
/// Every variant of [`ZeroError`].
pub fn zero(samples: &[f64], limits: ZeroLimits) -> Result<Zero, ZeroError> {
    let length = samples.len() / SEGMENTS;
    if length == 0 {
        return Err(ZeroError::Short {
            samples: samples.len(),
        });
    }
    if let Some(sample) = samples.iter().position(|value| !value.is_finite()) {
        return Err(ZeroError::NotFinite { sample });
    }
    let mut line = NormalEquations::<2>::default();
    for (segment, samples) in samples.chunks_exact(length).take(SEGMENTS).enumerate() {
        let place = (segment as f64 + 0.5) / SEGMENTS as f64 - 0.5;
        line.add(&Vector2::new(1.0, place), mean(samples), 1.0);
    }
    let fit = line.solve().ok_or(ZeroError::Short {
        samples: samples.len(),
    })?;
    let deviation = libm::sqrt(fit.residual_square / f64::from(fit.degrees_of_freedom));
    let drift = fit.unknowns[1];
    if deviation.is_nan() || deviation > limits.deviation {
        return Err(ZeroError::Moved {
            deviation,
            limit: limits.deviation,
        });
    }
    if drift.is_nan() || drift.abs() > limits.drift {
        return Err(ZeroError::Drifted {
            drift,
            limit: limits.drift,
        });
    }
    Ok(Zero {
        mean: mean(samples),
        deviation,
        drift,
    })
}

fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len() as f64
}
