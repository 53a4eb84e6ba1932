//! What the planned movement can determine, and how well, before anything moves.
//!
//! The plan is recorded on an [ideal bench](super::ideal), and the analysis of real captures is run on that: the same
//! fits, the same perturbations of hinges, jacks, converter, clock and lever arm, the data sheet's noise and wandering.
//! What comes out is the budget that the campaign will have if base and sensors are as good as their files promise.
//!
//! The forecast also says what no file promises: how far a gain moves when the base tilts [`TILT_ERROR_DEG`] further on
//! the holds than its jacks say. A sensor that sees sin ϑ then errs by δ/tan ϑ, but one that sees 1 − cos ϑ, as ay does
//! without a heave sine, by δ/tan(ϑ/2), twice as much.

use core::f64::consts::TAU;

use hexsense_core::calibration::budget::{Budget, Cause};
use hexsense_core::calibration::triad::Noise;
use hexsense_core::channel::{INERTIAL, JACKS, NAMES, Triad};
use hexsense_core::excitation::{DegreeOfFreedom, Program, Signal, Sine};
use hexsense_core::harmonics::Harmonics;

use super::ideal::{Clipped, Ideal, RATE_HZ};
use super::needs::{self, sine_of};
use super::{Plan, Purpose, Run};
use crate::analysis::AnalysisError;
use crate::analysis::assumptions::Assumptions;
use crate::analysis::budgets::Budgets;
use crate::analysis::condense::{Counts, HoldRun, RestMeans, Sweep, hold_run, sweep};
use crate::analysis::estimate::{Condensed, Estimate};
use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// The error of tilt on the holds, unknown to every file, that gains are tried with, degrees.
pub const TILT_ERROR_DEG: f64 = 0.1;
/// A gain is ill-determined beyond this, relative: a third of the 3 % that `hexsense verify` allows in all.
pub const ILL_DETERMINED: f64 = 0.01;

/// What a plan determines.
#[derive(Debug, Clone, PartialEq)]
pub struct Forecast {
    /// The nine gains in the order of the channels; none when runs are missing without which nothing is computed.
    pub gains: Vec<Gain>,
    /// What to do about the plan, in plain words; empty when all is well.
    pub advice: Vec<String>,
}

/// How well one gain will be known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Name of the channel.
    pub channel: &'static str,
    /// Expanded uncertainty (coverage factor 2), relative to the gain.
    pub uncertainty: f64,
    /// The cause that contributes most.
    pub cause: Cause,
    /// What it contributes, expanded and relative.
    pub contribution: f64,
    /// Change of the gain when the base tilts [`TILT_ERROR_DEG`] further on the holds than the jacks say, relative.
    pub tilt_change: f64,
}

/// The analysis will fail on a movement like this one. Nothing was measured: causes lie in the files.
#[derive(Debug, thiserror::Error)]
pub enum ForecastError {
    /// A signal that leaves the range of the converter.
    #[error(transparent)]
    Clipped(#[from] Clipped),
    /// A sine that cannot be fitted.
    #[error(
        "run {run}: by the files, {channel} shows no sine of {frequency_hz} Hz that could be fitted; make the sine of \
         this run larger or its estimate_s longer"
    )]
    NoSine {
        /// The run.
        run: String,
        /// The channel.
        channel: &'static str,
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// Anything else.
    #[error("the planned movement could not be analysed: {0}")]
    Analysis(AnalysisError),
}

impl From<AnalysisError> for ForecastError {
    fn from(error: AnalysisError) -> Self {
        match error {
            AnalysisError::NoSine {
                run,
                channel,
                frequency_hz,
            } => Self::NoSine {
                run,
                channel,
                frequency_hz,
            },
            error => Self::Analysis(error),
        }
    }
}

