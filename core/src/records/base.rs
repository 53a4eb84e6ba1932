//! The motion base and its jack transducers in a coefficient set.
//!
//! With both, the board finds its pose by itself ([`crate::live_pose`]). Hinges and lengths have the single precision
//! in which the board computes: rounding moves a hinge by a tenth of a micrometre at most, a five thousandth of its
//! uncertainty.
//!
//! ```text
//! l_k = l° + m_k · (c·u_k − u°_k)      length of jack k, m, from its counts u_k at supply factor c
//! ```

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::channel::JACKS;
use crate::kinematics::{Geometry, GeometryError};

/// Hinges, stroke and home of a motion base, m; axes with Y up, see [`crate::kinematics::geometry`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MotionBase {
    /// Lower hinge of each jack in the earth frame.
    pub lower: [[f32; 3]; JACKS],
    /// Upper hinge of each jack in the body frame.
    pub upper: [[f32; 3]; JACKS],
    /// Shortest hinge-to-hinge length.
    pub length_min_m: f32,
    /// Greatest hinge-to-hinge length.
    pub length_max_m: f32,
    /// Height of O at home above the origin of the earth frame.
    pub home_height_m: f32,
}

/// Coefficients of the jack displacement transducers: length = zero length + metres per count · (c·u − zero counts).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JackCoefficients {
    /// Length at which the zero counts are read, hinge to hinge, m.
    pub zero_length_m: f32,
    /// Counts at that length, at nominal supply.
    pub zero_counts: [f32; JACKS],
    /// Change of length per count, m; negative for a transducer that counts down.
    pub metres_per_count: [f32; JACKS],
}

/// Why base and transducers do not give a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum BaseError {
    /// A hinge, a length or the home height is NaN or infinite.
    #[error(
        "a hinge, a length or the home height is not a finite number; calibrate with a good geometry file"
    )]
    NotFinite,
    /// The shortest length is negative or not less than the greatest.
    #[error(
        "the jacks have no stroke: 0 ≤ length_min < length_max must hold; correct the geometry file and calibrate"
    )]
    Stroke,
    /// At home a jack is outside its stroke.
    #[error(
        "jack {jack} is outside its stroke at home; correct home_height in the geometry file and calibrate"
    )]
    Home {
        /// The jack, 1 to 6.
        jack: u8,
    },
    /// The hinges do not hold the platform at home, such as when too many of them coincide.
    #[error(
        "the hinges do not hold the platform at home; correct them in the geometry file and calibrate"
    )]
    Degenerate,
    /// A transducer's zero is not finite, or its metres per count are zero or not finite.
    #[error(
        "the transducer of jack {jack} has no usable coefficients; correct [jacks] in the sensor file and calibrate"
    )]
    Transducer {
        /// The jack, 1 to 6.
        jack: u8,
    },
}

impl MotionBase {
    /// `geometry` as the board stores it. The stroke is rounded outwards, so that a base with its home on its stops
    /// stays valid.
    #[must_use]
    pub fn new(geometry: &Geometry<f64>) -> Self {
        let single = |hinge: &Vector3<f64>| [hinge.x as f32, hinge.y as f32, hinge.z as f32];
        Self {
            lower: geometry.lower().each_ref().map(single),
            upper: geometry.upper().each_ref().map(single),
            length_min_m: (geometry.length_min_m() as f32).next_down().max(0.0),
            length_max_m: (geometry.length_max_m() as f32).next_up(),
            home_height_m: geometry.home_height_m() as f32,
        }
    }

    /// The geometry with these numbers, checked in single precision, as on the board.
    ///
    /// # Errors
    /// Every variant of [`BaseError`] but `Transducer`.
    pub fn geometry(&self) -> Result<Geometry<f32>, BaseError> {
        Geometry::new(
            self.lower.map(Vector3::from),
            self.upper.map(Vector3::from),
            self.length_min_m,
            self.length_max_m,
            Some(self.home_height_m),
        )
        .map_err(|error| match error {
            GeometryError::NotFinite { .. } => BaseError::NotFinite,
            GeometryError::NegativeLength { .. } | GeometryError::NoStroke { .. } => {
                BaseError::Stroke
            }
            GeometryError::HomeOutsideStroke { jack, .. } => BaseError::Home { jack },
            GeometryError::HomeUnreachable { .. } | GeometryError::HomeSingular { .. } => {
                BaseError::Degenerate
            }
        })
    }
}

impl JackCoefficients {
    /// Checks that the numbers are usable.
    ///
    /// # Errors
    /// [`BaseError::NotFinite`] and [`BaseError::Transducer`].
    pub fn check(&self) -> Result<(), BaseError> {
        if !self.zero_length_m.is_finite() {
            return Err(BaseError::NotFinite);
        }
        let transducers = self.zero_counts.iter().zip(&self.metres_per_count);
        for ((zero, metres), jack) in transducers.zip(1..) {
            if !zero.is_finite() || !metres.is_finite() || *metres == 0.0 {
                return Err(BaseError::Transducer { jack });
            }
        }
        Ok(())
    }
}
