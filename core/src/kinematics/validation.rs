//! Which numbers describe a motion base.
//!
//! Where the home height h is not given it is the height at which the jacks are at mid-stroke. With a_k − b_k split
//! into a horizontal part r_k and a vertical part c_k = b_ky − a_ky,
//!
//! ```text
//! l_k² = r_k² + (h + c_k)²       mean over k:  h² + 2·h·c̄ + mean(r_k² + c_k²) = l_mid²
//! ```
//!
//! which is exact for every jack of a symmetric base, and for the mean square of the lengths of any other. One solution has
//! the platform above its lower hinges, the other has it below them.

use core::fmt;

use nalgebra::{RealField, Vector3, convert};
use thiserror::Error;

use super::{geometry::Geometry, inverse::inverse, jacobian::condition_bound};

/// [Bound](condition_bound) of the condition number of the Jacobian at home beyond which a set of hinges is refused:
/// such a base does not hold its platform. Real bases in metres stay far below.
pub const MAX_HOME_CONDITION: f64 = 1e6;

/// One number of a geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GeometryItem {
    /// Lower hinge of this jack, 1..=6.
    LowerHinge(u8),
    /// Upper hinge of this jack, 1..=6.
    UpperHinge(u8),
    /// Shortest length.
    LengthMin,
    /// Greatest length.
    LengthMax,
    /// Home height.
    HomeHeight,
}

impl fmt::Display for GeometryItem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LowerHinge(jack) => write!(f, "the lower hinge of jack {jack}"),
            Self::UpperHinge(jack) => write!(f, "the upper hinge of jack {jack}"),
            Self::LengthMin => f.write_str("length_min"),
            Self::LengthMax => f.write_str("length_max"),
            Self::HomeHeight => f.write_str("home_height"),
        }
    }
}

/// Why numbers do not describe a motion base.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum GeometryError<T: RealField + Copy> {
    /// A number is infinite or not a number.
    #[error("{item} is {value}: give a finite number of metres")]
    NotFinite {
        /// What is not finite.
        item: GeometryItem,
        /// Its value.
        value: T,
    },
    /// A length cannot be negative.
    #[error(
        "length_min is {length_min} m, less than 0: give the hinge-to-hinge length of the retracted jack"
    )]
    NegativeLength {
        /// The shortest length given, m.
        length_min: T,
    },
    /// The jacks could not move.
    #[error(
        "length_min, {length_min} m, is not less than length_max, {length_max} m: the jacks have no stroke"
    )]
    NoStroke {
        /// The shortest length given, m.
        length_min: T,
        /// The greatest length given, m.
        length_max: T,
    },
    /// No home height was given and at no height are the jacks at mid-stroke.
    #[error(
        "no height brings the jacks to mid-stroke, {mid_length} m: at the best height they are {shortest} m long; check the hinges and the stroke or give home_height"
    )]
    HomeUnreachable {
        /// Half of length_min + length_max, m.
        mid_length: T,
        /// Root mean square of the lengths at the height where it is least, m.
        shortest: T,
    },
    /// At home a jack would be outside its stroke.
    #[error(
        "at the home height of {home_height:.4} m jack {jack} would be {length:.4} m long, outside its stroke of {length_min} m to {length_max} m: give home_height, or correct it, so that all six jacks are inside their stroke; check the unit and the axes of the hinges"
    )]
    HomeOutsideStroke {
        /// The jack, 1..=6.
        jack: u8,
        /// Home height, given or found, m.
        home_height: T,
        /// Its length at home, m.
        length: T,
        /// The shortest length, m.
        length_min: T,
        /// The greatest length, m.
        length_max: T,
    },
    /// The platform can move at home while all jacks stand still.
    #[error(
        "at the home height of {home_height} m the condition number of the Jacobian is about {condition_bound}, over {MAX_HOME_CONDITION}: these hinges do not hold the platform"
    )]
    HomeSingular {
        /// Home height, given or found, m.
        home_height: T,
        /// Bound of the condition number of the Jacobian at home.
        condition_bound: T,
    },
}