/// Predicts what `plan` determines on this base with these sensors.
///
/// # Errors
/// [`ForecastError`] when the analysis refuses even ideal recordings of the plan.
pub fn forecast(
    plan: &Plan,
    base: &GeometryFile,
    sensors: &SensorFile,
) -> Result<Forecast, ForecastError> {
    let runs: Vec<&Run> = plan.runs_to(Purpose::Calibrate).collect();
    let missing = needs::missing(&runs);
    if !missing.is_empty() {
        return Ok(Forecast {
            gains: Vec::new(),
            advice: missing,
        });
    }
    let ideal = Ideal { base, sensors };
    let condensed = condense(&runs, ideal, 0.0)?;
    let assumptions = Assumptions::new(base, sensors);
    let estimate = condensed.estimate(&assumptions)?;
    let budgets = Budgets::new(&condensed, &assumptions, &estimate, base, sensors)?;
    let tilted = condense(&runs, ideal, TILT_ERROR_DEG.to_radians())?.estimate(&assumptions)?;
    let gains: Vec<Gain> = (0..INERTIAL)
        .map(|channel| gain(channel, &estimate, &tilted, &budgets))
        .collect();
    let heaves = runs.iter().any(|run| sine_of(run, DegreeOfFreedom::Heave));
    let advice = gains
        .iter()
        .filter_map(|gain| advice(gain, heaves))
        .collect();
    Ok(Forecast { gains, advice })
}

/// Reduces an ideal recording of all runs, in order; on holds the base tilts `tilt_error_rad` further than its jacks.
fn condense(runs: &[&Run], ideal: Ideal, tilt_error_rad: f64) -> Result<Condensed, ForecastError> {
    let geometry = &ideal.base.geometry;
    let (mut zero, mut hold_runs, mut heave, mut turns) = (None, Vec::new(), None, Vec::new());
    let mut first = 0;
    for run in runs {
        let program = run.program();
        let felt = tilted_further(&program, tilt_error_rad);
        let recorded = ideal.record(&run.name, program, &felt, run.rest_s, first)?;
        first += recorded.capture.scans.len() as u64;
        match recorded.program.signals.as_slice() {
            [] if zero.is_none() => {
                zero = Some(Counts::new(&recorded)?.rest(0.0, run.duration_s())?);
            }
            [(_, Signal::Ramps(_))] => hold_runs.push(hold_run(&recorded, geometry)?),
            [(freedom, Signal::Sine(sine))] if sine.amplitude > 0.0 => {
                let reduced = sweep(&recorded, *freedom, *sine, geometry)?;
                if *freedom == DegreeOfFreedom::Heave {
                    heave = Some(reduced);
                } else {
                    turns.push(reduced);
                }
            }
            _ => {}
        }
    }
    let zero = zero.ok_or(AnalysisError::MissingRun { run: "zero" })?;
    Ok(Condensed {
        rate_hz: RATE_HZ,
        heave: heave.unwrap_or_else(|| no_heave(&zero)),
        zero,
        hold_runs: two(hold_runs)?,
        turns,
        noise: Triad::ALL.map(|triad| noise(triad, ideal.sensors)),
    })
}

/// The analysis takes one run with holds in pitch and one in roll.
fn two(hold_runs: Vec<HoldRun>) -> Result<Vec<HoldRun>, AnalysisError> {
    match hold_runs.len() {
        2 => Ok(hold_runs),
        _ => Err(AnalysisError::MissingRun {
            run: "single pair of ramp-and-hold",
        }),
    }
}

/// The program with its ramps' largest level `error_rad` further from zero, the others in proportion.
fn tilted_further(program: &Program, error_rad: f64) -> Program {
    let mut program = program.clone();
    for (_, signal) in &mut program.signals {
        if let Signal::Ramps(ramps) = signal {
            let sizes = ramps.levels.iter().map(|level| level.abs());
            let largest = sizes.fold(0.0, f64::max);
            let factor = if largest > 0.0 {
                1.0 + error_rad / largest
            } else {
                1.0
            };
            ramps.levels.iter_mut().for_each(|level| *level *= factor);
        }
    }
    program
}

