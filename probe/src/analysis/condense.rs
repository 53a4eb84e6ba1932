//! Captures reduced to what the estimate needs.
//!
//! Counts are multiplied by the supply factor first. The start of the movement is found from the jacks, since a
//! motion controller shares no clock with the board.

use core::ops::Range;

use hexsense_core::channel::{CHANNELS, INERTIAL, JACKS};
use hexsense_core::excitation::{DegreeOfFreedom, Signal, Sine};
use hexsense_core::harmonics::Harmonics;
use hexsense_core::kinematics::Geometry;

use super::noise::Scatter;
use super::{AnalysisError, RecordedRun};

/// Time that the base is given to come to rest on a hold, s.
const HOLD_SETTLE_S: f64 = 1.5;
/// Distance kept from the end of a hold and from the start of the movement, s.
const GUARD_S: f64 = 0.2;

/// Means over one stretch at rest.
#[derive(Debug, Clone)]
pub struct RestMeans {
    /// Middle of the stretch, s from the start of the board's scan counter.
    pub time_s: f64,
    /// Its length, s.
    pub length_s: f64,
    /// Mean counts of all channels.
    pub counts: [f64; CHANNELS],
    /// Standard uncertainty of the jacks' means by how they scatter in the stretch, counts.
    pub jack_noise: [f64; JACKS],
}

/// A sine run, reduced.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// Name of the run.
    pub name: String,
    /// What was driven.
    pub freedom: DegreeOfFreedom,
    /// The program's sine.
    pub sine: Sine,
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Drive frequency by the board's clock, rad/s.
    pub omega: f64,
    /// Length of the estimate, s.
    pub length_s: f64,
    /// First scan of the estimate, counted from the start of the capture.
    pub first: usize,
    /// Start of the movement, s from the start of the capture.
    pub onset_s: f64,
    /// Fits of the nine inertial channels, counts; phase zero at the trigger of the first scan.
    pub sensors: [Harmonics; INERTIAL],
    /// Mean counts of the jacks over groups of scans.
    pub jacks: Vec<[f64; JACKS]>,
    /// Scans in a group.
    pub group: usize,
}

/// The holds of one run.
#[derive(Debug, Clone)]
pub struct HoldRun {
    /// Name of the run.
    pub name: String,
    /// Start of the movement, s from the start of the capture.
    pub onset_s: f64,
    /// One entry for each hold, the rest before the movement first.
    pub holds: Vec<RestMeans>,
}

/// A capture in counts at nominal supply.
pub struct Counts<'a> {
    pub(super) run: &'a RecordedRun,
    pub(super) channels: Vec<[f64; CHANNELS]>,
}

impl<'a> Counts<'a> {
    /// Applies the supply factor.
    ///
    /// # Errors
    /// [`AnalysisError::Gap`]: places in a capture with a gap are not times any more.
    pub fn new(run: &'a RecordedRun) -> Result<Self, AnalysisError> {
        let capture = &run.capture;
        if let Some(gap) = capture.gaps().first() {
            return Err(AnalysisError::Gap {
                run: run.name.clone(),
                scan: gap.first_scan,
                missing: gap.scans,
            });
        }
        let channels = capture.counts.iter().zip(&capture.supply);
        let channels = channels.map(|(scan, supply)| {
            core::array::from_fn(|channel| {
                let factor = run.ratiometric.factor(channel, *supply);
                f64::from(scan[channel]) * f64::from(factor)
            })
        });
        Ok(Self {
            run,
            channels: channels.collect(),
        })
    }