impl<T: RealField + Copy> Geometry<T> {
    /// A base with hinges `lower` (earth frame) and `upper` (body frame), axes with Y up, and hinge-to-hinge lengths
    /// from `length_min_m` to `length_max_m`; all in metres. Without `home_height_m`, home is at mid-stroke with the
    /// platform above its lower hinges.
    ///
    /// # Errors
    /// Everything that [`GeometryError`] names. A home height given as a rounded number may put home off mid-stroke,
    /// but not outside the stroke.
    pub fn new(
        lower: [Vector3<T>; 6],
        upper: [Vector3<T>; 6],
        length_min_m: T,
        length_max_m: T,
        home_height_m: Option<T>,
    ) -> Result<Self, GeometryError<T>> {
        check_finite(&lower, GeometryItem::LowerHinge)?;
        check_finite(&upper, GeometryItem::UpperHinge)?;
        finite(length_min_m, GeometryItem::LengthMin)?;
        finite(length_max_m, GeometryItem::LengthMax)?;
        if length_min_m < T::zero() {
            return Err(GeometryError::NegativeLength {
                length_min: length_min_m,
            });
        }
        if length_min_m >= length_max_m {
            return Err(GeometryError::NoStroke {
                length_min: length_min_m,
                length_max: length_max_m,
            });
        }
        let half: T = convert(0.5);
        let home_height_m = match home_height_m {
            Some(height) => finite(height, GeometryItem::HomeHeight)?,
            None => {
                Self::mid_stroke_heights(&lower, &upper, (length_min_m + length_max_m) * half)?[0]
            }
        };
        let geometry = Self {
            lower,
            upper,
            length_min_m,
            length_max_m,
            home_height_m,
        };
        geometry.check_home()?;
        Ok(geometry)
    }

    /// The two heights of O at which the jacks are `mid_length` long, m, as far as the module's text says: with the
    /// platform above its lower hinges, and below them.
    ///
    /// # Errors
    /// [`GeometryError::HomeUnreachable`].
    pub fn mid_stroke_heights(
        lower: &[Vector3<T>; 6],
        upper: &[Vector3<T>; 6],
        mid_length: T,
    ) -> Result<[T; 2], GeometryError<T>> {
        let sixth: T = convert(1.0 / 6.0);
        let mut offset = T::zero();
        let mut square = T::zero();
        for (a, b) in lower.iter().zip(upper) {
            offset += (b.y - a.y) * sixth;
            square += (b - a).norm_squared() * sixth;
        }
        let least_square = square - offset * offset;
        let height_squared = mid_length * mid_length - least_square;
        if height_squared > T::zero() {
            let height = height_squared.sqrt();
            Ok([height - offset, -height - offset])
        } else {
            Err(GeometryError::HomeUnreachable {
                mid_length,
                shortest: least_square.sqrt(),
            })
        }
    }

    fn check_home(&self) -> Result<(), GeometryError<T>> {
        let home = self.home();
        // A home on the stops is inside, with four units in the last place for what its lengths are computed with.
        let spare = T::default_epsilon() * self.length_max_m * convert(4.0);
        let stroke = self.length_min_m - spare..=self.length_max_m + spare;
        for (jack, length) in (1..).zip(inverse(self, &home)) {
            if !stroke.contains(&length) {
                return Err(GeometryError::HomeOutsideStroke {
                    jack,
                    home_height: self.home_height_m,
                    length,
                    length_min: self.length_min_m,
                    length_max: self.length_max_m,
                });
            }
        }
        let condition_bound = condition_bound(self, &home);
        let holds = condition_bound <= convert(MAX_HOME_CONDITION);
        if !holds {
            return Err(GeometryError::HomeSingular {
                home_height: self.home_height_m,
                condition_bound,
            });
        }
        Ok(())
    }
}

fn finite<T: RealField + Copy>(value: T, item: GeometryItem) -> Result<T, GeometryError<T>> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(GeometryError::NotFinite { item, value })
    }
}

fn check_finite<T: RealField + Copy>(
    hinges: &[Vector3<T>; 6],
    item: fn(u8) -> GeometryItem,
) -> Result<(), GeometryError<T>> {
    for (jack, hinge) in (1..).zip(hinges) {
        for &value in hinge.iter() {
            finite(value, item(jack))?;
        }
    }
    Ok(())
}
