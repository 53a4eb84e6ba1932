//! A sine run reduced: drive frequency, harmonics of the sensors, means of the jacks.
//!
//! The motion controller's clock is not the board's, so the drive frequency is fitted to the jack that moves most.

use core::f64::consts::TAU;
use core::ops::Range;

use hexsense_core::channel::{CHANNELS, INERTIAL, JACKS, NAMES};
use hexsense_core::excitation::{DegreeOfFreedom, Sine};
use hexsense_core::harmonics::{Harmonics, Series, fit_frequency};
use hexsense_core::kinematics::Geometry;

use super::condense::{Counts, Sweep};
use super::onset::most_moved;
use super::{AnalysisError, RecordedRun};

/// Jack series are averaged down to this rate, Hz: ten times the fifth harmonic of 1 Hz.
const JACK_RATE_HZ: u32 = 50;

impl Sweep {
    /// Reduces a sine run that drives `freedom` by `sine` and starts at `onset_s`, s from the start of the capture.
    ///
    /// # Errors
    /// [`AnalysisError::Short`] and [`AnalysisError::NoSine`].
    pub fn new(
        counts: &Counts,
        onset_s: f64,
        freedom: DegreeOfFreedom,
        sine: Sine,
        geometry: &Geometry<f64>,
    ) -> Result<Self, AnalysisError> {
        let start_s = onset_s + sine.estimate_start_s();
        let range = counts.stretch(start_s, start_s + sine.estimate_s)?;
        let rate = f64::from(counts.run.rate_hz);
        let jacks = most_moved(&counts.program_rows(geometry));
        let channel = INERTIAL + jacks.first().unwrap_or(&0);
        let series: Vec<f64> = counts.channels[range.clone()]
            .iter()
            .map(|scan| scan[channel])
            .collect();
        let per_scan = fit_frequency(&series, TAU * sine.frequency_hz / rate)
            .ok_or_else(|| no_sine(counts.run, &sine, channel))?;
        let (sensors, jacks) =
            parts(counts, range.clone(), per_scan).ok_or_else(|| no_sine(counts.run, &sine, 0))?;
        Ok(Self {
            name: counts.run.name.clone(),
            freedom,
            sine,
            rate_hz: counts.run.rate_hz,
            omega: per_scan * rate,
            length_s: range.len() as f64 / rate,
            first: range.start,
            onset_s,
            sensors,
            jacks,
            group: group(counts.run.rate_hz),
        })
    }

    /// The same run without the first third of its periods, at least one; all of it when there is only one.
    ///
    /// # Errors
    /// [`AnalysisError::NoSine`].
    pub fn later(&self, counts: &Counts) -> Result<Self, AnalysisError> {
        let rate = f64::from(counts.run.rate_hz);
        let periods = (self.length_s * self.omega / TAU).round();
        let skipped = (periods / 3.0).ceil();
        if skipped >= periods {
            return Ok(self.clone());
        }
        let scans = (skipped * TAU / self.omega * rate).round() as usize;
        let last = self.first + (self.length_s * rate).round() as usize;
        let range = self.first + scans..last;
        let (sensors, jacks) = parts(counts, range.clone(), self.omega / rate)
            .ok_or_else(|| no_sine(counts.run, &self.sine, 0))?;
        Ok(Self {
            length_s: range.len() as f64 / rate,
            first: range.start,
            sensors,
            jacks,
            ..self.clone()
        })
    }
}

fn no_sine(run: &RecordedRun, sine: &Sine, channel: usize) -> AnalysisError {
    AnalysisError::NoSine {
        run: run.name.clone(),
        channel: NAMES[channel],
        frequency_hz: sine.frequency_hz,
    }
}

/// Fits of the sensors and means of the jacks over some scans; `None` when there are too few.
fn parts(counts: &Counts, range: Range<usize>, per_scan: f64) -> Option<Parts> {
    let scans = &counts.channels[range];
    let inertial = scans
        .iter()
        .map(|scan| core::array::from_fn::<_, INERTIAL, _>(|channel| scan[channel]));
    let sensors = Series::fit_all(per_scan, inertial)?;
    let jacks = scans
        .chunks_exact(group(counts.run.rate_hz))
        .map(group_mean);
    Some((sensors, jacks.collect()))
}

type Parts = ([Harmonics; INERTIAL], Vec<[f64; JACKS]>);

fn group(rate_hz: u32) -> usize {
    (rate_hz / JACK_RATE_HZ) as usize
}

fn group_mean(scans: &[[f64; CHANNELS]]) -> [f64; JACKS] {
    core::array::from_fn(|jack| {
        scans.iter().map(|scan| scan[INERTIAL + jack]).sum::<f64>() / scans.len() as f64
    })
}
