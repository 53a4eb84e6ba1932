//! From counts to calibrated values, in fixed time.
//!
//! Each triad has an offset u0 (counts at zero input) and a full 3×3 matrix M (physical unit per count):
//!
//! ```text
//! value = M · (c·u − u0)          c = VDDA / 3.300 V, the supply factor
//! ```
//!
//! A converter measures against its supply, so a supply that rises by 0.1 % lowers every count by 0.1 %. The board
//! measures its supply against the chip's reference and multiplies each count by c, which makes counts mean the
//! same at every supply. The work is the same for every input: no branch, no division, no table.
//!
//! Board and host compute in `f32` in the order written here, so that a host that has the raw counts, the supply
//! factor and the active set recomputes the board's values bit for bit.

use nalgebra::{Matrix3, Vector3};

use crate::channel::{INERTIAL, Scan, Triad};
use crate::store::CoefficientSet;

/// Scans that are handled together: one half of the converter's ring buffer.
pub const BLOCK: usize = 16;
/// Scan rates that the board offers, Hz.
pub const RATES_HZ: [u32; 3] = [1_000, 2_000, 4_000];
/// Supply at which the supply factor is one, V.
pub const NOMINAL_SUPPLY_V: f32 = 3.3;

/// From one rank of a scan to the next, ns: sixteen conversions of 60 cycles at 37.5 MHz.
pub const RANK_NS: u32 = 25_600;

/// Instant at which a channel (0 to 14) is sampled, s after the trigger of its scan: the middle of its sixteen
/// conversions. The inertial channels are ranks 0 to 8 of one converter, the jacks ranks 0 to 5 of another.
#[must_use]
pub fn instant_s(channel: usize) -> f64 {
    let rank = channel.checked_sub(INERTIAL).unwrap_or(channel);
    (rank as f64 + 0.5) * f64::from(RANK_NS) * 1e-9
}

/// Calibrated values of one scan: m/s², rad/s², rad/s, in the order of [`crate::channel::NAMES`].
pub type Values = [f32; INERTIAL];

/// The coefficients in the form that the sample path uses.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrator {
    matrices: [Matrix3<f32>; 3],
    offsets: [Vector3<f32>; 3],
}

impl Calibrator {
    /// Takes the offsets and matrices out of a coefficient set.
    #[must_use]
    pub fn new(set: &CoefficientSet) -> Self {
        Self {
            matrices: set
                .triads
                .each_ref()
                .map(|triad| Matrix3::from_fn(|row, column| triad.matrix[row][column])),
            offsets: set
                .triads
                .each_ref()
                .map(|triad| Vector3::from(triad.offset)),
        }
    }

    /// Calibrated values of one scan taken at supply factor `supply` (dimensionless, about 1).
    #[must_use]
    pub fn apply(&self, scan: &Scan, supply: f32) -> Values {
        let mut values = [0.0; INERTIAL];
        for triad in Triad::ALL {
            let first = triad.first_channel();
            let counts = Vector3::new(
                f32::from(scan[first]),
                f32::from(scan[first + 1]),
                f32::from(scan[first + 2]),
            );
            let value =
                self.matrices[triad.index()] * (counts * supply - self.offsets[triad.index()]);
            values[first..first + 3].copy_from_slice(value.as_slice());
        }
        values
    }
}
