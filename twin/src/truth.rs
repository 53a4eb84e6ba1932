//! The truth of the nine channels: the result of a perfect calibration.
//!
//! A board reads counts u: sums of 16 conversions, normalised to a supply of exactly 3.300 V. For a triad with the true
//! vector s at its place, after all transients,
//!
//! ```text
//! u = u0 + S·s        row i of S: counts per volt · volts per unit · gain_i · axis_i
//! s = M·(u − u0)      M = S⁻¹
//! ```
//!
//! S is the true sensitivity matrix and contains sensor gain, misalignment, volts and the gain of ADC1. u0 is the value
//! at power-on: it includes bias and converter offset, but not the random walk that follows.

use serde::Serialize;

use crate::algebra::{Factors, Vec3};
use crate::board::AdcTruth;
use crate::random::Stream;
use crate::sensor::SensorTruth;
use crate::sheet::{self, TRIADS, TriadSheet};

/// True place of the sensor block: from O, body axes, m.
#[must_use]
pub fn lever_arm_m(seed: u64) -> Vec3 {
    Vec3(
        ["x", "y", "z"].map(|axis| {
            Stream::new(seed, &format!("lever_arm.{axis}")).within(sheet::LEVER_ARM_MAX_M)
        }),
    )
}

/// True gravity at the base, m/s².
#[must_use]
pub fn gravity_m_s2(seed: u64) -> f64 {
    let anomaly = Stream::new(seed, "gravity").normal();
    sheet::STANDARD_GRAVITY_M_S2 + sheet::GRAVITY_UNCERTAINTY_M_S2 * anomaly
}

/// The truth of one triad.
#[derive(Debug, Clone, PartialEq)]
pub struct TriadTruth {
    /// S, counts per unit.
    pub sensitivity: [[f64; 3]; 3],
    /// M, unit per count.
    pub matrix: [[f64; 3]; 3],
    /// u0, counts.
    pub offset: [f64; 3],
}

impl TriadTruth {
    /// The truth of a triad read by the converter `adc`.
    #[must_use]
    pub fn draw(seed: u64, sheet: &TriadSheet, adc: &AdcTruth) -> Self {
        let sensors = [0, 1, 2].map(|axis| SensorTruth::draw(seed, sheet, axis));
        let counts_per_unit = adc.counts_per_volt() * sheet.volts_per_unit();
        let sensitivity = sensors
            .each_ref()
            .map(|sensor| (sensor.axis * (counts_per_unit * sensor.gain)).0);
        Self {
            // Axes at most 1° off are far from being in one plane.
            matrix: Factors::new(sensitivity)
                .map_or([[f64::NAN; 3]; 3], |factors| factors.inverse()),
            offset: sensors
                .each_ref()
                .map(|sensor| adc.counts(sheet::ZERO_V + sheet.volts_per_unit() * sensor.bias)),
            sensitivity,
        }
    }
}

/// Mean delay of a triad's sensors behind slow motion, s: 2ζ/Ω of a second-order response.
#[must_use]
pub fn mean_delay_s(seed: u64, sheet: &TriadSheet) -> f64 {
    let delays = [0, 1, 2].map(|axis| {
        let sensor = SensorTruth::draw(seed, sheet, axis);
        2.0 * sensor.damping / (std::f64::consts::TAU * sensor.bandwidth_hz)
    });
    delays.iter().sum::<f64>() / 3.0
}

/// The document that `twin truth --json` prints.
#[derive(Debug, Serialize)]
pub struct Document {
    /// The seed.
    pub seed: u64,
    /// Name of the base.
    pub geometry: String,
    /// ax ay az ex ey ez wx wy wz.
    pub channels: Vec<Channel>,
}

/// The truth of one channel.
#[derive(Debug, Serialize)]
pub struct Channel {
    /// Name of the channel.
    pub name: &'static str,
    /// u0, counts.
    pub offset: Value<f64>,
    /// Diagonal element of M, unit per count.
    pub gain: Value<f64>,
    /// The channel's row of M, unit per count.
    pub cross: Value<[f64; 3]>,
}

/// A value, named as the comparison with an estimate expects.
#[derive(Debug, Serialize)]
pub struct Value<T> {
    /// The true value.
    pub truth: T,
}

impl Document {
    /// The truth under a seed, on the base of this name.
    #[must_use]
    pub fn new(seed: u64, geometry: &str) -> Self {
        let adc = crate::board::BoardTruth::draw(seed).adc[0];
        let channels = TRIADS.iter().flat_map(|sheet| {
            let triad = TriadTruth::draw(seed, sheet, &adc);
            [0, 1, 2].map(|axis| Channel {
                name: sheet.channels[axis],
                offset: Value {
                    truth: triad.offset[axis],
                },
                gain: Value {
                    truth: triad.matrix[axis][axis],
                },
                cross: Value {
                    truth: triad.matrix[axis],
                },
            })
        });
        Self {
            seed,
            geometry: geometry.to_owned(),
            channels: channels.collect(),
        }
    }

    /// The document as a table for people.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = format!(
            "Truth under seed {} on {}: value = M (u - u0), u in counts (65536 = 3.300 V)\n\n\
             {:<8}{:>14}{:>17}   row of M, unit per count\n",
            self.seed, self.geometry, "channel", "u0, counts", "k = M_ii"
        );
        let units = TRIADS.iter().flat_map(|sheet| [sheet.unit; 3]);
        for (channel, unit) in self.channels.iter().zip(units) {
            let [x, y, z] = channel.cross.truth;
            text += &format!(
                "{:<8}{:>14.2}{:>17.8e}   [{x:+.6e}, {y:+.6e}, {z:+.6e}] {unit}\n",
                channel.name, channel.offset.truth, channel.gain.truth
            );
        }
        text
    }
}
