//! The keys of a geometry file, and the units of their numbers.

use std::ops::RangeInclusive;

use serde::Deserialize;

use crate::files::FileError;

/// All keys, as they stand in the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keys {
    pub name: String,
    #[serde(default)]
    pub note: String,
    pub axes: Axes,
    #[serde(default)]
    pub units: Units,
    pub lower: Vec<Vec<f64>>,
    pub upper: Vec<Vec<f64>>,
    pub length_min: f64,
    pub length_max: f64,
    pub home_height: Option<f64>,
    pub hinge_tolerance: Option<f64>,
    pub speed_max: Option<f64>,
    pub acceleration_max: Option<f64>,
    pub lower_hinge_angle_max_deg: Option<f64>,
    pub upper_hinge_angle_max_deg: Option<f64>,
}

/// Axes of the hinges.
#[derive(Deserialize, Clone, Copy)]
pub enum Axes {
    #[serde(rename = "y-up")]
    YUp,
    #[serde(rename = "z-up")]
    ZUp,
    #[serde(rename = "z-down")]
    ZDown,
}

/// Units of all lengths, speeds and accelerations.
#[derive(Deserialize, Clone, Copy, Default)]
pub enum Units {
    #[default]
    #[serde(rename = "m")]
    Metres,
    #[serde(rename = "mm")]
    Millimetres,
}

impl Units {
    /// `value` of the file in metres, or metres per s or s², when it is inside `range` of these.
    pub fn metres(
        self,
        file: &str,
        key: &str,
        value: f64,
        range: RangeInclusive<f64>,
    ) -> Result<f64, FileError> {
        let (name, per_metre) = match self {
            Self::Metres => ("m", 1.0),
            Self::Millimetres => ("mm", 1000.0),
        };
        let metres = value / per_metre;
        if range.contains(&metres) {
            return Ok(metres);
        }
        let (low, high) = (range.start() * per_metre, range.end() * per_metre);
        let hint = match self {
            Self::Metres if metres.abs() > *range.end() => {
                "; if the file is in millimetres, add units = \"mm\""
            }
            Self::Millimetres if metres.abs() < *range.start() => {
                "; if the file is in metres, leave out units"
            }
            _ => "",
        };
        let limit = format!("it must be {low} to {high} ({name}){hint}");
        Err(FileError::value(file, key, value, limit))
    }

    /// A length in metres in these units.
    pub fn from_metres(self, metres: f64) -> f64 {
        match self {
            Self::Metres => metres,
            Self::Millimetres => metres * 1000.0,
        }
    }
}
