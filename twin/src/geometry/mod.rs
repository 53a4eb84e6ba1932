//! The geometry file: the hinges of a motion base and the limits of its jacks.
//!
//! TOML. Lengths are from hinge centre to hinge centre; lower hinges in the earth frame, upper hinges in the body
//! frame, one triple per jack in the order of the jacks:
//!
//! | key | meaning |
//! |---|---|
//! | `name`, `note` | what the base is, and what is assumed about it |
//! | `axes` | `"y-up"`: X forward, Y up, Z right. `"z-up"`: X forward, Y left, Z up; read as (x, z, −y). `"z-down"`: X forward, Y right, Z down; read as (x, −z, y) |
//! | `units` | `"m"`, also if left out, or `"mm"`: of all lengths, speeds and accelerations |
//! | `lower`, `upper` | `[[x, y, z]; 6]` |
//! | `length_min`, `length_max` | shortest and longest jack |
//! | `home_height` | height of O at home, upwards; if left out, where every jack is at mid-length, which must be on one side only |
//! | `hinge_tolerance` | 1σ of each coordinate of a hinge against this file; 0.5 mm if left out |
//! | `speed_max`, `acceleration_max` | limits of a jack, per s and s²; none if left out |
//! | `lower_hinge_angle_max_deg`, `upper_hinge_angle_max_deg` | read by planners; the hinges of the twin turn freely |

mod error;
mod file;

pub use error::GeometryError;
use error::MID_LENGTH_TOLERANCE_M;
use file::{File, MAX_COORDINATE_M, hinges, in_range, stroke};

use crate::algebra::{Rotation, Vec3};
use crate::mechanism::{Mechanism, Pose};
use crate::random::Stream;

/// 1σ of a hinge coordinate where the file does not say, m.
const DEFAULT_HINGE_TOLERANCE_M: f64 = 0.0005;

/// A motion base as its geometry file describes it.
#[derive(Debug, Clone)]
pub struct Geometry {
    /// Name of the base.
    pub name: String,
    /// Nominal hinges.
    pub nominal: Mechanism,
    /// Shortest and longest jack, m.
    pub length_m: [f64; 2],
    /// Pose at home: level, O above the origin.
    pub home: Pose,
    /// Standard deviation of each coordinate of a true hinge about the nominal one, m.
    pub hinge_tolerance_m: f64,
    /// Highest speed of a jack, m/s.
    pub speed_max_m_s: Option<f64>,
    /// Highest acceleration of a jack, m/s².
    pub acceleration_max_m_s2: Option<f64>,
}

impl Geometry {
    /// Reads the preset of this name, or else the file at this path.
    ///
    /// # Errors
    /// [`GeometryError`], with the preset or path in front.
    pub fn load(name_or_path: &str) -> Result<Self, GeometryError> {
        let preset = geometries::PRESETS
            .iter()
            .find(|(name, _)| *name == name_or_path);
        let text = match preset {
            Some((_, text)) => (*text).to_owned(),
            None => {
                std::fs::read_to_string(name_or_path).map_err(|source| GeometryError::NotFound {
                    name: name_or_path.to_owned(),
                    source,
                })?
            }
        };
        Self::parse(&text).map_err(|source| GeometryError::InFile {
            file: name_or_path.to_owned(),
            source: Box::new(source),
        })
    }

    /// Reads the text of a geometry file.
    ///
    /// # Errors
    /// [`GeometryError`] for anything that is not a motion base that can stand at home.
    pub fn parse(text: &str) -> Result<Self, GeometryError> {
        let file = toml::from_str::<File>(text)?.in_metres();
        let nominal = Mechanism {
            lower: hinges("lower", &file.lower, &file.axes)?,
            upper: hinges("upper", &file.upper, &file.axes)?,
        };
        let length_m = stroke(&file)?;
        let height = match file.home_height {
            Some(height) => in_range("home_height", height, -MAX_COORDINATE_M, MAX_COORDINATE_M)?,
            None => home_height(&nominal, length_m)?,
        };
        let home = level_at(height);
        check_home(&nominal, &home, length_m)?;
        let limit = |key: &str, value: Option<f64>| {
            value
                .map(|value| in_range(key, value, 1e-6, 1e6))
                .transpose()
        };
        Ok(Self {
            name: file.name,
            nominal,
            length_m,
            home,
            hinge_tolerance_m: in_range(
                "hinge_tolerance",
                file.hinge_tolerance.unwrap_or(DEFAULT_HINGE_TOLERANCE_M),
                0.0,
                0.01,
            )?,
            speed_max_m_s: limit("speed_max", file.speed_max)?,
            acceleration_max_m_s2: limit("acceleration_max", file.acceleration_max)?,
        })
    }

