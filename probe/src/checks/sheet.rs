//! Each sensor against its data sheet: gain, direction and bias.
//!
//! The rows of the sensitivity S are the sensors, in counts per unit along the body axes. So
//!
//! ```text
//! gain      |S_i| / S_sheet − 1              limit: the sheet's tolerance, the converter's, and U
//! tilt      angle of S_i to its own axis     limit: 4 σ of the sheet and U of its cross elements
//! bias      (u0 − u0_sheet) / |S_i|          limit: the sheet's tolerance, the converter's at zero counts, and U
//! ```
//!
//! The direction tells what a gain cannot: an exchanged sensor lies along another axis, an inverted one is turned round.

use hexsense_core::channel::{INERTIAL, NAMES, Triad};
use nalgebra::Vector3;

use crate::analysis::assumptions::COUNTS_PER_CODE;
use crate::analysis::check::{Check, Figure, judge};
use crate::analysis::results::Analysis;
use crate::sensor_file::SensorFile;

/// Largest tilt in standard deviations of the sheet: of two normal angles together one sensor in 3,000 has more.
const TILT_DEVIATIONS: f64 = 4.0;
/// Cosine beyond which a sensor lies along an axis.
const ALONG: f64 = 0.7;
/// More sensors than these do not lie wrong by themselves.
const MOST: usize = 4;

/// What is known of one sensor.
struct Sensor {
    channel: usize,
    triad: Triad,
    /// Row of S, counts per unit.
    row: Vector3<f64>,
    /// Counts per unit by the sheet.
    nominal: f64,
    /// Counts at zero by the sheet.
    zero: f64,
}

impl Sensor {
    fn axis(&self) -> usize {
        self.channel % 3
    }

    /// Share of the sensor that lies along body axis `axis`, signed by the sheet's gain.
    fn along(&self, axis: usize) -> f64 {
        self.row[axis] / self.row.norm() * self.nominal.signum()
    }
}

/// The checks of the nine sensors.
pub fn checks(sheet: &SensorFile, analysis: &Analysis) -> Vec<Check> {
    let sensors: Vec<Sensor> = (0..INERTIAL)
        .map(|channel| {
            let triad = Triad::ALL[channel / 3];
            let (nominal, zero) = sheet.triad(triad).nominal_counts(sheet.counts_per_volt());
            let rows = &analysis.estimate.fits[triad.index()].sensitivity;
            Sensor {
                channel,
                triad,
                row: rows.row(channel % 3).transpose(),
                nominal,
                zero,
            }
        })
        .collect();
    let figures = |figure: &dyn Fn(&Sensor) -> (f64, f64)| {
        let figures = sensors.iter().map(|sensor| {
            let (value, limit) = figure(sensor);
            Figure {
                name: NAMES[sensor.channel].to_owned(),
                value,
                limit,
            }
        });
        figures.collect::<Vec<_>>()
    };
    let directions = |names: &[String]| directions(&sensors, names);
    vec![
        judge(
            "sensor direction",
            "deg",
            figures(&|sensor| tilt(sensor, sheet, analysis)),
            "each sensor lies along its own axis",
            directions,
        ),
        judge(
            "sensor gain",
            "relative",
            figures(&|sensor| gain(sensor, sheet, analysis)),
            "each gain is within its data sheet",
            |names| {
                format!(
                    "the gain of {} is outside its data sheet: see whether the sensor is connected and of the type that the \
                     sensor file names (volts_per_unit, full_scale), and whether the geometry file is that of this base",
                    names.join(", ")
                )
            },
        ),
        judge(
            "sensor bias",
            "of the tolerance",
            figures(&|sensor| bias(sensor, sheet, analysis)),
            "each zero is within its data sheet",
            |names| {
                format!(
                    "the zero of {} is outside its data sheet: see whether the sensor is connected, and zero_volts in the \
                     sensor file",
                    names.join(", ")
                )
            },
        ),
    ]
}

/// Angle between a sensor and its axis, degrees, and its limit.
fn tilt(sensor: &Sensor, sheet: &SensorFile, analysis: &Analysis) -> (f64, f64) {
    let angle = sensor.along(sensor.axis()).clamp(-1.0, 1.0).acos();
    let cross = analysis.results.channels[sensor.channel].cross;
    let uncertain = (0..3)
        .filter(|axis| *axis != sensor.axis())
        .map(|axis| (cross[axis].expanded_uncertainty * sensor.nominal).powi(2));
    let uncertain = uncertain.sum::<f64>().sqrt().to_degrees();
    let tilted = TILT_DEVIATIONS * sheet.triad(sensor.triad).misalignment_deg;
    (angle.to_degrees(), tilted + uncertain)
}

/// Relative deviation of the gain from the sheet, and its limit.
fn gain(sensor: &Sensor, sheet: &SensorFile, analysis: &Analysis) -> (f64, f64) {
    let measured = sensor.row.norm() / sensor.nominal.abs();
    let found = analysis.results.channels[sensor.channel].gain;
    let uncertain = (found.expanded_uncertainty / found.estimate).abs();
    let tolerance = sheet.triad(sensor.triad).gain_tolerance;
    (
        (measured - 1.0).abs(),
        tolerance + sheet.adc.gain_tolerance + uncertain,
    )
}

/// Distance of the zero from the sheet's over what it may be, and one.
fn bias(sensor: &Sensor, sheet: &SensorFile, analysis: &Analysis) -> (f64, f64) {
    let offset = analysis.results.channels[sensor.channel].offset;
    let tolerance = sheet.triad(sensor.triad).bias_tolerance * sensor.nominal.abs();
    let converter = sheet.adc.offset_tolerance_lsb * COUNTS_PER_CODE
        + sheet.adc.gain_tolerance * sensor.zero.abs();
    let limit = tolerance + converter + offset.expanded_uncertainty;
    ((offset.estimate - sensor.zero).abs() / limit, 1.0)
}

/// Where the sensors of these names lie.
fn directions(sensors: &[Sensor], names: &[String]) -> String {
    let accused = sensors
        .iter()
        .filter(|sensor| names.iter().any(|name| name == NAMES[sensor.channel]));
    if names.len() > MOST {
        return format!(
            "most sensors lie along other axes than their own ({}): is the geometry file that of this base, with its hinges \
             in the order of the jacks and its axes as they are?",
            names.join(", ")
        );
    }
    let causes = accused.map(|sensor| {
        let name = NAMES[sensor.channel];
        let own = sensor.along(sensor.axis());
        let other = (0..3).find(|axis| *axis != sensor.axis() && sensor.along(*axis).abs() > ALONG);
        match other {
            _ if own < -ALONG => format!("{name} is inverted"),
            Some(axis) => format!(
                "{name} lies along the axis of {}: are their plugs exchanged?",
                NAMES[sensor.channel - sensor.axis() + axis]
            ),
            None => format!(
                "{name} is tilted by {:.1}°: see how it is mounted, and whether it is connected",
                own.clamp(-1.0, 1.0).acos().to_degrees()
            ),
        }
    });
    causes.collect::<Vec<_>>().join("; ")
}
