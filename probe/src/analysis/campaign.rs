//! The runs of a campaign, sorted by what they are for and condensed.

use hexsense_core::calibration::triad::Noise;
use hexsense_core::calibration::zero::{ZeroLimits, zero};
use hexsense_core::channel::{INERTIAL, NAMES, Triad};
use hexsense_core::excitation::{DegreeOfFreedom, Signal};

use super::condense::{Counts, HoldRun, Part, Sweep, before};
use super::estimate::Condensed;
use super::noise::Scatter;
use super::{AnalysisError, RecordedRun};
use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// The condensed runs of a campaign, and the later parts of them, for which base and sensors had more time to settle.
#[derive(Debug, Clone)]
pub struct CondensedCampaign {
    /// Everything.
    pub condensed: Condensed,
    /// The second half of each hold, and each sine run without the first third of its periods.
    pub later: Condensed,
}

impl CondensedCampaign {
    /// Condenses `runs`; runs that the method does not use are passed over.
    ///
    /// # Errors
    /// Every variant of [`AnalysisError`] that speaks of runs, the zero run or sines.
    pub fn new(
        base: &GeometryFile,
        sensors: &SensorFile,
        runs: &[RecordedRun],
    ) -> Result<Self, AnalysisError> {
        let zero_run = runs
            .iter()
            .find(|run| run.program.signals.is_empty())
            .ok_or(AnalysisError::MissingRun { run: "zero" })?;
        let counts = Counts::new(zero_run)?;
        check_zero(&counts, sensors, base)?;
        let rate_hz = zero_run.rate_hz;
        let whole = (0.0, counts.len() as f64 / f64::from(rate_hz));
        let zero = counts.rest(whole.0, whole.1)?;
        let mut moved = Moved::default();
        counts.add_scatter(whole, &mut moved.scatters)?;
        for run in runs {
            moved.add(run, base)?;
        }
        let noise = Triad::ALL.map(|triad| noise(triad, &moved.scatters, sensors));
        let condensed = |Moves { hold_runs, sweeps }| -> Result<Condensed, AnalysisError> {
            let (heave, turns) = sorted(sweeps)?;
            Ok(Condensed {
                rate_hz,
                zero: zero.clone(),
                hold_runs: two(hold_runs)?,
                heave,
                turns,
                noise,
            })
        };
        let [whole, later] = moved.parts;
        Ok(Self {
            condensed: condensed(whole)?,
            later: condensed(later)?,
        })
    }
}

/// What was found in the runs that move.
#[derive(Default)]
struct Moved {
    /// All of it, and later.
    parts: [Moves; 2],
    /// Of the sensors in the rests.
    scatters: [Scatter; INERTIAL],
}

#[derive(Default)]
struct Moves {
    hold_runs: Vec<HoldRun>,
    sweeps: Vec<Sweep>,
}

impl Moved {
    fn add(&mut self, run: &RecordedRun, base: &GeometryFile) -> Result<(), AnalysisError> {
        let signal = match run.program.signals.as_slice() {
            [signal @ (_, Signal::Ramps(_) | Signal::Sine(_))] => signal,
            _ => return Ok(()),
        };
        let counts = Counts::new(run)?;
        let onset_s = counts.onset_s(&base.geometry)?;
        if let Some(rest) = before(onset_s) {
            counts.add_scatter(rest, &mut self.scatters)?;
        }
        let [whole, later] = &mut self.parts;
        if let (freedom, Signal::Sine(sine)) = signal {
            let sweep = Sweep::new(&counts, onset_s, *freedom, *sine, &base.geometry)?;
            later.sweeps.push(sweep.later(&counts)?);
            whole.sweeps.push(sweep);
        } else {
            let holds = |part| HoldRun::new(&counts, onset_s, part);
            whole.hold_runs.push(holds(Part::Whole)?);
            later.hold_runs.push(holds(Part::Later)?);
        }
        Ok(())
    }
}

fn two(hold_runs: Vec<HoldRun>) -> Result<Vec<HoldRun>, AnalysisError> {
    match hold_runs.len() {
        2 => Ok(hold_runs),
        _ => Err(AnalysisError::MissingRun {
            run: "pitch or roll ramp-and-hold",
        }),
    }
}

/// The heave run and the others.
fn sorted(mut sweeps: Vec<Sweep>) -> Result<(Sweep, Vec<Sweep>), AnalysisError> {
    let heave = sweeps
        .iter()
        .position(|sweep| sweep.freedom == DegreeOfFreedom::Heave)
        .ok_or(AnalysisError::MissingRun { run: "heave sine" })?;
    Ok((sweeps.remove(heave), sweeps))
}

/// Refuses a zero run in which a channel scattered or drifted five times more than its data sheet's noise and
/// wandering explain.
fn check_zero(
    counts: &Counts,
    sensors: &SensorFile,
    base: &GeometryFile,
) -> Result<(), AnalysisError> {
    let stroke_m = base.geometry.length_max_m() - base.geometry.length_min_m();
    let per_metre = sensors.jacks.full_stroke_volts.abs() / stroke_m * sensors.counts_per_volt();
    for (channel, name) in NAMES.into_iter().enumerate() {
        let limit = if channel < INERTIAL {
            let sheet = sensors.triad(Triad::ALL[channel / 3]);
            let per_unit = sheet.volts_per_unit.abs() * sensors.counts_per_volt();
            5.0 * (sheet.noise_density + sheet.bias_walk_5min / 5.0) * per_unit
        } else {
            5.0 * sensors.jacks.noise_rms_m * per_metre
        };
        let limits = ZeroLimits {
            deviation: limit,
            drift: 2.0 * limit,
        };
        zero(&counts.channel(channel), limits).map_err(|source| AnalysisError::Zero {
            channel: name,
            source,
        })?;
    }
    Ok(())
}

/// White noise from the rests and wandering by the data sheet, in counts.
fn noise(triad: Triad, scatters: &[Scatter; INERTIAL], sensors: &SensorFile) -> Noise {
    let sheet = sensors.triad(triad);
    let walk = sheet.bias_walk_5min / 300f64.sqrt()
        * sheet.volts_per_unit.abs()
        * sensors.counts_per_volt();
    let scatters = &scatters[triad.first_channel()..];
    Noise {
        // A dead channel has no noise at all; a thousandth of a count keeps its weight finite.
        density: core::array::from_fn(|axis| scatters[axis].density().max(1e-3)),
        walk: [walk; 3],
    }
}
