//! The errors of a geometry file.

use thiserror::Error;

/// How far from mid-length a jack may be at a home height that was not given, m.
pub(super) const MID_LENGTH_TOLERANCE_M: f64 = 0.001;

/// Why a geometry file cannot be used. The caller adds the name of the file.
#[derive(Debug, Error)]
pub enum GeometryError {
    /// Neither a preset nor a file.
    #[error("{name}: no such preset or file ({source}); presets: {presets}", presets = preset_names())]
    NotFound {
        /// The requested name.
        name: String,
        /// Why it could not be read as a file.
        source: std::io::Error,
    },
    /// Something in a file is wrong.
    #[error("{file}: {source}")]
    InFile {
        /// Preset or path.
        file: String,
        /// What is wrong.
        #[source]
        source: Box<GeometryError>,
    },
    /// Not TOML, an unknown or missing key, or a value of the wrong type.
    #[error("not a geometry file: {0}")]
    Syntax(#[from] toml::de::Error),
    /// A table of hinges that does not have six triples.
    #[error("{key}: {count} hinges, must be 6")]
    HingeCount {
        /// `lower` or `upper`.
        key: &'static str,
        /// Number of hinges in the file.
        count: usize,
    },
    /// A hinge that is not a triple.
    #[error("{key}[{hinge}]: {count} coordinates, must be 3")]
    CoordinateCount {
        /// `lower` or `upper`.
        key: &'static str,
        /// Which hinge, 1 to 6.
        hinge: usize,
        /// Number of coordinates in the file.
        count: usize,
    },
    /// A number outside its range, or no number.
    #[error("{key}: {value} is outside {low} to {high}")]
    Range {
        /// The key.
        key: String,
        /// The value in the file.
        value: f64,
        /// Lowest value allowed.
        low: f64,
        /// Highest value allowed.
        high: f64,
    },
    /// Shortest jack not shorter than the longest.
    #[error("length_min: {min} m is not below length_max, {max} m")]
    EmptyStroke {
        /// `length_min`, m.
        min: f64,
        /// `length_max`, m.
        max: f64,
    },
    /// No `home_height`, and no height that puts all jacks at mid-length.
    #[error(
        "home_height is missing, and at no height are all jacks at mid-length {mid:.4} m (jack {jack}: off by \
         {off:.4} m at best, at most {MID_LENGTH_TOLERANCE_M} m); give home_height"
    )]
    NoMidHeight {
        /// Mid-length, m.
        mid: f64,
        /// The worst jack, 1 to 6.
        jack: usize,
        /// Its distance from mid-length, m.
        off: f64,
    },
    /// No `home_height`, and the platform can be above or below its lower hinges.
    #[error(
        "home_height is missing, and all jacks are at mid-length at {above:.6} m (platform above its lower hinges) and \
         at {below:.6} m (platform below them); give home_height"
    )]
    EitherSide {
        /// Height of O with the platform above, m.
        above: f64,
        /// Height of O with the platform below, m.
        below: f64,
    },
    /// Home is out of reach.
    #[error(
        "home_height: at {height} m jack {jack} is {length:.4} m long, outside {min} to {max} m"
    )]
    HomeOutOfReach {
        /// Height of O at home, m.
        height: f64,
        /// The jack, 1 to 6.
        jack: usize,
        /// Its length at home, m.
        length: f64,
        /// `length_min`, m.
        min: f64,
        /// `length_max`, m.
        max: f64,
    },
    /// The jacks do not hold the platform at home.
    #[error(
        "lower, upper: the jacks do not determine the pose at home (singular Jacobian); check the hinges"
    )]
    Singular,
}

fn preset_names() -> String {
    let names: Vec<&str> = geometries::PRESETS.iter().map(|(name, _)| *name).collect();
    names.join(", ")
}
