//! Calibration factors straight from the board's sums: what a sensor should have felt over what it shows.
//!
//! A calibrated triad needs its 3×3 matrix; one number for a driven sensor needs only two amplitudes, and the board's
//! sums hold both. From the sums of the jacks follow their five harmonics, from these the lengths at points of one
//! period, from each point a pose by forward kinematics, and from the path of the pose the amplitude of what the sensor
//! should have felt ([`sine_truth`]):
//!
//! ```text
//! jack sums ──▶ harmonics ──▶ lengths ──▶ poses ──▶ amplitude of the truth ┐
//! sensor sums ──▶ amplitude in counts ─────────────────────────────────────┴▶ k = truth / counts
//! ```
//!
//! It differs from the fitted gain M_ii by what the cross terms of the matrix add, by how far the servos' frequency is
//! from the programmed one, and by noise.

use core::f64::consts::TAU;

use hexsense_core::calibration::truth::{coordinates, sine_truth};
use hexsense_core::channel::{INERTIAL, JACKS, Ratiometric};
use hexsense_core::harmonics::{Harmonics, Series, solve_channel};

use crate::analysis::AnalysisError;
use crate::analysis::assumptions::Assumptions;
use crate::analysis::poses::RunPoses;
use crate::campaign::BoardSums;
use crate::report::signals::value;

/// Points of a period at which poses are found: many more than five harmonics and their products need.
const POINTS: usize = 64;

/// Amplitudes of the driven sensors and of their truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardGain {
    /// Amplitude of the truth by the jack sums, unit of the channel.
    pub truth: f64,
    /// Amplitude of the channel, counts at nominal supply.
    pub counts: f64,
}

impl BoardGain {
    /// The calibration factor, unit per count.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.truth / self.counts
    }
}

/// The nine channels of one run, of which those that its movement drives mean something; `sums` taken at `rate_hz` and
/// a mean supply factor of `supply`.
///
/// # Errors
/// [`AnalysisError`] when the jacks give no pose; `None` when the sums determine no harmonics.
pub fn gains(
    run: &str,
    sums: &BoardSums,
    rate_hz: u32,
    (supply, ratiometric): (f64, Ratiometric),
    assumptions: &Assumptions,
) -> Result<Option<[BoardGain; INERTIAL]>, AnalysisError> {
    let harmonics = |channel: usize| {
        let late_scans = assumptions.board.instant_s(channel) * f64::from(rate_hz);
        solve_channel(&sums.drive, late_scans, &sums.channels[channel])
    };
    let factor = |channel: usize| {
        if ratiometric.has(channel) {
            1.0
        } else {
            supply
        }
    };
    let all: Option<Vec<Harmonics>> = (0..INERTIAL + JACKS).map(harmonics).collect();
    let Some(all) = all else {
        return Ok(None);
    };
    let (sensors, jacks) = all.split_at(INERTIAL);
    let mut poses = RunPoses::new(assumptions, run)?;
    let mut path = Vec::with_capacity(POINTS);
    for point in 0..POINTS {
        let theta = TAU * point as f64 / POINTS as f64;
        let counts =
            core::array::from_fn(|jack| factor(INERTIAL + jack) * value(&jacks[jack], theta, 0.0));
        path.push(coordinates(&poses.next(&counts)?));
    }
    let Some(fits) = Series::fit_all(TAU / POINTS as f64, path.into_iter()) else {
        return Ok(None);
    };
    let omega = TAU * sums.drive.frequency_hz(rate_hz);
    let truth = sine_truth(&fits, omega, assumptions.site.gravity_m_s2);
    let felt = [
        truth.specific_force(&assumptions.site.lever_arm_m)[0],
        truth.angular_acceleration,
        truth.angular_rate,
    ];
    Ok(Some(core::array::from_fn(|channel| BoardGain {
        truth: felt[channel / 3][channel % 3].norm(),
        counts: factor(channel) * sensors[channel].first().amplitude(),
    })))
}
