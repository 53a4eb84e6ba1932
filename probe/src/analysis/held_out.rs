//! Calibrated values against a reference on a movement that nothing was fitted to.
//!
//! Both pass the same zero-phase low-pass, so that the movement is compared and not its vibration. The delay of the
//! triad is taken out of the values. Then the means are compared on their own and the rest as rms.
//!
//! The reference of `hexsense verify` is the differentiated pose of the base ([`super::reference`]). A caller that knows
//! a better one, such as the truth of the twin, uses the same [`compare`].

use hexsense_core::channel::{INERTIAL, JACKS, Triad};
use serde::{Deserialize, Serialize};

use super::condense::Counts;
use super::filter::zero_phase_low_pass;
use super::reference::reference;
pub use super::reference::{CORNER_HZ, RATE_HZ, Signals};
use super::results::Results;
use super::{AnalysisError, RecordedRun};
use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// Coverage factor of the mean's limit: nine channels are judged at once, so 99.7 % each.
pub const MEAN_COVERAGE: f64 = 3.0;
/// Left out at both ends, where the low-pass does not know what came before, s.
const ENDS_S: f64 = 1.5;

/// How one channel did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChannelVerdict {
    /// Name of the channel.
    pub name: String,
    /// Unit of everything below.
    pub unit: String,
    /// Root mean square of the reference about its mean.
    pub rms_signal: f64,
    /// The same of the error with data-sheet sensitivity and offset.
    pub rms_error_before: f64,
    /// The same of the error with the stored coefficients.
    pub rms_error_after: f64,
    /// Mean error with the stored coefficients.
    pub mean_error: f64,
    /// Its expanded uncertainty, coverage factor [`MEAN_COVERAGE`].
    pub mean_uncertainty: f64,
}

impl ChannelVerdict {
    /// Whether the error is at most 3 % of the signal and its mean within its uncertainty.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.rms_error_after <= 0.03 * self.rms_signal
            && self.mean_error.abs() <= self.mean_uncertainty
    }
}

/// Compares `after` and `before` (values by stored coefficients and by data sheet) with `reference`; all have the
/// same length. `elapsed_s` is the time since the zero run.
#[must_use]
pub fn compare(
    reference: &Signals,
    after: &Signals,
    before: &Signals,
    results: &Results,
    elapsed_s: f64,
) -> Vec<ChannelVerdict> {
    let smooth = |values: &[f64]| zero_phase_low_pass(values, CORNER_HZ, RATE_HZ);
    let ends = (ENDS_S * RATE_HZ) as usize;
    let error_of = |channel: usize, values: &Signals| -> Vec<f64> {
        let difference: Vec<f64> = values[channel]
            .iter()
            .zip(&reference[channel])
            .map(|(value, truth)| value - truth)
            .collect();
        inner(&smooth(&difference), ends)
    };
    let verdict = |(channel, result): (usize, &super::results::ChannelResult)| {
        let (_, rms_signal) = moments(&inner(&smooth(&reference[channel]), ends));
        let (mean_error, rms_error_after) = moments(&error_of(channel, after));
        let (_, rms_error_before) = moments(&error_of(channel, before));
        let length_s = after[channel].len() as f64 / RATE_HZ;
        let white = result.noise_density / (2.0 * length_s).sqrt();
        let walk = result.bias_walk * elapsed_s.max(0.0).sqrt();
        let standard = result.rest_uncertainty.hypot(white).hypot(walk);
        ChannelVerdict {
            name: result.name.clone(),
            unit: result.unit.clone(),
            rms_signal,
            rms_error_before,
            rms_error_after,
            mean_error,
            mean_uncertainty: MEAN_COVERAGE * standard,
        }
    };
    results.channels.iter().enumerate().map(verdict).collect()
}

fn inner(values: &[f64], ends: usize) -> Vec<f64> {
    values
        .get(ends..values.len().saturating_sub(ends))
        .unwrap_or_default()
        .to_vec()
}

/// Mean, and root mean square about it.
fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values
        .iter()
        .map(|value| (value - mean).powi(2))
        .sum::<f64>()
        / count;
    (mean, square.sqrt())
}

