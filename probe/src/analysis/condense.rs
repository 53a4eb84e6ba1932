//! Captures reduced to what the estimate needs.
//!
//! Counts are multiplied by the supply factor first. The start of the movement is found from the jacks, since a
//! motion controller shares no clock with the board; so is the drive frequency.

use core::f64::consts::TAU;

use hexsense::channel::{CHANNELS, INERTIAL, JACKS, NAMES};
use hexsense::excitation::{DegreeOfFreedom, Program, Signal, Sine};
use hexsense::harmonics::{Harmonics, Series, fit_frequency};
use hexsense::kinematics::{Geometry, displacements};

use super::{AnalysisError, Run};

/// Time that the base is given to come to rest on a hold, s.
const HOLD_SETTLE_S: f64 = 1.5;
/// Distance kept from the end of a hold and from the start of the movement, s.
const GUARD_S: f64 = 0.2;
/// Jack series are averaged down to this rate, Hz: ten times the fifth harmonic of 1 Hz.
const JACK_RATE_HZ: u32 = 50;
/// Step of the search for the start of a movement, s.
const SEARCH_STEP_S: f64 = 0.01;

/// Means over one stretch at rest.
#[derive(Debug, Clone)]
pub struct Rest {
    /// Middle of the stretch, s from the start of the board's scan counter.
    pub time_s: f64,
    /// Its length, s.
    pub length_s: f64,
    /// Mean counts of all channels.
    pub counts: [f64; CHANNELS],
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
    pub holds: Vec<Rest>,
}

/// A capture in counts at nominal supply.
pub struct Counts<'a> {
    run: &'a Run,
    channels: Vec<[f64; CHANNELS]>,
}