    /// The mechanism with the true hinges under a seed.
    #[must_use]
    pub fn true_mechanism(&self, seed: u64) -> Mechanism {
        let displaced = |plane: &str, hinges: &[Vec3; 6]| -> [Vec3; 6] {
            std::array::from_fn(|k| {
                let mut stream = Stream::new(seed, &format!("hinge.{plane}.{}", k + 1));
                let error = std::array::from_fn(|_| self.hinge_tolerance_m * stream.normal());
                hinges[k] + Vec3(error)
            })
        };
        Mechanism {
            lower: displaced("lower", &self.nominal.lower),
            upper: displaced("upper", &self.nominal.upper),
        }
    }

    /// Length from which displacements count, m: the mean of the shortest and the longest.
    #[must_use]
    pub fn mid_length_m(&self) -> f64 {
        0.5 * (self.length_m[0] + self.length_m[1])
    }

    /// Stroke of a jack, m.
    #[must_use]
    pub fn stroke_m(&self) -> f64 {
        self.length_m[1] - self.length_m[0]
    }

    /// Displacements from mid-stroke of the six jacks at home, m.
    #[must_use]
    pub fn home_displacements_m(&self) -> [f64; 6] {
        self.nominal
            .lengths(&self.home)
            .map(|length| length - self.mid_length_m())
    }
}

/// The pose straight above or below the origin.
fn level_at(height: f64) -> Pose {
    Pose {
        position_m: Vec3([0.0, height, 0.0]),
        attitude: Rotation::LEVEL,
    }
}

/// The height of home where the file does not give one.
fn home_height(nominal: &Mechanism, length_m: [f64; 2]) -> Result<f64, GeometryError> {
    let mid = 0.5 * (length_m[0] + length_m[1]);
    let on_side = |side| {
        let height = mid_height(nominal, mid, side)?;
        check_home(nominal, &level_at(height), length_m).map(|()| height)
    };
    match (on_side(1.0), on_side(-1.0)) {
        (Ok(above), Ok(below)) => Err(GeometryError::EitherSide { above, below }),
        (Ok(height), Err(_)) | (Err(_), Ok(height)) => Ok(height),
        (Err(error), Err(_)) => Err(error),
    }
}

/// The height at which all jacks have the length `mid`, with the platform on one side of the lower hinges: 1 above,
/// −1 below.
fn mid_height(nominal: &Mechanism, mid: f64, side: f64) -> Result<f64, GeometryError> {
    let mut sum = 0.0;
    for (lower, upper) in nominal.lower.iter().zip(&nominal.upper) {
        let [x, rise, z] = (*upper - *lower).0;
        sum += side * (mid * mid - x * x - z * z).max(0.0).sqrt() - rise;
    }
    let height = sum / 6.0;
    for (jack, length) in nominal.lengths(&level_at(height)).into_iter().enumerate() {
        let off = length - mid;
        if off.abs() > MID_LENGTH_TOLERANCE_M {
            return Err(GeometryError::NoMidHeight {
                mid,
                jack: jack + 1,
                off,
            });
        }
    }
    Ok(height)
}

fn check_home(nominal: &Mechanism, home: &Pose, [min, max]: [f64; 2]) -> Result<(), GeometryError> {
    for (jack, length) in nominal.lengths(home).into_iter().enumerate() {
        if !(min..=max).contains(&length) {
            return Err(GeometryError::HomeOutOfReach {
                height: home.position_m.0[1],
                jack: jack + 1,
                length,
                min,
                max,
            });
        }
    }
    nominal
        .linearised(home)
        .map(|_| ())
        .map_err(|_| GeometryError::Singular)
}
