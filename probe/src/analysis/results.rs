//! The results of a campaign with their uncertainties, and the coefficient set made of them.

use hexsense_core::calibration::budget::{Budget, Cause, Distribution};
use hexsense_core::channel::{INERTIAL, NAMES, Triad};
use hexsense_core::records::TriadCoefficients;
use serde::{Deserialize, Serialize};

use super::assumptions::Assumptions;
use super::budgets::Budgets;
use super::campaign::CondensedCampaign;
use super::check::{Check, Verdict};
use super::estimate::{Condensed, Estimate};
use super::lever_arm::{SecondHarmonic, second_harmonics, warnings};
use super::settling::Settling;
use super::{AnalysisError, RecordedRun};
use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// A number with its expanded uncertainty, coverage factor 2.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The estimate.
    pub estimate: f64,
    /// Its expanded uncertainty, in the same unit.
    pub expanded_uncertainty: f64,
    /// Half width of the interval that holds the true value with 95 % probability.
    pub interval_95: f64,
}

/// One term of a budget.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Term {
    /// Name of the cause.
    pub cause: String,
    /// Standard uncertainty that it gives to the gain, relative.
    pub gain_relative: f64,
    /// Standard uncertainty that it gives to the offset, counts.
    pub offset_counts: f64,
}

/// One channel's results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChannelResult {
    /// Name of the channel.
    pub name: String,
    /// Unit of its values.
    pub unit: String,
    /// u0: counts at zero input.
    pub offset: Measured,
    /// M_ii, unit per count.
    pub gain: Measured,
    /// The channel's row of M, unit per count, each with its uncertainty.
    pub cross: [Measured; 3],
    /// S = 1/M_ii, counts per unit.
    pub sensitivity: f64,
    /// Terms of the uncertainty, the largest for the gain first.
    pub budget: Vec<Term>,
    /// White noise, unit/√Hz, as seen in the rests before the movements.
    pub noise_density: f64,
    /// Standard uncertainty of the value at rest at home, unit, right after the calibration.
    pub rest_uncertainty: f64,
    /// Random walk of the bias by the data sheet, unit/√s.
    pub bias_walk: f64,
}

/// The results of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// The nine channels.
    pub channels: Vec<ChannelResult>,
    /// Delay of each triad behind the jacks, s: the mean of its three sensors.
    pub delays_s: [Measured; 3],
    /// Gravity that everything was computed with, m/s².
    pub gravity_m_s2: Measured,
    /// Place of the sensor block from O in body axes, m, as the accelerometers feel it.
    pub lever_arm_m: [Measured; 3],
    /// The lever arm checked by the second harmonic in the angular sine runs.
    pub second_harmonics: Vec<SecondHarmonic>,
    /// What does not fit together and what to do; empty when all is well.
    pub warnings: Vec<String>,
    /// Scans evaluated.
    pub scans: u64,
    /// Whether the bench is what its files say; results of versions before 0.3 hold no checks.
    #[serde(default)]
    pub checks: Vec<Check>,
}

impl Results {
    /// Accepts the failure of the check of this name, for a reason; a check that does not fail stays as it is.
    pub fn accept(&mut self, check: &str, reason: &str) {
        let of_name = |known: &&mut Check| known.name == check && known.verdict == Verdict::Fail;
        for check in self.checks.iter_mut().filter(of_name) {
            check.accepted = Some(reason.to_owned());
        }
    }
}

/// Everything that an analysis finds.
#[derive(Debug, Clone)]
pub struct Analysis {
    /// Condensed runs.
    pub condensed: Condensed,
    /// Estimate under what the files say.
    pub estimate: Estimate,
    /// Results with uncertainties.
    pub results: Results,
    /// The triads as the board stores them.
    pub triads: [TriadCoefficients; 3],
}