impl<'a> Counts<'a> {
    /// Applies the supply factor.
    ///
    /// # Errors
    /// [`AnalysisError::Gap`]: places in a capture with a gap are not times any more.
    pub fn new(run: &'a Run) -> Result<Self, AnalysisError> {
        let capture = &run.capture;
        if let Some(gap) = capture.gaps().first() {
            let scan = capture.scans[gap.before] - gap.missing;
            return Err(AnalysisError::Gap {
                run: run.name.clone(),
                scan,
                missing: gap.missing,
            });
        }
        let channels = capture.counts.iter().zip(&capture.supply);
        let channels =
            channels.map(|(scan, supply)| scan.map(|count| f64::from(count) * f64::from(*supply)));
        Ok(Self {
            run,
            channels: channels.collect(),
        })
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
    fn stretch(&self, from_s: f64, to_s: f64) -> Result<std::ops::Range<usize>, AnalysisError> {
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
    pub fn rest(&self, from_s: f64, to_s: f64) -> Result<Rest, AnalysisError> {
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
        Ok(Rest {
            time_s: start + (from_s + to_s) / 2.0,
            length_s: to_s - from_s,
            counts,
        })
    }

    /// One channel over the whole capture.
    #[must_use]
    pub fn channel(&self, channel: usize) -> Vec<f64> {
        self.channels.iter().map(|scan| scan[channel]).collect()
    }

    /// Start of the program in the capture, s: where the jack that moves most fits its program best.
    ///
    /// # Errors
    /// [`AnalysisError::NotFound`] when no place fits.
    pub fn onset_s(&self, geometry: &Geometry<f64>) -> Result<f64, AnalysisError> {
        let (jack, program) = most_moved(&self.run.program, geometry);
        let stride = (f64::from(self.run.rate_hz) * SEARCH_STEP_S).round() as usize;
        let measured: Vec<f64> = self
            .channels
            .iter()
            .step_by(stride)
            .map(|scan| scan[INERTIAL + jack])
            .collect();
        let places = measured.len().saturating_sub(program.len());
        let best = (0..=places)
            .filter_map(|place| Some((place, correlation(measured.get(place..)?, &program)?)));
        let (place, fit) = best.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
        if fit < 0.9 {
            return Err(AnalysisError::NotFound {
                run: self.run.name.clone(),
                fit: fit.max(0.0) * 100.0,
            });
        }
        Ok(place as f64 * SEARCH_STEP_S)
    }
}

/// The jack that a program moves most, and its displacement every [`SEARCH_STEP_S`].
fn most_moved(program: &Program, geometry: &Geometry<f64>) -> (usize, Vec<f64>) {
    let steps = (program.duration_s() / SEARCH_STEP_S).ceil() as usize;
    let rows: Vec<[f64; JACKS]> = (0..=steps)
        .map(|step| {
            displacements(
                geometry,
                &program.pose(geometry, step as f64 * SEARCH_STEP_S),
            )
        })
        .collect();
    let range = |jack: usize| {
        let (low, high) = rows.iter().fold((f64::MAX, f64::MIN), |(low, high), row| {
            (low.min(row[jack]), high.max(row[jack]))
        });
        high - low
    };
    let jack = (0..JACKS)
        .max_by(|a, b| range(*a).total_cmp(&range(*b)))
        .unwrap_or(0);
    (jack, rows.iter().map(|row| row[jack]).collect())
}

/// Correlation of the start of `measured` with `program`, −1 to 1; `None` when it is too short or does not move.
fn correlation(measured: &[f64], program: &[f64]) -> Option<f64> {
    let measured = measured.get(..program.len())?;
    let count = program.len() as f64;
    let (m, p) = (
        measured.iter().sum::<f64>() / count,
        program.iter().sum::<f64>() / count,
    );
    let (mut cross, mut mm, mut pp) = (0.0, 0.0, 0.0);
    for (measured, program) in measured.iter().zip(program) {
        cross += (measured - m) * (program - p);
        mm += (measured - m) * (measured - m);
        pp += (program - p) * (program - p);
    }
    (mm > 0.0 && pp > 0.0).then(|| cross / (mm * pp).sqrt())
}

/// Reduces a ramp-and-hold run.
///
/// # Errors
/// [`AnalysisError`] when the movement is not found, cut off or has gaps.
pub fn hold_run(run: &Run, geometry: &Geometry<f64>) -> Result<HoldRun, AnalysisError> {
    let counts = Counts::new(run)?;
    let onset_s = counts.onset_s(geometry)?;
    let mut holds = Vec::new();
    if onset_s > 1.0 + 2.0 * GUARD_S {
        holds.push(counts.rest(GUARD_S, onset_s - GUARD_S)?);
    }
    for (_, signal) in &run.program.signals {
        if let Signal::Ramps(ramps) = signal {
            for hold in ramps
                .holds()
                .filter(|hold| hold.length_s > HOLD_SETTLE_S + GUARD_S)
            {
                let start_s = onset_s + hold.start_s;
                holds
                    .push(counts.rest(start_s + HOLD_SETTLE_S, start_s + hold.length_s - GUARD_S)?);
            }
        }
    }
    Ok(HoldRun {
        name: run.name.clone(),
        onset_s,
        holds,
    })
}

/// Reduces a sine run that drives `freedom` by `sine`.
///
/// # Errors
/// [`AnalysisError`] when the movement is not found, cut off, has gaps or is no sine.
pub fn sweep(
    run: &Run,
    freedom: DegreeOfFreedom,
    sine: Sine,
    geometry: &Geometry<f64>,
) -> Result<Sweep, AnalysisError> {
    let counts = Counts::new(run)?;
    let onset_s = counts.onset_s(geometry)?;
    let start_s = onset_s + sine.estimate_start_s();
    let range = counts.stretch(start_s, start_s + sine.estimate_s)?;
    let rate = f64::from(run.rate_hz);
    let (jack, _) = most_moved(&run.program, geometry);
    let no_sine = |channel: usize| AnalysisError::NoSine {
        run: run.name.clone(),
        channel: NAMES[channel],
        frequency_hz: sine.frequency_hz,
    };
    let series = |channel: usize| -> Vec<f64> {
        counts.channels[range.clone()]
            .iter()
            .map(|scan| scan[channel])
            .collect()
    };
    let per_scan = fit_frequency(&series(INERTIAL + jack), TAU * sine.frequency_hz / rate)
        .ok_or_else(|| no_sine(INERTIAL + jack))?;
    let scans = counts.channels[range.clone()].iter();
    let inertial =
        scans.map(|scan| core::array::from_fn::<_, INERTIAL, _>(|channel| scan[channel]));
    let sensors = Series::fit_all(per_scan, inertial).ok_or_else(|| no_sine(0))?;
    let group = (run.rate_hz / JACK_RATE_HZ) as usize;
    let jacks = counts.channels[range.clone()]
        .chunks_exact(group)
        .map(group_mean)
        .collect();
    let length_s = range.len() as f64 / rate;
    let (omega, first) = (per_scan * rate, range.start);
    Ok(Sweep {
        name: run.name.clone(),
        freedom,
        sine,
        omega,
        length_s,
        first,
        onset_s,
        sensors,
        jacks,
        group,
    })
}

fn group_mean(scans: &[[f64; CHANNELS]]) -> [f64; JACKS] {
    core::array::from_fn(|jack| {
        scans.iter().map(|scan| scan[INERTIAL + jack]).sum::<f64>() / scans.len() as f64
    })
}
