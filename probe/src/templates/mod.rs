//! Files to start from: each has every key of its kind, with a comment, and reads without error.

use crate::files;
use crate::geometry_file::GeometryFile;

/// A geometry file of a made-up base.
pub const GEOMETRY: &str = include_str!("geometry.toml");
/// A sensor file with usual values.
pub const SENSORS: &str = include_str!("sensors.toml");

/// A plan with every kind of movement for this base.
#[must_use]
pub fn plan(geometry: &GeometryFile) -> String {
    include_str!("plan.toml")
        .replace("GEOMETRY_NAME", &geometry.name)
        .replace("GEOMETRY_SHA256", &files::hex(&geometry.hash))
}
