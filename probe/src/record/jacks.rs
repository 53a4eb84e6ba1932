//! Jack displacements as they come from the board, averaged so that mains hum is gone.
//!
//! A window is [`WINDOW`] steps of [`STEP_MS`], 80 ms: four whole periods of 50 Hz. What remains of noise is a hundredth
//! of a millimetre.

use std::collections::VecDeque;

use hexsense_core::channel::{INERTIAL, JACKS};
use hexsense_core::transducers::Transducers;
use hexsense_core::wire::telemetry::Block;

use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// Steps of a window.
pub const WINDOW: usize = 5;
/// Duration of a step, ms: 16 scans at 1 kHz.
pub const STEP_MS: u32 = 16;

/// Displacements of the six jacks from mid-stroke, m.
pub type Displacements = [f64; JACKS];

/// The running mean of the six jacks.
#[derive(Debug, Clone)]
pub struct JackMeans {
    transducers: Transducers<f64>,
    step: Displacements,
    scans: usize,
    window: VecDeque<Displacements>,
}

impl JackMeans {
    /// Nothing seen yet.
    #[must_use]
    pub fn new(geometry: &GeometryFile, sensors: &SensorFile) -> Self {
        Self {
            transducers: sensors.transducers(&geometry.geometry),
            step: [0.0; JACKS],
            scans: 0,
            window: VecDeque::with_capacity(WINDOW),
        }
    }

    /// Takes a block. Returns the mean over the window whenever a step is complete and the window is full. A block without
    /// counts adds nothing.
    pub fn push(&mut self, block: &Block) -> Option<Displacements> {
        let counts = block.counts.as_ref()?;
        let supply = f64::from(block.header.supply);
        let factors = self
            .transducers
            .supplied
            .map(|supplied| if supplied { supply } else { 1.0 });
        for scan in counts {
            let jacks = self.step.iter_mut().zip(factors);
            for ((sum, factor), count) in jacks.zip(&scan[INERTIAL..]) {
                *sum += f64::from(*count) * factor;
            }
        }
        self.scans += counts.len();
        if self.scans * 1_000 < (STEP_MS * block.header.rate_hz) as usize {
            return None;
        }
        let scans = std::mem::take(&mut self.scans) as f64;
        let sums = std::mem::take(&mut self.step);
        let means = std::array::from_fn(|jack| {
            let counts = sums[jack] / scans;
            self.transducers.displacement_m(jack, counts)
        });
        if self.window.len() == WINDOW {
            self.window.pop_front();
        }
        self.window.push_back(means);
        (self.window.len() == WINDOW).then(|| {
            std::array::from_fn(|jack| {
                self.window.iter().map(|means| means[jack]).sum::<f64>() / WINDOW as f64
            })
        })
    }
}
