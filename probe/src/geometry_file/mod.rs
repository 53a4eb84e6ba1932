//! The geometry file: hinges, stroke and limits of a motion base, as TOML.
//!
//! | key | meaning |
//! |---|---|
//! | `name`, `note` | what the base is and what is assumed about it |
//! | `axes` | of the hinges; `"y-up"`: X forward, Y up, Z right; `"z-up"`: x forward, y left, z up; `"z-down"`: x forward, y right, z down |
//! | `units` | of all lengths, speeds and accelerations of the file: `"m"`, as without it, or `"mm"` |
//! | `lower`, `upper` | six hinges `[x, y, z]` each, in the order of the jacks; earth frame and body frame |
//! | `length_min`, `length_max` | shortest and longest jack, hinge to hinge |
//! | `home_height` | height of O at home, upwards whatever the axes; negative where the platform hangs below its lower hinges |
//! | `hinge_tolerance` | standard deviation of a hinge coordinate from this file; 0.5 mm without it |
//! | `speed_max`, `acceleration_max` | limits of a jack, per s and s²; none without them |
//! | `lower_hinge_angle_max_deg`, `upper_hinge_angle_max_deg` | how far a jack may swing in its hinges from where it points at home, degrees; no limit without them |
//!
//! Without `home_height` home is where the jacks are at mid-stroke, if that is on one side of the lower hinges only.

use std::ops::RangeInclusive;
use std::path::Path;

use geometries::PRESETS;
use hexsense_core::kinematics::Geometry;
use hexsense_core::records::record::MAX_NAME;
use sha2::{Digest, Sha256};

use crate::files::{self, FileError, SETTINGS};

mod base;
mod error;
mod keys;

pub use error::{GeometryFileError, preset_names};

const DEFAULT_HINGE_TOLERANCE_M: f64 = 0.0005;
/// No jack is faster, m/s and m/s²; a file beyond it is in other units.
const SPEEDS_M_S: RangeInclusive<f64> = 1e-3..=20.0;
const ACCELERATIONS_M_S2: RangeInclusive<f64> = 1e-3..=1000.0;

/// A motion base as its file describes it.
#[derive(Debug, Clone)]
pub struct GeometryFile {
    /// Preset or path that it was read from.
    pub source: String,
    /// The file as it is, for copies.
    pub text: String,
    /// SHA-256 of the text.
    pub hash: [u8; 32],
    /// Name of the base, at most 32 bytes.
    pub name: String,
    /// What is known and what is assumed.
    pub note: String,
    /// Hinges, stroke and home, in the frames of the product.
    pub geometry: Geometry<f64>,
    /// Standard deviation of each hinge coordinate, m.
    pub hinge_tolerance_m: f64,
    /// Highest speed of a jack, m/s.
    pub speed_max_m_s: Option<f64>,
    /// Highest acceleration of a jack, m/s².
    pub acceleration_max_m_s2: Option<f64>,
    /// Largest angle of a jack in its lower hinge from its direction at home, degrees.
    pub lower_hinge_angle_max_deg: Option<f64>,
    /// The same in its upper hinge, which turns with the platform.
    pub upper_hinge_angle_max_deg: Option<f64>,
}

impl GeometryFile {
    /// The preset of this name, or else the file at this path.
    ///
    /// # Errors
    /// Every variant of [`GeometryFileError`].
    pub fn load(name_or_path: &str) -> Result<Self, GeometryFileError> {
        if let Some((name, text)) = PRESETS.iter().find(|(name, _)| *name == name_or_path) {
            return Self::parse(name, text);
        }
        let path = Path::new(name_or_path);
        if !path.exists() {
            return Err(GeometryFileError::Unknown {
                name: name_or_path.to_owned(),
            });
        }
        Self::parse(name_or_path, &files::read(path, SETTINGS)?)
    }

    /// Reads `text`, which came from `source`.
    ///
    /// # Errors
    /// [`GeometryFileError::File`] and [`GeometryFileError::Base`].
    pub fn parse(source: &str, text: &str) -> Result<Self, GeometryFileError> {
        let keys: keys::Keys = files::from_toml(source, text)?;
        if keys.name.is_empty() || keys.name.len() > MAX_NAME {
            let limit = format!("it must have 1 to {MAX_NAME} bytes");
            return Err(FileError::value(source, "name", format!("{:?}", keys.name), limit).into());
        }
        let units = keys.units;
        let optional = |key: &str, value: Option<f64>, range: RangeInclusive<f64>, per: &str| {
            let metres = |value| units.metres((source, key), value, range, per);
            value.map(metres).transpose()
        };
        let angle = |key: &str, value: Option<f64>| {
            let within = |value| files::within(source, key, value, 1.0..=90.0);
            value.map(within).transpose()
        };
        let tolerance = optional("hinge_tolerance", keys.hinge_tolerance, 0.0..=0.01, "")?;
        Ok(Self {
            geometry: base::geometry(source, &keys)?,
            hinge_tolerance_m: tolerance.unwrap_or(DEFAULT_HINGE_TOLERANCE_M),
            speed_max_m_s: optional("speed_max", keys.speed_max, SPEEDS_M_S, "/s")?,
            acceleration_max_m_s2: optional(
                "acceleration_max",
                keys.acceleration_max,
                ACCELERATIONS_M_S2,
                "/s²",
            )?,
            lower_hinge_angle_max_deg: angle(
                "lower_hinge_angle_max_deg",
                keys.lower_hinge_angle_max_deg,
            )?,
            upper_hinge_angle_max_deg: angle(
                "upper_hinge_angle_max_deg",
                keys.upper_hinge_angle_max_deg,
            )?,
            source: source.to_owned(),
            text: text.to_owned(),
            hash: Sha256::digest(text).into(),
            name: keys.name,
            note: keys.note,
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn every_preset_is_a_motion_base() {
        for name in preset_names() {
            let file = GeometryFile::load(name).unwrap();
            assert_eq!(file.name, name);
        }
    }

    #[test]
    fn a_z_up_file_is_turned_into_the_body_frame() {
        let file = GeometryFile::load("rexroth_emotion8000").unwrap();
        // [1.356156704, 2.120332314, 0.0] with z up: y to the left is −Z to the right.
        let hinge = file.geometry.lower()[0];
        assert_eq!(hinge, Vector3::new(1.356156704, 0.0, -2.120332314));
        assert!(file.geometry.home_height_m() > 1.0);
    }
}
