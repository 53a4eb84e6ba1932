//! Jack displacements as they come from the board, averaged so that mains hum is gone.
//!
//! A window is [`WINDOW`] blocks, 80 ms at 1 kHz: four whole periods of 50 Hz. What remains of noise is a hundredth of
//! a millimetre.

use std::collections::VecDeque;

use hexsense::channel::{INERTIAL, JACKS};
use hexsense::wire::telemetry::Block;

use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// Blocks of a window.
pub const WINDOW: usize = 5;

/// Displacements of the six jacks from mid-stroke, m.
pub type Displacements = [f64; JACKS];

/// The running mean of the six jacks.
#[derive(Debug, Clone)]
pub struct JackMeans {
    sensors: SensorFile,
    stroke_m: f64,
    window: VecDeque<Displacements>,
}

impl JackMeans {
    /// Nothing seen yet.
    #[must_use]
    pub fn new(geometry: &GeometryFile, sensors: &SensorFile) -> Self {
        let base = &geometry.geometry;
        Self {
            sensors: sensors.clone(),
            stroke_m: base.length_max_m() - base.length_min_m(),
            window: VecDeque::with_capacity(WINDOW),
        }
    }

    /// Takes a block; the mean over the window once it is full. A block without counts adds nothing.
    pub fn push(&mut self, block: &Block) -> Option<Displacements> {
        let counts = block.counts.as_ref()?;
        let supply = f64::from(block.header.supply);
        let mean = |jack: usize| {
            let of_jack = counts.iter().map(|scan| f64::from(scan[INERTIAL + jack]));
            let mean = of_jack.sum::<f64>() / counts.len() as f64;
            self.sensors
                .jack_displacement_m(mean * supply, self.stroke_m)
        };
        let means = std::array::from_fn(mean);
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