    /// The run that they are of.
    #[must_use]
    pub fn run(&self) -> &'a RecordedRun {
        self.run
    }

    /// Counts of all scans.
    #[must_use]
    pub fn scans(&self) -> &[[f64; CHANNELS]] {
        &self.channels
    }

    /// Scans.
    #[must_use]
    pub fn len(&self) -> usize {
        self.channels.len()
    }

    /// Whether there is no scan.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.channels.is_empty()
    }

    /// Scans from `from_s` to `to_s`, s from the start of the capture.
    pub(super) fn stretch(&self, from_s: f64, to_s: f64) -> Result<Range<usize>, AnalysisError> {
        let rate = f64::from(self.run.rate_hz);
        let (from, to) = (
            (from_s * rate).round() as usize,
            (to_s * rate).round() as usize,
        );
        if to > self.len() {
            let missing_s = (to - self.len()) as f64 / rate;
            return Err(AnalysisError::Short {
                run: self.run.name.clone(),
                missing_s,
            });
        }
        Ok(from..to)
    }

    /// Means over a stretch at rest.
    ///
    /// # Errors
    /// [`AnalysisError::Short`].
    pub fn rest(&self, from_s: f64, to_s: f64) -> Result<RestMeans, AnalysisError> {
        let range = self.stretch(from_s, to_s)?;
        let scans = &self.channels[range.clone()];
        let mut counts = [0.0; CHANNELS];
        for scan in scans {
            counts
                .iter_mut()
                .zip(scan)
                .for_each(|(sum, count)| *sum += count / scans.len() as f64);
        }
        let rate = f64::from(self.run.rate_hz);
        let start = self
            .run
            .capture
            .scans
            .first()
            .map_or(0.0, |scan| *scan as f64 / rate);
        Ok(RestMeans {
            time_s: start + (from_s + to_s) / 2.0,
            length_s: to_s - from_s,
            counts,
            jack_noise: core::array::from_fn(|jack| {
                let mut scatter = Scatter::default();
                let jack = scans.iter().map(|scan| scan[INERTIAL + jack]);
                scatter.add(&jack.collect::<Vec<f64>>(), self.run.rate_hz);
                scatter.density() / (2.0 * (to_s - from_s)).sqrt()
            }),
        })
    }

    /// Adds what the sensors scatter from `from_s` to `to_s`, a stretch at rest, to `scatters`.
    ///
    /// # Errors
    /// [`AnalysisError::Short`].
    pub fn add_scatter(
        &self,
        (from_s, to_s): (f64, f64),
        scatters: &mut [Scatter; INERTIAL],
    ) -> Result<(), AnalysisError> {
        let scans = &self.channels[self.stretch(from_s, to_s)?];
        for (channel, scatter) in scatters.iter_mut().enumerate() {
            let samples: Vec<f64> = scans.iter().map(|scan| scan[channel]).collect();
            scatter.add(&samples, self.run.rate_hz);
        }
        Ok(())
    }

    /// One channel over the whole capture.
    #[must_use]
    pub fn channel(&self, channel: usize) -> Vec<f64> {
        self.channels.iter().map(|scan| scan[channel]).collect()
    }
}

/// Which part of a stretch that was given time to settle is reduced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    Whole,
    /// Its second half.
    Later,
}

impl HoldRun {
    /// Reduces a ramp-and-hold run whose movement starts at `onset_s`, s from the start of the capture.
    ///
    /// # Errors
    /// [`AnalysisError::Short`].
    pub fn new(counts: &Counts, onset_s: f64, part: Part) -> Result<Self, AnalysisError> {
        let rest = |from_s: f64, to_s: f64| match part {
            Part::Whole => counts.rest(from_s, to_s),
            Part::Later => counts.rest((from_s + to_s) / 2.0, to_s),
        };
        let mut holds = Vec::new();
        if let Some((from_s, to_s)) = before(onset_s) {
            holds.push(rest(from_s, to_s)?);
        }
        for (_, signal) in &counts.run.program.signals {
            let Signal::Ramps(ramps) = signal else {
                continue;
            };
            for hold in ramps
                .holds()
                .filter(|hold| hold.length_s > HOLD_SETTLE_S + GUARD_S)
            {
                let start_s = onset_s + hold.start_s;
                holds.push(rest(
                    start_s + HOLD_SETTLE_S,
                    start_s + hold.length_s - GUARD_S,
                )?);
            }
        }
        Ok(Self {
            name: counts.run.name.clone(),
            onset_s,
            holds,
        })
    }
}

/// The rest before a movement, s from the start of the capture; nothing when it is too short to be of use.
#[must_use]
pub fn before(onset_s: f64) -> Option<(f64, f64)> {
    (onset_s > 1.0 + 2.0 * GUARD_S).then_some((GUARD_S, onset_s - GUARD_S))
}

/// Reduces a ramp-and-hold run.
///
/// # Errors
/// [`AnalysisError`] when the movement is not found, cut off or has gaps.
pub fn hold_run(run: &RecordedRun, geometry: &Geometry<f64>) -> Result<HoldRun, AnalysisError> {
    let counts = Counts::new(run)?;
    HoldRun::new(&counts, counts.onset_s(geometry)?, Part::Whole)
}

/// Reduces a sine run that drives `freedom` by `sine`.
///
/// # Errors
/// [`AnalysisError`] when the movement is not found, cut off, has gaps or is no sine.
pub fn sweep(
    run: &RecordedRun,
    freedom: DegreeOfFreedom,
    sine: Sine,
    geometry: &Geometry<f64>,
) -> Result<Sweep, AnalysisError> {
    let counts = Counts::new(run)?;
    Sweep::new(&counts, counts.onset_s(geometry)?, freedom, sine, geometry)
}

#[cfg(test)]
mod tests;
