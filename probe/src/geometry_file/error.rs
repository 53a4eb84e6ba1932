//! Why there is no motion base to work with.

use geometries::PRESETS;
use hexsense_core::kinematics::GeometryError;

use crate::files::FileError;

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
    /// The platform may be on either side of its lower hinges, and the file does not say on which.
    #[error(
        "{file}: home_height is missing, and the platform may be on either side of its lower hinges; give \
         home_height = {above:.6} (platform above) or home_height = {below:.6} (platform below)"
    )]
    EitherSide {
        /// The file.
        file: String,
        /// Height of O with the jacks at mid-stroke and the platform above its lower hinges, in the units of the file.
        above: f64,
        /// The same with the platform below them.
        below: f64,
    },
}

/// Names of the geometries that come with the product.
#[must_use]
pub fn preset_names() -> Vec<&'static str> {
    PRESETS.iter().map(|(name, _)| *name).collect()
}
