//! The keys of a geometry file, their units and the axes of the hinges.

use serde::Deserialize;

use super::error::GeometryError;
use crate::algebra::Vec3;

/// No motion base is larger than this, m; a file beyond it is in other units.
pub const MAX_COORDINATE_M: f64 = 100.0;

/// Axes of the hinges.
#[derive(Deserialize)]
pub enum Axes {
    #[serde(rename = "y-up")]
    YUp,
    #[serde(rename = "z-up")]
    ZUp,
    #[serde(rename = "z-down")]
    ZDown,
}

/// Units of all lengths, speeds and accelerations.
#[derive(Deserialize, Default, Clone, Copy)]
#[serde(rename_all = "lowercase")]
pub enum Units {
    #[default]
    M,
    Mm,
}

/// The keys of a geometry file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    pub name: String,
    #[serde(default, rename = "note")]
    _note: String,
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
    #[serde(rename = "lower_hinge_angle_max_deg")]
    _lower_hinge_angle_max_deg: Option<f64>,
    #[serde(rename = "upper_hinge_angle_max_deg")]
    _upper_hinge_angle_max_deg: Option<f64>,
}

impl File {
    /// The same file with `units = "m"`.
    pub fn in_metres(mut self) -> Self {
        if let Units::Mm = self.units {
            let hinges = self.lower.iter_mut().chain(&mut self.upper).flatten();
            let required = [&mut self.length_min, &mut self.length_max];
            let optional = [
                &mut self.home_height,
                &mut self.hinge_tolerance,
                &mut self.speed_max,
                &mut self.acceleration_max,
            ];
            let optional = optional.into_iter().flatten();
            for number in hinges.chain(required).chain(optional) {
                *number /= 1000.0;
            }
            self.units = Units::M;
        }
        self
    }
}

/// `value` when it is a number from `low` to `high`.
pub fn in_range(key: &str, value: f64, low: f64, high: f64) -> Result<f64, GeometryError> {
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(GeometryError::Range {
            key: key.to_owned(),
            value,
            low,
            high,
        })
    }
}

/// Six hinges with Y up, m.
pub fn hinges(
    key: &'static str,
    table: &[Vec<f64>],
    axes: &Axes,
) -> Result<[Vec3; 6], GeometryError> {
    if table.len() != 6 {
        return Err(GeometryError::HingeCount {
            key,
            count: table.len(),
        });
    }
    let mut hinges = [Vec3::ZERO; 6];
    for (index, coordinates) in table.iter().enumerate() {
        let &[x, y, z] = coordinates.as_slice() else {
            return Err(GeometryError::CoordinateCount {
                key,
                hinge: index + 1,
                count: coordinates.len(),
            });
        };
        for (value, letter) in [(x, 'x'), (y, 'y'), (z, 'z')] {
            in_range(
                &format!("{key}[{}].{letter}", index + 1),
                value,
                -MAX_COORDINATE_M,
                MAX_COORDINATE_M,
            )?;
        }
        hinges[index] = Vec3(match axes {
            Axes::YUp => [x, y, z],
            Axes::ZUp => [x, z, -y],
            Axes::ZDown => [x, -z, y],
        });
    }
    Ok(hinges)
}

/// Shortest and longest jack, m.
pub fn stroke(file: &File) -> Result<[f64; 2], GeometryError> {
    let min = in_range("length_min", file.length_min, 0.01, MAX_COORDINATE_M)?;
    let max = in_range("length_max", file.length_max, 0.01, MAX_COORDINATE_M)?;
    if min < max {
        Ok([min, max])
    } else {
        Err(GeometryError::EmptyStroke { min, max })
    }
}
