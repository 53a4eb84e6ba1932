//! From keys to a motion base: hinges in the frames of the core, stroke and home.

use hexsense_core::kinematics::Geometry;
use hexsense_core::kinematics::convention::{from_z_down, from_z_up};
use nalgebra::Vector3;

use super::error::GeometryFileError;
use super::keys::{Axes, Keys};
use crate::columns::MAX_LENGTH_M;
use crate::files::FileError;

/// No jack is shorter when it is out, m; a file below it is in other units.
const LEAST_LENGTH_MAX_M: f64 = 0.01;

/// Hinges, stroke and home.
///
/// # Errors
/// [`GeometryFileError`], but for `Unknown`.
pub fn geometry(file: &str, keys: &Keys) -> Result<Geometry<f64>, GeometryFileError> {
    let lower = hinges(file, "lower", &keys.lower, keys)?;
    let upper = hinges(file, "upper", &keys.upper, keys)?;
    let metres = |key, value, range| keys.units.metres((file, key), value, range, "");
    let min_m = metres("length_min", keys.length_min, 0.0..=MAX_LENGTH_M)?;
    let max_m = metres(
        "length_max",
        keys.length_max,
        LEAST_LENGTH_MAX_M..=MAX_LENGTH_M,
    )?;
    let base = |reason| GeometryFileError::Base {
        file: file.to_owned(),
        reason,
    };
    let with_home = |height| Geometry::new(lower, upper, min_m, max_m, Some(height));
    if let Some(height) = keys.home_height {
        let height = metres("home_height", height, -MAX_LENGTH_M..=MAX_LENGTH_M)?;
        return with_home(height).map_err(base);
    }
    let mid_m = (min_m + max_m) / 2.0;
    let heights = Geometry::mid_stroke_heights(&lower, &upper, mid_m).map_err(base)?;
    match heights.map(with_home) {
        [Ok(_), Ok(_)] => {
            let [above, below] = heights.map(|height| height * keys.units.per_metre());
            Err(GeometryFileError::EitherSide {
                file: file.to_owned(),
                above,
                below,
            })
        }
        [Ok(geometry), Err(_)] | [Err(_), Ok(geometry)] => Ok(geometry),
        [Err(reason), Err(_)] => Err(base(reason)),
    }
}

/// Six hinges in axes with Y up, m.
fn hinges(
    file: &str,
    key: &str,
    table: &[Vec<f64>],
    keys: &Keys,
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
        let metres = |axis, value| {
            let key = format!("{key}.{axis}");
            let range = -MAX_LENGTH_M..=MAX_LENGTH_M;
            keys.units.metres((file, &key), value, range, "")
        };
        let hinge = Vector3::new(metres("x", x)?, metres("y", y)?, metres("z", z)?);
        hinges[index] = match keys.axes {
            Axes::YUp => hinge,
            Axes::ZUp => from_z_up(hinge),
            Axes::ZDown => from_z_down(hinge),
        };
    }
    Ok(hinges)
}
