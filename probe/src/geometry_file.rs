//! The geometry file: hinges, stroke and limits of a motion base, as TOML.
//!
//! | key | meaning |
//! |---|---|
//! | `name`, `note` | what the base is and what is assumed about it |
//! | `axes` | `"y-up"`: X forward, Y up, Z right; `"z-up"`: x forward, y left, z up, turned on reading |
//! | `lower`, `upper` | six hinges `[x, y, z]` each, in the order of the jacks, m; earth frame and body frame |
//! | `length_min`, `length_max` | shortest and longest jack, hinge to hinge, m |
//! | `home_height` | height of O at home, m; without it, where the jacks are at mid-stroke |
//! | `hinge_tolerance` | standard deviation of a hinge coordinate from this file, m; 0.0005 without it |
//! | `speed_max`, `acceleration_max` | limits of a jack, m/s and m/s²; none without them |
//! | `lower_hinge_angle_max_deg`, `upper_hinge_angle_max_deg` | how far a jack may swing in its hinges from where it points at home, degrees; no limit without them |

use std::path::Path;

use geometries::PRESETS;
use hexsense_core::kinematics::convention::from_z_up;
use hexsense_core::kinematics::{Geometry, GeometryError};
use hexsense_core::records::record::MAX_NAME;
use nalgebra::Vector3;
use serde::Deserialize;
use sha2::{Digest, Sha256};

use crate::files::{self, FileError};

const DEFAULT_HINGE_TOLERANCE_M: f64 = 0.0005;
/// No motion base is larger, m; a file beyond it is in other units.
const MAX_COORDINATE_M: f64 = 100.0;

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

/// Why there is no motion base to work with.
#[derive(Debug, thiserror::Error)]
pub enum GeometryFileError {
    /// Neither a preset nor a file.
    #[error(
        "there is no geometry preset and no file {name}; presets are {presets}",
        presets = preset_names().join(", ")
    )]
    Unknown {
        /// As asked.
        name: String,
    },
    /// The file or one of its keys cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// The numbers do not make a motion base.
    #[error("{file}: {reason}")]
    Base {
        /// The file.
        file: String,
        /// What is wrong.
        reason: GeometryError<f64>,
    },
}

/// Names of the geometries that come with the product.
#[must_use]
pub fn preset_names() -> Vec<&'static str> {
    PRESETS.iter().map(|(name, _)| *name).collect()
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    name: String,
    #[serde(default)]
    note: String,
    axes: Axes,
    lower: Vec<Vec<f64>>,
    upper: Vec<Vec<f64>>,
    length_min: f64,
    length_max: f64,
    home_height: Option<f64>,
    hinge_tolerance: Option<f64>,
    speed_max: Option<f64>,
    acceleration_max: Option<f64>,
    lower_hinge_angle_max_deg: Option<f64>,
    upper_hinge_angle_max_deg: Option<f64>,
}

#[derive(Deserialize, Clone, Copy)]
enum Axes {
    #[serde(rename = "y-up")]
    YUp,
    #[serde(rename = "z-up")]
    ZUp,
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
        Self::parse(name_or_path, &files::read(path)?)
    }

    /// Reads `text`, which came from `source`.
    ///
    /// # Errors
    /// [`GeometryFileError::File`] and [`GeometryFileError::Base`].
    pub fn parse(source: &str, text: &str) -> Result<Self, GeometryFileError> {
        let keys: Keys = files::from_toml(source, text)?;
        if keys.name.is_empty() || keys.name.len() > MAX_NAME {
            let limit = format!("it must have 1 to {MAX_NAME} bytes");
            return Err(FileError::value(source, "name", format!("{:?}", keys.name), limit).into());
        }
        let number = |key: &str, value: f64, low: f64, high: f64| {
            files::within(source, key, value, low..=high)
        };
        let optional = |key: &str, value: Option<f64>, low: f64, high: f64| {
            value.map(|value| number(key, value, low, high)).transpose()
        };
        let angle = |key: &str, value: Option<f64>| optional(key, value, 1.0, 90.0);
        let geometry = Geometry::new(
            hinges(source, "lower", &keys.lower, keys.axes)?,
            hinges(source, "upper", &keys.upper, keys.axes)?,
            number("length_min", keys.length_min, 0.0, MAX_COORDINATE_M)?,
            number("length_max", keys.length_max, 0.0, MAX_COORDINATE_M)?,
            optional(
                "home_height",
                keys.home_height,
                -MAX_COORDINATE_M,
                MAX_COORDINATE_M,
            )?,
        )
        .map_err(|error| GeometryFileError::Base {
            file: source.to_owned(),
            reason: error,
        })?;
        let tolerance = optional("hinge_tolerance", keys.hinge_tolerance, 0.0, 0.01)?;
        Ok(Self {
            geometry,
            hinge_tolerance_m: tolerance.unwrap_or(DEFAULT_HINGE_TOLERANCE_M),
            speed_max_m_s: optional("speed_max", keys.speed_max, 1e-3, 1e3)?,
            acceleration_max_m_s2: optional("acceleration_max", keys.acceleration_max, 1e-3, 1e4)?,
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

/// Six hinges in axes with Y up.
fn hinges(
    file: &str,
    key: &str,
    table: &[Vec<f64>],
    axes: Axes,
) -> Result<[Vector3<f64>; 6], FileError> {
    if table.len() != 6 {
        let value = format!("a list of {}", table.len());
        let limit = "it must have 6 hinges, one for each jack";
        return Err(FileError::value(file, key, value, limit));
    }
    let mut hinges = [Vector3::zeros(); 6];
    for (index, coordinates) in table.iter().enumerate() {
        let key = format!("{key}[{}]", index + 1);
        let &[x, y, z] = coordinates.as_slice() else {
            let value = format!("a list of {}", coordinates.len());
            return Err(FileError::value(file, key, value, "it must be [x, y, z]"));
        };
        for (value, axis) in [(x, "x"), (y, "y"), (z, "z")] {
            files::within(
                file,
                &format!("{key}.{axis}"),
                value,
                -MAX_COORDINATE_M..=MAX_COORDINATE_M,
            )?;
        }
        hinges[index] = match axes {
            Axes::YUp => Vector3::new(x, y, z),
            Axes::ZUp => from_z_up(Vector3::new(x, y, z)),
        };
    }
    Ok(hinges)
}

#[cfg(test)]
mod tests {
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
