//! One coefficient set: everything that the board keeps of a calibration.
//!
//! ```text
//! | postcard of the set | build of the firmware 8, if known | ratiometric channels u16 LE, if there are any | CRC-32 LE |
//! ```
//!
//! The CRC-32 (IEEE) is that of all before it. The identity of a set is the first eight bytes of the SHA-256 of all these
//! bytes: two sets with one identity have one content. A set is either read whole, with a matching checksum and usable
//! numbers, or not at all.

use core::fmt;

use nalgebra::{Matrix3, RealField, convert};
use serde::{Deserialize, Serialize};

use super::base::{BaseError, JackCoefficients, MotionBase};
use super::build::BuildId;
use crate::channel::{Ratiometric, Triad};
use crate::checksum::{checksum, sha256};
use crate::facts::SUPPLY_FACTORS;

/// Upper bound of the encoded length of a set, bytes: the longest has 621, 300 of them in the triads and 208 in base
/// and jacks. The archive gives each set a page of 2 KiB.
pub const MAX_ENCODED: usize = 640;
/// Longest geometry name, bytes of UTF-8.
pub const MAX_NAME: usize = 32;

/// Every value that a set can make is smaller than this, in m/s², rad/s² or rad/s, and every offset, in counts: a
/// thousand times what any sensor of a motion base measures, and fifteen times the largest count.
pub const MAX_VALUE: f32 = 1e6;

/// Identity of a set by its content.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, Default)]
pub struct SetId(pub [u8; 8]);

impl SetId {
    /// Identity of the encoded set with this SHA-256.
    #[must_use]
    pub fn of_digest(digest: &[u8; 32]) -> Self {
        let [a, b, c, d, e, f, g, h, ..] = *digest;
        Self([a, b, c, d, e, f, g, h])
    }
}

impl fmt::Display for SetId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for SetId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SetId({self})")
    }
}

/// Coefficients of one triad: value = matrix · (c·u − offset), see [`crate::sampling`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TriadCoefficients {
    /// Counts at zero input, at nominal supply.
    pub offset: [f32; 3],
    /// Physical unit per count; rows are output axes X, Y, Z.
    pub matrix: [[f32; 3]; 3],
    /// Standard uncertainty of `offset`, counts.
    pub offset_uncertainty: [f32; 3],
    /// Standard uncertainty of `matrix`, physical unit per count.
    pub matrix_uncertainty: [[f32; 3]; 3],
    /// Delay of the triad's signals behind the jack transducers', s.
    pub delay_s: f32,
}

/// A complete calibration result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CoefficientSet {
    /// Unique id of the microcontroller that the set was made for.
    pub board: [u8; 12],
    /// Name of the motion base's geometry.
    pub geometry: heapless::String<MAX_NAME>,
    /// First eight bytes of the SHA-256 of the geometry file.
    pub geometry_hash: [u8; 8],
    /// End of the campaign, seconds since 1970-01-01 UTC.
    pub unix_s: u64,
    /// Mean temperature of the board during the campaign, °C.
    pub temperature_c: f32,
    /// SHA-256 of what the campaign found it from: captures, jack programs, geometry file and sensor file.
    #[serde(deserialize_with = "crate::bytes::read")]
    pub provenance: [u8; 32],
    /// Linear acceleration, angular acceleration, angular rate.
    pub triads: [TriadCoefficients; 3],
    /// The motion base.
    pub base: MotionBase,
    /// Its jack transducers.
    pub jacks: JackCoefficients,
    /// The channels on which the supply factor does not act.
    #[serde(skip)]
    pub ratiometric: Ratiometric,
    /// The firmware that recorded the campaign; `None` for a campaign of firmware that did not know itself.
    #[serde(skip)]
    pub build: Option<BuildId>,
}

/// Why bytes are not a usable coefficient set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum RecordError {
    /// Shorter than a checksum, longer than any set, or cut off inside.
    #[error(
        "{length} bytes are not a coefficient set (at most {MAX_ENCODED}); it is cut off or something else"
    )]
    Length {
        /// Bytes given.
        length: u32,
    },
    /// The stored checksum is not that of the bytes.
    #[error("the checksum is {stored:08x} but the bytes give {computed:08x}; the set is damaged")]
    Checksum {
        /// The stored checksum.
        stored: u32,
        /// The checksum of the bytes.
        computed: u32,
    },
    /// The checksum fits, but the bytes are of another version of the record.
    #[error("the bytes are no coefficient set of this version")]
    Layout,
    /// An offset, matrix element, delay or uncertainty is NaN or infinite, or an uncertainty is negative.
    #[error("{triad:?} holds a number that is not finite, or a negative uncertainty")]
    NotFinite {
        /// The triad.
        triad: Triad,
    },
    /// A matrix that maps different counts to one value cannot be a calibration.
    #[error("the matrix of {triad:?} is singular")]
    Singular {
        /// The triad.
        triad: Triad,
    },
    /// Base or jack transducers are not usable.
    #[error(transparent)]
    Base(BaseError),
    /// The temperature of the calibration is NaN or infinite.
    #[error("the temperature of the calibration is not a finite number; calibrate again")]
    Temperature,
    /// An offset is too large, or a value at a count and a supply that the board can have. Such values may not be finite.
    #[error(
        "with the offsets and the matrix of {triad:?} a value can reach {MAX_VALUE:e} at a count from 0 to 65535, or an \
         offset does; calibrate again"
    )]
    Values {
        /// The triad.
        triad: Triad,
    },
}