/// A heave run in which nothing moves: it holds no information, and the estimate then rests on gravity alone.
fn no_heave(zero: &RestMeans) -> Sweep {
    const HZ: f64 = 0.5;
    const PERIODS: f64 = 3.0;
    let group = 4;
    let jacks: [f64; JACKS] = core::array::from_fn(|jack| zero.counts[INERTIAL + jack]);
    Sweep {
        name: "heave".to_owned(),
        freedom: DegreeOfFreedom::Heave,
        // Without a frequency the sensors' bandwidth adds no uncertainty.
        sine: Sine {
            frequency_hz: 0.0,
            ..Sine::of_periods(0.0, HZ, 2, 3)
        },
        rate_hz: RATE_HZ,
        omega: TAU * HZ,
        length_s: PERIODS / HZ,
        first: 0,
        onset_s: 0.0,
        sensors: [const { Harmonics::NONE }; INERTIAL],
        jacks: vec![jacks; (PERIODS / HZ * f64::from(RATE_HZ)) as usize / group],
        group,
    }
}

/// Noise and wandering by the data sheet, in counts.
fn noise(triad: Triad, sensors: &SensorFile) -> Noise {
    let sheet = sensors.triad(triad);
    let per_unit = sheet.volts_per_unit.abs() * sensors.counts_per_volt();
    // A sheet without noise still leaves a weight finite.
    Noise {
        density: [(sheet.noise_density * per_unit).max(1e-3); 3],
        walk: [sheet.bias_walk_5min / 300f64.sqrt() * per_unit; 3],
    }
}

fn gain(channel: usize, estimate: &Estimate, tilted: &Estimate, budgets: &Budgets) -> Gain {
    let (triad, axis) = (channel / 3, channel % 3);
    let value = |estimate: &Estimate| estimate.fits[triad].matrix[(axis, axis)];
    let budget: &Budget = &budgets.matrix[triad][axis][axis];
    let size = value(estimate).abs();
    let cause = Cause::ALL
        .into_iter()
        .max_by(|a, b| budget.term(*a).total_cmp(&budget.term(*b)))
        .unwrap_or(Cause::SensorNoise);
    Gain {
        channel: NAMES[channel],
        uncertainty: budget.expanded() / size,
        cause,
        contribution: 2.0 * budget.term(cause) / size,
        tilt_change: (value(tilted) - value(estimate)) / size,
    }
}

/// What to do about one gain.
fn advice(gain: &Gain, heaves: bool) -> Option<String> {
    let remedy = match gain.channel {
        "ax" => "tilt further in pitch",
        "ay" if heaves => "make the heave sine larger, faster or longer",
        "ay" => "add a heave sine",
        "az" => "tilt further in roll",
        "ex" | "wx" => "make the roll sine larger, faster or longer",
        "ey" | "wy" => "make the yaw sine larger, faster or longer",
        _ => "make the pitch sine larger, faster or longer",
    };
    let sensitive = gain.tilt_change.abs() > ILL_DETERMINED;
    let channel = gain.channel;
    if sensitive || (channel == "ay" && !heaves) {
        let change = 100.0 * gain.tilt_change.abs();
        return Some(format!(
            "{channel} is ill-determined: {change:.1} % per {TILT_ERROR_DEG}° of pitch and roll error; {remedy}"
        ));
    }
    (gain.uncertainty > ILL_DETERMINED).then(|| {
        let (percent, most) = (100.0 * gain.uncertainty, 100.0 * gain.contribution);
        let cause = gain.cause.name();
        format!(
            "{channel} is ill-determined: ± {percent:.1} %, {cause} alone ± {most:.1} %; {remedy}"
        )
    })
}

#[cfg(test)]
mod advice;
#[cfg(test)]
mod tests;
