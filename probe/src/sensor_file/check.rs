//! What the numbers of a sensor file must be.

use hexsense_core::calibration::gravity::{ANOMALY_M_S2, normal_gravity_m_s2};
use hexsense_core::channel::Triad;

use super::{Gravity, SensorFile, TriadSheet};
use crate::files::{self, FileError};

/// Least and greatest gravity on the Earth's surface, m/s²: on Huascarán and in the Arctic Ocean (Hirt et al. 2013).
const ON_EARTH_M_S2: [f64; 2] = [9.764, 9.834];
/// How far a value may be from normal gravity of its place, relative: twice the usual size of anomalies.
const AGREEMENT: f64 = 1e-4;

impl SensorFile {
    /// Refuses numbers that no data sheet has.
    pub(super) fn check(&self, file: &str) -> Result<(), FileError> {
        let check = |key: &str, value: f64, low: f64, high: f64| {
            files::within(file, key, value, low..=high).map(drop)
        };
        for line in &self.lines_hz {
            check("lines_hz", *line, 0.1, 2_000.0)?;
        }
        check("supply_v", self.supply_v, 1.7, 3.6)?;
        for (place, axis) in self.lever_arm_m.into_iter().zip(["x", "y", "z"]) {
            check(&format!("lever_arm_m.{axis}"), place, -20.0, 20.0)?;
        }
        check(
            "lever_arm_tolerance_m",
            self.lever_arm_tolerance_m,
            0.0,
            1.0,
        )?;
        for triad in Triad::ALL {
            self.triad(triad)
                .check(file, table_of(triad), self.supply_v)?;
        }
        let jacks = &self.jacks;
        check(
            "jacks.full_stroke_volts",
            jacks.full_stroke_volts.abs(),
            0.1,
            self.supply_v,
        )?;
        check("jacks.zero_volts", jacks.zero_volts, 0.0, self.supply_v)?;
        check("jacks.gain_tolerance", jacks.gain_tolerance, 0.0, 0.5)?;
        check(
            "jacks.offset_tolerance_m",
            jacks.offset_tolerance_m,
            0.0,
            1.0,
        )?;
        check("jacks.noise_rms_m", jacks.noise_rms_m, 0.0, 0.1)?;
        let adc = &self.adc;
        check("adc.gain_tolerance", adc.gain_tolerance, 0.0, 0.5)?;
        check(
            "adc.offset_tolerance_lsb",
            adc.offset_tolerance_lsb,
            0.0,
            1e3,
        )?;
        check("adc.clock_tolerance_ppm", adc.clock_tolerance_ppm, 0.0, 1e5)?;
        Ok(())
    }

    /// Gravity by value, by place, or by both, which are then compared.
    pub(super) fn gravity_of(&self, file: &str) -> Result<Gravity, FileError> {
        let within = |key: &str, value: f64, low: f64, high: f64| {
            files::within(file, key, value, low..=high)
        };
        let stated = self.gravity_uncertainty_m_s2.unwrap_or(ANOMALY_M_S2);
        let uncertainty_m_s2 = within("gravity_uncertainty_m_s2", stated, 0.0, 0.1)?;
        let [low, high] = ON_EARTH_M_S2;
        let value = self.gravity_m_s2;
        let value = value.map(|value| within("gravity_m_s2", value, low, high));
        let value = value.transpose()?;
        let place = match (self.latitude_deg, self.height_m) {
            (Some(latitude_deg), Some(height_m)) => {
                within("latitude_deg", latitude_deg, -90.0, 90.0)?;
                within("height_m", height_m, -500.0, 9_000.0)?;
                Some((latitude_deg, height_m))
            }
            (None, None) => None,
            (latitude_deg, _) => {
                let (there, missing) = match latitude_deg {
                    Some(_) => ("latitude_deg", "height_m"),
                    None => ("height_m", "latitude_deg"),
                };
                let limit = format!("gravity of a place needs {there} and {missing}");
                return Err(FileError::value(file, missing, "not given", limit));
            }
        };
        let by_place = place.map(|(latitude_deg, height_m)| {
            let key = format!("gravity at latitude_deg {latitude_deg} and height_m {height_m}");
            let normal = normal_gravity_m_s2(latitude_deg.to_radians(), height_m);
            within(&key, normal, low, high)
        });
        let m_s2 = match (value, by_place.transpose()?) {
            (None, None) => {
                let limit = "give it, or latitude_deg and height_m of the place";
                return Err(FileError::value(file, "gravity_m_s2", "not given", limit));
            }
            (Some(value), Some(normal)) if (value / normal - 1.0).abs() > AGREEMENT => {
                let limit = format!(
                    "latitude_deg and height_m give {normal:.5} m/s², and the two may differ by {AGREEMENT:.0e} of it, \
                     the size of local anomalies; correct one of them, or leave one out"
                );
                return Err(FileError::value(file, "gravity_m_s2", value, limit));
            }
            (Some(value), _) | (None, Some(value)) => value,
        };
        Ok(Gravity {
            m_s2,
            uncertainty_m_s2,
            is_given: value.is_some(),
            place,
        })
    }
}

