//! Calibrated values of every scan.
//!
//! Each triad has an offset u0 (counts at zero input) and a full 3×3 matrix M (physical unit per count):
//!
//! ```text
//! value = M · (c·u − u0)          c = VDDA / 3.300 V, the supply factor
//!       = (c·M) · (u − u0/c)
//! ```
//!
//! A converter measures against its supply, so a supply that rises by 0.1 % lowers every count by 0.1 %. The board
//! measures its supply against the chip's reference; c gives counts the same meaning at every supply. c changes seldom,
//! so c·M and u0/c are [`Prepared`] at each change. A scan then costs one subtraction for each channel and one product
//! for each matrix element.
//!
//! Board and host compute in `f32` in the order written here and round after every operation. So a host with the raw
//! counts, the supply factor and the active set recomputes the board's values bit for bit.

use crate::channel::{INERTIAL, Ratiometric, Scan, Triad};
use crate::records::{CoefficientSet, TriadCoefficients};

/// Calibrated values of one scan: m/s², rad/s², rad/s, in the order of [`crate::channel::NAMES`].
pub type Values = [f32; INERTIAL];

const TRIADS: usize = Triad::ALL.len();

/// Offset (counts) and matrix (physical unit per count) of one triad.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TriadMap {
    offset: [f32; 3],
    matrix: [[f32; 3]; 3],
}

impl TriadMap {
    #[inline(always)]
    fn apply(&self, counts: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = [
            counts[0] - self.offset[0],
            counts[1] - self.offset[1],
            counts[2] - self.offset[2],
        ];
        let row = |[a, b, c]: [f32; 3]| a * x + b * y + c * z;
        let [first, second, third] = self.matrix;
        [row(first), row(second), row(third)]
    }

    /// Values and sums of the channels from `FIRST` on in one scan.
    #[inline(always)]
    fn take<const FIRST: usize>(
        &self,
        scan: &[u16; INERTIAL],
        values: &mut Values,
        sums: &mut [u32; 3],
    ) {
        let (x, y, z) = (scan[FIRST], scan[FIRST + 1], scan[FIRST + 2]);
        sums[0] += u32::from(x);
        sums[1] += u32::from(y);
        sums[2] += u32::from(z);
        let [x, y, z] = self.apply([x.into(), y.into(), z.into()]);
        values[FIRST] = x;
        values[FIRST + 1] = y;
        values[FIRST + 2] = z;
    }
}

/// The coefficients of a set, at the nominal supply.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrator {
    triads: [TriadMap; TRIADS],
    ratiometric: Ratiometric,
}

impl Calibrator {
    /// Takes the offsets and matrices out of a coefficient set.
    #[must_use]
    pub fn new(set: &CoefficientSet) -> Self {
        Self::of_triads(&set.triads, set.ratiometric)
    }

    /// As [`Self::new`], from the triads of a set and its ratiometric channels.
    #[must_use]
    pub fn of_triads(triads: &[TriadCoefficients; TRIADS], ratiometric: Ratiometric) -> Self {
        Self {
            ratiometric,
            triads: triads.each_ref().map(|triad| TriadMap {
                offset: triad.offset,
                matrix: triad.matrix,
            }),
        }
    }

    /// The coefficients for the sample path at supply factor `supply` (dimensionless, about 1). Each channel is a column of
    /// the matrix; the factor of a ratiometric one is 1.
    #[must_use]
    pub fn at_supply(&self, supply: f32) -> Prepared {
        let mut triads = self.triads;
        for (index, triad) in triads.iter_mut().enumerate() {
            let factors = [0, 1, 2].map(|axis| self.ratiometric.factor(3 * index + axis, supply));
            for (offset, factor) in triad.offset.iter_mut().zip(factors) {
                *offset /= factor;
            }
            for row in &mut triad.matrix {
                row.iter_mut()
                    .zip(factors)
                    .for_each(|(element, factor)| *element *= factor);
            }
        }
        Prepared { triads }
    }

    /// Calibrated values of one scan taken at supply factor `supply`; for many scans prepare once.
    #[must_use]
    pub fn apply(&self, scan: &Scan, supply: f32) -> Values {
        self.at_supply(supply)
            .apply(&core::array::from_fn(|channel| scan[channel]))
    }
}

/// Coefficients at one supply: c·M and u0/c of each triad.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    triads: [TriadMap; TRIADS],
}

impl Prepared {
    /// Without a set every value is zero; the work is the same.
    pub const NONE: Self = Self {
        triads: [TriadMap {
            offset: [0.0; 3],
            matrix: [[0.0; 3]; 3],
        }; TRIADS],
    };

    /// A checksum over all coefficients, which any one wrong bit changes.
    #[must_use]
    pub fn checksum(&self) -> u32 {
        let triads = self.triads.iter();
        let numbers =
            triads.flat_map(|triad| triad.offset.iter().chain(triad.matrix.as_flattened()));
        numbers.fold(0, |sum: u32, number| sum.rotate_left(1) ^ number.to_bits())
    }

    /// Calibrated values of one scan's inertial channels.
    #[must_use]
    pub fn apply(&self, scan: &[u16; INERTIAL]) -> Values {
        let mut values = [0.0; INERTIAL];
        for (index, triad) in self.triads.iter().enumerate() {
            let counts = [0, 1, 2].map(|axis| f32::from(scan[3 * index + axis]));
            values[3 * index..3 * index + 3].copy_from_slice(&triad.apply(counts));
        }
        values
    }

    /// Calibrated values of all scans of a block, and the sum of each channel over it (counts), the same work for
    /// every input.
    ///
    /// Scans beyond the end of `values` are left out of both results. One triad at a time goes through the whole block,
    /// so that its twelve coefficients stay in registers.
    #[inline(never)]
    pub fn block(
        &self,
        scans: &[[u16; INERTIAL]],
        values: &mut [Values],
        sums: &mut [u32; INERTIAL],
    ) {
        let both = scans.len().min(values.len());
        let (Some(scans), Some(values)) = (scans.get(..both), values.get_mut(..both)) else {
            return;
        };
        self.triad::<0>(scans, values, sums);
        self.triad::<3>(scans, values, sums);
        self.triad::<6>(scans, values, sums);
    }

    #[inline(always)]
    fn triad<const FIRST: usize>(
        &self,
        scans: &[[u16; INERTIAL]],
        values: &mut [Values],
        sums: &mut [u32; INERTIAL],
    ) {
        let triad = self.triads[FIRST / 3];
        let mut totals = [0_u32; 3];
        // Two scans in a turn: a turn costs a seventh of the work on a scan when the code is built for size.
        let (pairs, rest) = scans.as_chunks::<2>();
        let (value_pairs, value_rest) = values.as_chunks_mut::<2>();
        for ([values, next_values], [scan, next]) in value_pairs.iter_mut().zip(pairs) {
            triad.take::<FIRST>(scan, values, &mut totals);
            triad.take::<FIRST>(next, next_values, &mut totals);
        }
        if let ([scan], [values]) = (rest, value_rest) {
            triad.take::<FIRST>(scan, values, &mut totals);
        }
        [sums[FIRST], sums[FIRST + 1], sums[FIRST + 2]] = totals;
    }
}
