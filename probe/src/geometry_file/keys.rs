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
    /// `value` of the file in metres when it is inside `range` of these; in metres per s or s² where `per` is "/s" or
    /// "/s²".
    pub fn metres(
        self,
        (file, key): (&str, &str),
        value: f64,
        range: RangeInclusive<f64>,
        per: &str,
    ) -> Result<f64, FileError> {
        let metres = value / self.per_metre();
        if range.contains(&metres) {
            return Ok(metres);
        }
        let [low, high] = [range.start(), range.end()].map(|limit| limit * self.per_metre());
        let (name, hint) = match self {
            Self::Metres if metres.abs() > *range.end() => {
                ("m", "; if the file is in millimetres, add units = \"mm\"")
            }
            Self::Metres => ("m", ""),
            Self::Millimetres if metres.abs() < *range.start() => {
                ("mm", "; if the file is in metres, leave out units")
            }
            Self::Millimetres => ("mm", ""),
        };
        let limit = format!("it must be {low} to {high} ({name}{per}){hint}");
        Err(FileError::value(file, key, value, limit))
    }

    /// How many of these are a metre.
    pub fn per_metre(self) -> f64 {
        match self {
            Self::Metres => 1.0,
            Self::Millimetres => 1000.0,
        }
    }
}
