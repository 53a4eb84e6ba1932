//! The sensors at rest: each answers to movement, none is noisier than its data sheet, and no zero wanders too far.
//!
//! With the change Δ of a sensor's mean since the zero run, t seconds earlier,
//!
//! ```text
//! statistic = |Δ| / √(w²·t/300 s + d²/2T + (g·δ)² + s²)        limit = 6
//! ```
//!
//! where w is the walk of the data sheet in five minutes, d the noise density in the zero run or of the data sheet, the
//! larger one, T the shorter rest, g·δ what the accelerometers feel of a base that stands as unevenly as
//! [`super::home`] lets it, and s a step of the converter, which may calibrate itself differently at the next power-up.

use hexsense_core::calibration::budget::uniform;
use hexsense_core::channel::{INERTIAL, NAMES, Triad};

use super::movements::Movements;
use super::rests::{Rest, Zero, deviation, runs_beyond};
use crate::analysis::assumptions::COUNTS_PER_CODE;
use crate::analysis::check::{Check, Figure, judge};
use crate::sensor_file::SensorFile;

/// Largest change of a sensor's zero, in standard deviations.
const DEVIATIONS: f64 = 6.0;
/// Largest noise over that of the data sheet, which is a typical value.
const NOISE_LIMIT: f64 = 3.0;
/// Scatter of the converter, counts: its noise and the rounding to codes of sixteen counts.
const CONVERTER_COUNTS: f64 = 10.0;
/// Largest scatter at rest over that in movement of a sensor that answers.
const ANSWERS: f64 = 0.5;
/// Length of the arm that a tilted base turns, m: half the distance of the hinges of a small base.
const TILT_ARM_M: f64 = 0.5;

/// Whether each sensor moves more in some run than at rest.
pub(super) fn answers(zero: Option<&Zero>, movements: &Movements) -> Check {
    let moving = || {
        movements
            .runs
            .iter()
            .filter(|movement| !movement.program.is_empty())
    };
    let zero = zero.filter(|_| moving().next().is_some());
    let figures = zero.into_iter().flat_map(|zero| {
        (0..INERTIAL).map(move |channel| {
            let most = moving()
                .map(|movement| deviation(movement, channel))
                .fold(f64::MIN_POSITIVE, f64::max);
            Figure {
                name: NAMES[channel].to_owned(),
                // One count: a signal that stands still has no scatter at rest either.
                value: zero.deviation[channel].max(1.0) / most,
                limit: ANSWERS,
            }
        })
    });
    judge(
        "sensors answer",
        "scatter at rest over that in movement",
        figures.collect(),
        "each sensor moves with the base",
        |names| {
            format!(
                "{} does not answer to the movement: is it connected and supplied?",
                names.join(", ")
            )
        },
    )
}

/// The noise of each sensor in the zero run beside its data sheet.
pub(super) fn noise(zero: Option<&Zero>, sensors: &SensorFile) -> Check {
    let figures = zero.into_iter().flat_map(|zero| {
        (0..INERTIAL).map(move |channel| {
            let sheet = sensors.triad(Triad::ALL[channel / 3]);
            let promised =
                sheet.noise_density * sheet.volts_per_unit.abs() * sensors.counts_per_volt();
            let converter = CONVERTER_COUNTS * (2.0 / zero.rate_hz).sqrt();
            Figure {
                name: NAMES[channel].to_owned(),
                value: zero.density[channel] / promised.hypot(converter),
                limit: NOISE_LIMIT,
            }
        })
    });
    judge(
        "sensor noise",
        "of the data sheet",
        figures.collect(),
        "no sensor is noisier than its data sheet",
        |names| {
            format!(
                "{} is noisier than its data sheet: look for a loose plug, a broken screen or a motor beside the cable",
                names.join(", ")
            )
        },
    )
}

/// Whether the zero of each sensor stays where it was in the zero run.
pub(super) fn zeros(
    zero: Option<&Zero>,
    rests: &[Rest],
    sensors: &SensorFile,
    limit_m: f64,
) -> Check {
    let pairs = rests.iter().filter_map(|rest| Some((rest, zero?)));
    let figures: Vec<(Figure, &str)> = pairs
        .flat_map(|(rest, zero)| {
            (0..INERTIAL).map(move |channel| {
                let figure = Figure {
                    name: NAMES[channel].to_owned(),
                    value: change(channel, rest, zero, sensors, limit_m),
                    limit: DEVIATIONS,
                };
                (figure, rest.run)
            })
        })
        .collect();
    let runs = runs_beyond(&figures);
    judge(
        "zero of the sensors",
        "standard deviations",
        figures.into_iter().map(|(figure, _)| figure).collect(),
        "no zero wandered farther than its data sheet says",
        |names| {
            format!(
                "the zero of {} changed by run {runs}, more than its data sheet allows: let the sensors warm up, see whether \
                 they are fixed, and record the campaign again",
                names.join(", ")
            )
        },
    )
}

/// Change of a sensor's mean since the zero run, in standard deviations.
fn change(channel: usize, rest: &Rest, zero: &Zero, sensors: &SensorFile, limit_m: f64) -> f64 {
    let Zero {
        rest: zero,
        density,
        ..
    } = zero;
    let triad = Triad::ALL[channel / 3];
    let sheet = sensors.triad(triad);
    let counts_per_unit = sheet.volts_per_unit.abs() * sensors.counts_per_volt();
    let change = (rest.sensors[channel] - zero.sensors[channel]).abs() / counts_per_unit;
    let elapsed_s = (rest.time_s - zero.time_s).abs();
    let walk = sheet.bias_walk_5min.powi(2) * elapsed_s / 300.0;
    let shorter_s = rest.length_s.min(zero.length_s);
    let density = sheet.noise_density.max(density[channel] / counts_per_unit);
    let noise = density * density / (2.0 * shorter_s);
    let tilt = match triad {
        Triad::LinearAcceleration => sensors.gravity.m_s2 * uniform(limit_m) / TILT_ARM_M,
        Triad::AngularAcceleration | Triad::AngularRate => 0.0,
    };
    let step = uniform(COUNTS_PER_CODE) / counts_per_unit;
    change / (walk + noise + tilt * tilt + step * step).sqrt()
}