/// Evaluates a campaign.
///
/// # Errors
/// Every variant of [`AnalysisError`].
pub fn analyse(
    base: &GeometryFile,
    sensors: &SensorFile,
    runs: &[RecordedRun],
) -> Result<Analysis, AnalysisError> {
    let CondensedCampaign { condensed, later } = CondensedCampaign::new(base, sensors, runs)?;
    let assumptions = Assumptions::new(base, sensors);
    let estimate = condensed.estimate(&assumptions)?;
    let mut budgets = Budgets::new(&condensed, &assumptions, &estimate, base, sensors)?;
    let settling = Settling::new(&condensed, &estimate, &later, &assumptions)?;
    budgets.add_settling(&settling, &estimate);
    let channels = (0..INERTIAL)
        .map(|channel| channel_result(channel, &condensed, &estimate, &budgets, sensors));
    let second_harmonics = second_harmonics(&condensed, &estimate, &assumptions)?;
    let found = core::array::from_fn(|axis| {
        let standard = budgets.lever_arm[axis].combined();
        (estimate.lever_arm_m[axis], standard)
    });
    let (stated, tolerance) = (&sensors.lever_arm_m, sensors.lever_arm_tolerance_m);
    let warnings = warnings(&second_harmonics, stated, tolerance, &found);
    let results = Results {
        channels: channels.collect(),
        delays_s: core::array::from_fn(|triad| {
            measured(estimate.fits[triad].delay_s, &budgets.delay[triad])
        }),
        gravity_m_s2: {
            let mut budget = Budget::default();
            let standard = sensors.gravity.uncertainty_m_s2;
            budget.add(Cause::Gravity, Distribution::Normal, standard);
            measured(sensors.gravity.m_s2, &budget)
        },
        lever_arm_m: core::array::from_fn(|axis| {
            measured(estimate.lever_arm_m[axis], &budgets.lever_arm[axis])
        }),
        second_harmonics,
        warnings,
        scans: runs.iter().map(|run| run.capture.scans.len() as u64).sum(),
        checks: Vec::new(),
    };
    let triads = Triad::ALL.map(|triad| stored(triad, &estimate, &budgets));
    Ok(Analysis {
        condensed,
        estimate,
        results,
        triads,
    })
}

fn measured(estimate: f64, budget: &Budget) -> Measured {
    Measured {
        estimate,
        expanded_uncertainty: budget.expanded(),
        interval_95: budget.interval_95(),
    }
}

fn channel_result(
    channel: usize,
    condensed: &Condensed,
    estimate: &Estimate,
    budgets: &Budgets,
    sensors: &SensorFile,
) -> ChannelResult {
    let (triad, axis) = (Triad::ALL[channel / 3], channel % 3);
    let index = triad.index();
    let matrix = &estimate.fits[index].matrix;
    let gain = matrix[(axis, axis)];
    let (gain_budget, offset_budget) = (
        &budgets.matrix[index][axis][axis],
        &budgets.offset[index][axis],
    );
    let mut terms: Vec<Term> = Cause::ALL
        .iter()
        .map(|cause| Term {
            cause: cause.name().to_owned(),
            gain_relative: gain_budget.term(*cause) / gain.abs(),
            offset_counts: offset_budget.term(*cause),
        })
        .filter(|term| term.gain_relative > 0.0 || term.offset_counts > 0.0)
        .collect();
    terms.sort_by(|a, b| b.gain_relative.total_cmp(&a.gain_relative));
    ChannelResult {
        name: NAMES[channel].to_owned(),
        unit: triad.unit().to_owned(),
        offset: measured(estimate.offsets[index][axis], offset_budget),
        gain: measured(gain, gain_budget),
        cross: core::array::from_fn(|column| {
            measured(matrix[(axis, column)], &budgets.matrix[index][axis][column])
        }),
        sensitivity: 1.0 / gain,
        budget: terms,
        noise_density: condensed.noise[index].density[axis] * gain.abs(),
        rest_uncertainty: budgets.rest[index][axis].combined(),
        bias_walk: sensors.triad(triad).bias_walk_5min / 300f64.sqrt(),
    }
}

fn stored(triad: Triad, estimate: &Estimate, budgets: &Budgets) -> TriadCoefficients {
    let index = triad.index();
    let fit = &estimate.fits[index];
    TriadCoefficients {
        offset: core::array::from_fn(|axis| estimate.offsets[index][axis] as f32),
        matrix: core::array::from_fn(|row| {
            core::array::from_fn(|column| fit.matrix[(row, column)] as f32)
        }),
        offset_uncertainty: core::array::from_fn(|axis| {
            budgets.offset[index][axis].combined() as f32
        }),
        matrix_uncertainty: core::array::from_fn(|row| {
            core::array::from_fn(|column| budgets.matrix[index][row][column].combined() as f32)
        }),
        delay_s: fit.delay_s as f32,
    }
}
