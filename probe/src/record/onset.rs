//! When a run starts, seen in the jacks while it is recorded.
//!
//! The motion controller starts some seconds after it was told to. The jacks are averaged over [`WINDOW`] blocks, whole
//! periods of the mains at 1 kHz, and compared with their mean at rest:
//!
//! ```text
//! detected:  |Δ_k − rest_k| > max(2 mm, 8σ of a window at rest)     for any jack k
//! onset    = middle of that window − (time at which the program is that far from home)
//! ```
//!
//! This is good to about a tenth of a second: enough to know when the run ends and when to sum. The analysis finds the
//! onset for itself.

use std::collections::VecDeque;

use hexsense::channel::{INERTIAL, JACKS};
use hexsense::kinematics::displacements;
use hexsense::sampling::BLOCK;
use hexsense::wire::telemetry::Block;

use crate::geometry_file::GeometryFile;
use crate::plan::Run;
use crate::sensor_file::SensorFile;

/// Blocks that are averaged: 80 ms at 1 kHz.
pub const WINDOW: usize = 5;
/// Windows from which rest is learnt.
const REST_WINDOWS: usize = 60;
/// Least movement that is taken for the start, m.
const LEAST_M: f64 = 0.002;
/// Most that windows may differ at rest, m: more is a base that moves.
const REST_LIMIT_M: f64 = 0.002;
const SIGMAS: f64 = 8.0;
/// Step at which the program is looked up, s.
const PROGRAM_STEP_S: f64 = 0.01;

/// A base that is not at rest when it should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moving {
    /// The jack, 1 to 6.
    pub jack: usize,
    /// How far it moved, m.
    pub moved_m: f64,
}

/// Watches the jacks for the start of one run.
pub struct OnsetWatch {
    /// Displacements of the program from home, every [`PROGRAM_STEP_S`].
    program: Vec<[f64; JACKS]>,
    metres_at: Box<dyn Fn(f64) -> f64>,
    window: VecDeque<[f64; JACKS]>,
    rest: Vec<[f64; JACKS]>,
    levels: Option<Levels>,
}

/// What rest looks like.
struct Levels {
    mean_m: [f64; JACKS],
    threshold_m: [f64; JACKS],
}

impl OnsetWatch {
    /// A watch for `run` on this base.
    #[must_use]
    pub fn new(run: &Run, geometry: &GeometryFile, sensors: &SensorFile) -> Self {
        let (program, base) = (run.program(), &geometry.geometry);
        let home = displacements(base, &base.home());
        let steps = (program.duration_s() / PROGRAM_STEP_S) as usize;
        let from_home = |step: usize| {
            let now = displacements(base, &program.pose(base, step as f64 * PROGRAM_STEP_S));
            std::array::from_fn(|jack| now[jack] - home[jack])
        };
        let stroke_m = base.length_max_m() - base.length_min_m();
        let sensors = sensors.clone();
        Self {
            program: (0..=steps).map(from_home).collect(),
            metres_at: Box::new(move |counts| sensors.jack_displacement_m(counts, stroke_m)),
            window: VecDeque::with_capacity(WINDOW),
            rest: Vec::with_capacity(REST_WINDOWS),
            levels: None,
        }
    }

    /// Whether enough of the rest has been seen for the run to be started.
    #[must_use]
    pub fn knows_rest(&self) -> bool {
        self.levels.is_some()
    }

    /// Takes a block at rest, before the run is started.
    ///
    /// # Errors
    /// [`Moving`] when the base is not at rest.
    pub fn learn(&mut self, block: &Block) -> Result<(), Moving> {
        if let Some(mean) = self.push(block) {
            self.rest.push(mean);
        }
        if self.rest.len() == REST_WINDOWS && self.levels.is_none() {
            self.levels = Some(Levels::of(&self.rest)?);
        }
        Ok(())
    }

    /// Takes a block after the run was started; the scan of the onset as soon as the base is seen to move.
    pub fn watch(&mut self, block: &Block) -> Option<u64> {
        let mean = self.push(block)?;
        let levels = self.levels.as_ref()?;
        let moved: [f64; JACKS] = std::array::from_fn(|jack| mean[jack] - levels.mean_m[jack]);
        let jack = (0..JACKS).find(|jack| moved[*jack].abs() > levels.threshold_m[*jack])?;
        let reached = self
            .program
            .iter()
            .position(|now| now[jack].abs() >= moved[jack].abs())?;
        let rate = f64::from(block.header.rate_hz);
        let middle = block.header.first_scan + BLOCK as u64 - (WINDOW * BLOCK / 2) as u64;
        let before = (reached as f64 * PROGRAM_STEP_S * rate).round() as u64;
        Some(middle.saturating_sub(before))
    }

    /// Displacements averaged over the last blocks, once there are enough.
    fn push(&mut self, block: &Block) -> Option<[f64; JACKS]> {
        let counts = block.counts.as_ref()?;
        let supply = f64::from(block.header.supply);
        let mean = |jack: usize| {
            let sum: f64 = counts
                .iter()
                .map(|scan| f64::from(scan[INERTIAL + jack]))
                .sum();
            (self.metres_at)(sum / BLOCK as f64 * supply)
        };
        let means = std::array::from_fn(mean);
        if self.window.len() == WINDOW {
            self.window.pop_front();
        }
        self.window.push_back(means);
        (self.window.len() == WINDOW).then(|| {
            std::array::from_fn(|jack| {
                self.window.iter().map(|block| block[jack]).sum::<f64>() / WINDOW as f64
            })
        })
    }
}

impl Levels {
    fn of(rest: &[[f64; JACKS]]) -> Result<Self, Moving> {
        let count = rest.len() as f64;
        let mut levels = Self {
            mean_m: [0.0; JACKS],
            threshold_m: [0.0; JACKS],
        };
        for jack in 0..JACKS {
            let values = rest.iter().map(|window| window[jack]);
            let mean = values.clone().sum::<f64>() / count;
            let variance = values
                .clone()
                .map(|value| (value - mean).powi(2))
                .sum::<f64>()
                / count;
            let (low, high) = values
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                    (low.min(value), high.max(value))
                });
            if high - low > REST_LIMIT_M {
                return Err(Moving {
                    jack: jack + 1,
                    moved_m: high - low,
                });
            }
            levels.mean_m[jack] = mean;
            levels.threshold_m[jack] = LEAST_M.max(SIGMAS * variance.sqrt());
        }
        Ok(levels)
    }
}
