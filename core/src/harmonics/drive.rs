//! The order to an analyser: a frequency, a block, and the blocks to settle and to sum.

use serde::{Deserialize, Serialize};

use super::HARMONICS;
use crate::sampling::BlockSize;

/// Largest number of summed blocks: beyond it the sums of full-scale blocks could overflow. So many may settle too: with
/// single scans at 4 kHz that is more than eight minutes.
pub const MAX_BLOCKS: u32 = 1 << 21;
/// Bits of the number of places that the drift sum tells apart.
const PLACES_BITS: u32 = 12;
/// One turn of phase.
const TURN: f64 = 18_446_744_073_709_551_616.0;

/// One drive frequency, with its window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Drive {
    /// Phase advance for each scan, in turns · 2⁶⁴: f / (scan rate) · 2⁶⁴, see [`increment`].
    pub increment: u64,
    /// Scans that are added up before they meet sine and cosine.
    pub block: BlockSize,
    /// Blocks that pass before summing, at most [`MAX_BLOCKS`].
    pub settle_blocks: u32,
    /// Blocks to sum over.
    pub blocks: u32,
}

impl Drive {
    /// Checks whether the drive can be estimated.
    ///
    /// # Errors
    /// [`DriveError`], which names the value beyond its limit.
    pub const fn check(&self) -> Result<(), DriveError> {
        if self.increment == 0 || self.increment >= increment_limit(BlockSize::One) {
            return Err(DriveError::Frequency);
        }
        if self.increment >= increment_limit(self.block) {
            return Err(DriveError::FifthHarmonic {
                scans: self.block.scans() as u8,
            });
        }
        if self.blocks == 0 || self.blocks > MAX_BLOCKS {
            return Err(DriveError::Blocks {
                blocks: self.blocks,
            });
        }
        if self.settle_blocks > MAX_BLOCKS {
            return Err(DriveError::Settle {
                blocks: self.settle_blocks,
            });
        }
        Ok(())
    }

    /// Drive frequency, Hz, at a scan rate of `rate_hz`.
    #[must_use]
    pub fn frequency_hz(&self, rate_hz: u32) -> f64 {
        self.increment as f64 / TURN * f64::from(rate_hz)
    }

    /// Radians for each scan.
    pub(super) fn omega(&self) -> f64 {
        core::f64::consts::TAU * (self.increment as f64 / TURN)
    }

    /// Phase at the centre of block `block`, counted from the first summed one; scan 0 of block 0 has phase zero.
    pub(super) fn centre_phase(&self, block: u32) -> u64 {
        let scans = self.block.scans() as u64;
        let to_centre = (self.increment >> 1).wrapping_mul(scans - 1);
        self.increment
            .wrapping_mul(u64::from(block) * scans)
            .wrapping_add(to_centre)
    }

    /// Places in the window that the drift sum tells apart.
    pub(super) fn places(&self) -> u32 {
        self.place(self.blocks.saturating_sub(1)) + 1
    }

    /// Place of block `block` in the window for the drift sum: the number of the block, shifted right so that 4096
    /// places are enough.
    pub(super) fn place(&self, block: u32) -> u32 {
        let bits = u32::BITS - self.blocks.saturating_sub(1).leading_zeros();
        block >> bits.saturating_sub(PLACES_BITS)
    }
}

/// Least phase advance for each scan with which the fifth harmonic turns by half a turn or more in a block, in turns ·
/// 2⁶⁴: 5f·B / rate = ½.
const fn increment_limit(block: BlockSize) -> u64 {
    u64::MAX / (2 * HARMONICS as u64 * block.scans() as u64)
}

/// Why a drive cannot be estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum DriveError {
    /// Not above zero, or so high that even single scans cannot hold five harmonics.
    #[error(
        "the drive frequency must be above zero and below a tenth of the scan rate; choose another or scan faster"
    )]
    Frequency,
    /// The fifth harmonic turns by half a turn or more in one block.
    #[error(
        "the fifth harmonic of the drive frequency is too fast for blocks of {scans} scans; choose smaller blocks or scan faster"
    )]
    FifthHarmonic {
        /// Scans of a block.
        scans: u8,
    },
    /// No blocks to sum over, or so many that sums could overflow.
    #[error("a sum over {blocks} blocks is not possible; sum over 1 to {MAX_BLOCKS}")]
    Blocks {
        /// The requested number.
        blocks: u32,
    },
    /// More blocks to settle than the analyser counts.
    #[error(
        "{blocks} blocks cannot settle; let at most {MAX_BLOCKS} pass, and set the drive later"
    )]
    Settle {
        /// The requested number.
        blocks: u32,
    },
}

/// Phase advance for each scan of `frequency_hz` at `rate_hz`, in turns · 2⁶⁴.
///
/// The frequency is the exact number in the `f64`, and the quotient is cut off at 2⁻⁶⁴ of a turn: after 2.4 million
/// scans (ten minutes at 4 kHz) the phase is off by less than 1e-12 rad. `None` when the frequency is not above zero,
/// or is half the rate or more, or the rate is zero.
#[must_use]
pub fn increment(frequency_hz: f64, rate_hz: u32) -> Option<u64> {
    let possible = frequency_hz > 0.0 && frequency_hz < f64::from(rate_hz) / 2.0;
    if !possible {
        return None;
    }
    const MANTISSA_BITS: u32 = 52;
    const BIAS: i32 = 1023;
    let bits = frequency_hz.to_bits();
    let exponent = (bits >> MANTISSA_BITS) as i32 - BIAS - MANTISSA_BITS as i32;
    let mantissa = u128::from(bits & ((1 << MANTISSA_BITS) - 1) | 1 << MANTISSA_BITS);
    // mantissa · 2^(64 + exponent) / rate: first shifted left as far as there is room.
    let left = 64 + exponent;
    let turns = if left >= 0 {
        (mantissa << left) / u128::from(rate_hz)
    } else {
        mantissa.checked_shr(left.unsigned_abs()).unwrap_or(0) / u128::from(rate_hz)
    };
    u64::try_from(turns).ok().filter(|increment| *increment > 0)
}