impl TriadSheet {
    fn check(&self, file: &str, table: &str, supply_v: f64) -> Result<(), FileError> {
        let check = |key: &str, value: f64, low: f64, high: f64| {
            files::within(file, &format!("{table}.{key}"), value, low..=high).map(drop)
        };
        check("full_scale", self.full_scale, 1e-3, 1e4)?;
        check("volts_per_unit", self.volts_per_unit.abs(), 1e-6, 1e3)?;
        check("zero_volts", self.zero_volts, 0.0, supply_v)?;
        self.check_range(file, table, supply_v)?;
        check("gain_tolerance", self.gain_tolerance, 0.0, 0.5)?;
        check("bias_tolerance", self.bias_tolerance, 0.0, self.full_scale)?;
        check("noise_density", self.noise_density, 0.0, self.full_scale)?;
        check("bias_walk_5min", self.bias_walk_5min, 0.0, self.full_scale)?;
        check("misalignment_deg", self.misalignment_deg, 0.0, 10.0)?;
        for (key, [low, high], limit) in [
            ("bandwidth_hz", self.bandwidth_hz, 1e5),
            ("damping", self.damping, 10.0),
        ] {
            check(key, low, 1e-2, limit)?;
            if !(low..=limit).contains(&high) {
                let limit = format!("its second number must be {low} to {limit}");
                return Err(FileError::value(
                    file,
                    format!("{table}.{key}"),
                    format!("[{low}, {high}]"),
                    limit,
                ));
            }
        }
        Ok(())
    }
}

impl TriadSheet {
    /// Refuses a full scale whose output leaves the range of the converter.
    fn check_range(&self, file: &str, table: &str, supply_v: f64) -> Result<(), FileError> {
        let swing_v = self.full_scale * self.volts_per_unit.abs();
        let room_v = self.zero_volts.min(supply_v - self.zero_volts);
        // A full scale that ends at the rail exactly is right; its product is rounded.
        if swing_v <= room_v + 1e-9 {
            return Ok(());
        }
        Err(FileError::value(
            file,
            format!("{table}.full_scale"),
            format!(
                "{} with {} V per unit, ± {swing_v:.3} V about {} V",
                self.full_scale, self.volts_per_unit, self.zero_volts
            ),
            format!(
                "the output at full scale must stay within the converter's 0 to {supply_v} V, ± {room_v:.3} V about \
                 zero_volts; check volts_per_unit first"
            ),
        ))
    }
}

/// Name of a triad's table, here and in the coefficient file.
pub fn table_of(triad: Triad) -> &'static str {
    match triad {
        Triad::LinearAcceleration => "linear_acceleration",
        Triad::AngularAcceleration => "angular_acceleration",
        Triad::AngularRate => "angular_rate",
    }
}