impl CoefficientSet {
    /// Encodes the set with its checksum into `buffer` and returns the used part.
    ///
    /// # Errors
    /// [`RecordError::Length`] when `buffer` is too short ([`MAX_ENCODED`] always suffices).
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], RecordError> {
        let capacity = buffer.len();
        let too_short = RecordError::Length {
            length: capacity as u32,
        };
        let mut end = postcard::to_slice(self, buffer)
            .map_err(|_| too_short)?
            .len();
        if let Some(build) = &self.build {
            end = put(buffer, end, &build.0).ok_or(too_short)?;
        }
        if self.ratiometric != Ratiometric::NONE {
            let channels = self.ratiometric.bits().to_le_bytes();
            end = put(buffer, end, &channels).ok_or(too_short)?;
        }
        let sum = checksum(&buffer[..end]).to_le_bytes();
        end = put(buffer, end, &sum).ok_or(too_short)?;
        Ok(&buffer[..end])
    }

    /// Decodes and checks a set.
    ///
    /// # Errors
    /// Every variant of [`RecordError`].
    pub fn decode(bytes: &[u8]) -> Result<Self, RecordError> {
        let length = RecordError::Length {
            length: bytes.len() as u32,
        };
        if bytes.len() > MAX_ENCODED {
            return Err(length);
        }
        let (body, sum) = bytes.split_last_chunk::<4>().ok_or(length)?;
        let (stored, computed) = (u32::from_le_bytes(*sum), checksum(body));
        if stored != computed {
            return Err(RecordError::Checksum { stored, computed });
        }
        let (mut set, rest) =
            postcard::take_from_bytes::<Self>(body).map_err(|_| RecordError::Layout)?;
        let rest = match rest.split_first_chunk() {
            Some((build, rest)) => {
                set.build = Some(BuildId(*build));
                rest
            }
            None => rest,
        };
        set.ratiometric = match *rest {
            [] => Ratiometric::NONE,
            [low, high] => Ratiometric::from_bits(u16::from_le_bytes([low, high]))
                .filter(|channels| *channels != Ratiometric::NONE)
                .ok_or(RecordError::Layout)?,
            _ => return Err(RecordError::Layout),
        };
        set.check()?;
        Ok(set)
    }

    /// Identity of an encoded set.
    #[must_use]
    pub fn id_of(encoded: &[u8]) -> SetId {
        SetId::of_digest(&sha256(encoded))
    }

    /// Checks that the numbers are usable.
    ///
    /// # Errors
    /// [`RecordError::NotFinite`], [`RecordError::Singular`], [`RecordError::Values`], [`RecordError::Base`] and
    /// [`RecordError::Temperature`].
    pub fn check(&self) -> Result<(), RecordError> {
        for (triad, coefficients) in Triad::ALL.into_iter().zip(&self.triads) {
            coefficients.check(triad)?;
        }
        self.jacks.check().map_err(RecordError::Base)?;
        self.base.geometry().map_err(RecordError::Base)?;
        if !self.temperature_c.is_finite() {
            return Err(RecordError::Temperature);
        }
        Ok(())
    }
}

/// Puts `bytes` into `buffer` from `start` on and returns their end; `None` when it is too short.
fn put(buffer: &mut [u8], start: usize, bytes: &[u8]) -> Option<usize> {
    let end = start + bytes.len();
    buffer.get_mut(start..end)?.copy_from_slice(bytes);
    Some(end)
}

impl TriadCoefficients {
    fn check(&self, triad: Triad) -> Result<(), RecordError> {
        let values = self
            .offset
            .iter()
            .chain(self.matrix.iter().flatten())
            .chain([&self.delay_s]);
        let uncertainties = self
            .offset_uncertainty
            .iter()
            .chain(self.matrix_uncertainty.iter().flatten());
        if !values.clone().all(|value| value.is_finite())
            || !uncertainties.clone().all(|u| u.is_finite() && *u >= 0.0)
        {
            return Err(RecordError::NotFinite { triad });
        }
        let matrix = Matrix3::from_fn(|row, column| self.matrix[row][column]);
        if is_singular(&matrix) {
            return Err(RecordError::Singular { triad });
        }
        let values = self.matrix.iter().map(|row| self.largest(*row));
        let offsets = self.offset.iter().map(|offset| offset.abs());
        if values.chain(offsets).all(|number| number < MAX_VALUE) {
            Ok(())
        } else {
            Err(RecordError::Values { triad })
        }
    }

    /// A bound of what a row of the matrix makes of any counts at any supply that a working board can have: Σ |M|·|c·u − u0|,
    /// each the largest between u = 0 and u = 65535 at the largest c.
    #[must_use]
    pub fn largest(&self, row: [f32; 3]) -> f32 {
        let most = SUPPLY_FACTORS[1] * f32::from(u16::MAX);
        let products = row.iter().zip(&self.offset);
        products
            .map(|(element, offset)| element.abs() * offset.abs().max((most - offset).abs()))
            .sum()
    }
}

/// Whether a triad with this matrix, or with this inverse of it, cannot tell three axes apart. Sensors a few degrees
/// off their axes have |det| near (norm/√3)³; a matrix with a thousandth of that is singular in practice.
pub(crate) fn is_singular<T: RealField + Copy>(matrix: &Matrix3<T>) -> bool {
    let scaled = matrix / matrix.amax();
    let scale = scaled.norm();
    let volume = scaled.determinant().abs();
    let singular = volume <= scale * scale * scale * convert(1e-4);
    singular || !volume.is_finite()
}