/// A held-out run in values at [`RATE_HZ`].
#[derive(Debug, Clone)]
pub struct HeldOut {
    /// Values by the board, delays taken out.
    pub after: Signals,
    /// Values by the data sheet, delays taken out alike.
    pub before: Signals,
    /// Values that follow from the pose by the jacks.
    pub reference: Signals,
    /// Mean counts of the jacks at nominal supply, one row for each value.
    pub jacks: Vec<[f64; JACKS]>,
    /// Place in the capture, in scans from its start, that the first value stands for.
    pub first: f64,
    /// Scans from one value to the next.
    pub group: usize,
}

/// Reduces a held-out capture with board-made values to values and reference.
///
/// # Errors
/// Every variant of [`AnalysisError`] that concerns a single run; `MissingRun` when the capture holds no values.
pub fn held_out(
    base: &GeometryFile,
    sensors: &SensorFile,
    run: &RecordedRun,
    results: &Results,
) -> Result<HeldOut, AnalysisError> {
    let counts = Counts::new(run)?;
    let values = run
        .capture
        .values
        .as_ref()
        .ok_or(AnalysisError::MissingRun {
            run: "held-out with values",
        })?;
    let group = (f64::from(run.rate_hz) / RATE_HZ).round() as usize;
    let scans = movement(run, &counts, base, group)?;
    let mean = |values: &[f64]| -> Vec<f64> {
        let groups = values[scans.clone()].chunks_exact(group);
        groups
            .map(|group| group.iter().sum::<f64>() / group.len() as f64)
            .collect()
    };
    let undelayed = |channel: usize, values: Vec<f64>| {
        let delay_s = results.delays_s[channel / 3].estimate + sensors.board.instant_s(channel)
            - sensors.board.instant_s(INERTIAL);
        advance(&mean(&values), delay_s * RATE_HZ)
    };
    let after = core::array::from_fn(|channel| {
        let channel_values = values.iter().map(|values| f64::from(values[channel]));
        undelayed(channel, channel_values.collect())
    });
    let before = core::array::from_fn(|channel| {
        let sheet = sensors.triad(Triad::ALL[channel / 3]);
        let (per_unit, zero) = sheet.nominal_counts(sensors.counts_per_volt());
        let values = counts
            .channel(channel)
            .into_iter()
            .map(|count| (count - zero) / per_unit);
        undelayed(channel, values.collect())
    });
    let columns: [Vec<f64>; JACKS] =
        core::array::from_fn(|jack| mean(&counts.channel(INERTIAL + jack)));
    let rows = (0..columns[0].len()).map(|index| columns.each_ref().map(|column| column[index]));
    let jacks: Vec<[f64; JACKS]> = rows.collect();
    let reference = reference(base, sensors, run, results, &jacks)?;
    let first = scans.start as f64 + (group as f64 - 1.0) / 2.0;
    Ok(HeldOut {
        after,
        before,
        reference,
        jacks,
        first,
        group,
    })
}

/// The scans of the movement, in whole groups, with what the low-pass needs at both ends.
fn movement(
    run: &RecordedRun,
    counts: &Counts,
    base: &GeometryFile,
    group: usize,
) -> Result<core::ops::Range<usize>, AnalysisError> {
    let rate = f64::from(run.rate_hz);
    let onset_s = counts.onset_s(&base.geometry)?;
    let start = ((onset_s - ENDS_S).max(0.0) * rate) as usize;
    let end = ((onset_s + run.program.duration_s() + ENDS_S) * rate) as usize;
    let end = end.min(counts.len());
    Ok(start..start + (end - start) / group * group)
}

/// Shifts a series to earlier times by a fraction of a sample or more, by linear interpolation; the end is held.
fn advance(values: &[f64], samples: f64) -> Vec<f64> {
    let at = |index: f64| {
        let index = index.clamp(0.0, (values.len() - 1) as f64);
        let (low, fraction) = (index.floor() as usize, index.fract());
        values[low] + fraction * (values[(low + 1).min(values.len() - 1)] - values[low])
    };
    (0..values.len())
        .map(|index| at(index as f64 + samples))
        .collect()
}

/// Names of the channels that do not pass.
#[must_use]
pub fn failures(verdicts: &[ChannelVerdict]) -> Vec<&str> {
    let failed = verdicts.iter().filter(|verdict| !verdict.passes());
    failed.map(|verdict| verdict.name.as_str()).collect()
}

#[cfg(test)]
mod tests;
