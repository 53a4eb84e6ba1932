//! Whether the base is at home and at rest, seen in the jacks for a second before every run.

use hexsense_core::channel::JACKS;
use hexsense_core::kinematics::displacements;
use hexsense_core::wire::telemetry::Block;

use super::jacks::{Displacements, JackMeans};
use crate::geometry_file::GeometryFile;

/// Windows that are compared: one second of them.
const WINDOWS: usize = 60;
/// Most that windows may differ at rest, m. Noise makes a hundredth of a millimetre.
const MAX_REST_M: f64 = 0.000_5;
/// Most that a jack may be off its home, m: far more than transducers and hinges are off.
const MAX_HOME_OFFSET_M: f64 = 0.02;

/// A base that is not at rest at home.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unrest {
    /// It moves.
    Moving {
        /// The jack, 1 to 6.
        jack: usize,
        /// How far it moved within a second, m.
        moved_m: f64,
    },
    /// It stands still elsewhere.
    Away {
        /// The jack, 1 to 6.
        jack: usize,
        /// How far it is from home, m; positive is longer.
        off_m: f64,
    },
}

/// The jacks of a base at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtRest {
    /// Mean displacement from mid-stroke, m.
    pub mean_m: Displacements,
    /// Standard deviation of a window, m.
    pub deviation_m: Displacements,
}

/// Watches the jacks until the base is at rest at home.
#[derive(Debug)]
pub struct RestWatch {
    home_m: Displacements,
    windows: Vec<Displacements>,
}

impl RestWatch {
    /// A watch for this base.
    #[must_use]
    pub fn new(geometry: &GeometryFile) -> Self {
        let base = &geometry.geometry;
        Self {
            home_m: displacements(base, &base.home()),
            windows: Vec::with_capacity(WINDOWS),
        }
    }

    /// Takes a block; returns the rest when it has lasted for a second.
    ///
    /// # Errors
    /// [`Unrest`] when the base was not at rest at home in that second; the watch then starts from the next block.
    pub fn learn(
        &mut self,
        block: &Block,
        jacks: &mut JackMeans,
    ) -> Result<Option<AtRest>, Unrest> {
        self.windows.extend(jacks.push(block));
        if self.windows.len() < WINDOWS {
            return Ok(None);
        }
        let rest = self.judge();
        self.windows.clear();
        rest.map(Some)
    }

    fn judge(&self) -> Result<AtRest, Unrest> {
        let count = self.windows.len() as f64;
        let mut rest = AtRest {
            mean_m: [0.0; JACKS],
            deviation_m: [0.0; JACKS],
        };
        for jack in 0..JACKS {
            let values = self.windows.iter().map(|window| window[jack]);
            let mean = values.clone().sum::<f64>() / count;
            let variance = values
                .clone()
                .map(|value| (value - mean).powi(2))
                .sum::<f64>()
                / count;
            let lowest = values.clone().fold(f64::INFINITY, f64::min);
            let moved_m = values.fold(f64::NEG_INFINITY, f64::max) - lowest;
            let off_m = mean - self.home_m[jack];
            at_rest_at_home(jack + 1, moved_m, off_m)?;
            rest.mean_m[jack] = mean;
            rest.deviation_m[jack] = variance.sqrt();
        }
        Ok(rest)
    }
}

/// Whether a jack that moved so far within the windows, and is so far from home on the average, is at rest at home.
fn at_rest_at_home(jack: usize, moved_m: f64, off_m: f64) -> Result<(), Unrest> {
    if moved_m > MAX_REST_M {
        return Err(Unrest::Moving { jack, moved_m });
    }
    if off_m.abs() > MAX_HOME_OFFSET_M {
        return Err(Unrest::Away { jack, off_m });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
