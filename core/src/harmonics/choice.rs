//! The choice of a block's size for a drive frequency.
//!
//! Adding B scans before they meet sine and cosine saves work. For the wanted signal the effect is undone exactly. It
//! has three costs:
//!
//! - **Noise.** The sum sees harmonic k smaller by sin(πkfB/r) / (B sin(πkf/r)) at scan rate r, the noise as it is.
//!   At 5fB/r = [`MAX_TURN`] = 0.1 the fifth harmonic's standard deviation is 1.7 % above the bound for single
//!   scans; that of the first 0.07 %.
//! - **Rounding.** Counts are whole numbers; sums of blocks and single scans weigh their rounding a little differently.
//!   For a signal without noise the two fits differ by up to 5·turn/√n counts in a window of one period and
//!   0.45·turn/√n from three periods on, with the fifth harmonic's turn in a block and n scans in a period (`cargo
//!   xtask accuracy`). [`largest_turn`] keeps that below 5e-7 of an amplitude of 3000 counts: a tenth or less of the
//!   error of rounding itself.
//! - **Interference.** The blocks come at r/B, so that a disturbance at m·r/B ± kf looks like harmonic k. The sum
//!   weakens it, like any frequency near m·r/B, but only by about kfB/(m·r) against the harmonic: a disturbance of 1 %
//!   of full scale at exactly such a frequency can move the first harmonic by some 5e-4 of full scale. Single scans
//!   would reject it completely. The sums do not show that it happened.
//!
//! So the block is chosen such that no known disturbance (mains and its multiples, servo and structure frequencies)
//! lies near m·r/B ± kf. An unknown disturbance is not avoided: choose small blocks where the base's vibration is
//! unknown, and check with the captures, which hold every scan.

use super::HARMONICS;
use crate::sampling::BlockSize;

/// Largest turn of the fifth harmonic in one block.
pub const MAX_TURN: f64 = 0.1;

/// Largest turn of the fifth harmonic in one block for `periods` periods of so many scans each.
#[must_use]
pub fn largest_turn(periods: f64, scans_of_period: f64) -> f64 {
    // Between one period and three the drift resembles the first harmonic, and all effects of rounding grow.
    let by_rounding = if periods > 2.5 { 3.3e-3 } else { 3e-4 };
    MAX_TURN.min(by_rounding * libm::sqrt(scans_of_period))
}

/// A known disturbance that looks like a harmonic in blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mistaken {
    /// The disturbance, Hz.
    pub line_hz: f64,
    /// The multiple m of the block rate beside which it lies.
    pub multiple: u32,
    /// The harmonic that it resembles, 1 to 5.
    pub harmonic: u32,
}

/// The first of `lines_hz` within `distance_hz` of m·r/B ± kf for an m above zero, in blocks of `block` at `rate_hz`;
/// `None` when there is none.
///
/// A line that single scans would mistake too (m a multiple of B) does not count against the block.
#[must_use]
pub fn mistaken(
    frequency_hz: f64,
    rate_hz: f64,
    block: BlockSize,
    lines_hz: &[f64],
    distance_hz: f64,
) -> Option<Mistaken> {
    let scans = block.scans() as f64;
    let block_rate_hz = rate_hz / scans;
    let shifted = |line_hz: f64, harmonic: u32| {
        let shift = f64::from(harmonic) * frequency_hz;
        [line_hz - shift, line_hz + shift]
            .into_iter()
            .find_map(|at| {
                let multiple = libm::round(at / block_rate_hz);
                let near = libm::fabs(at - multiple * block_rate_hz) < distance_hz;
                let of_blocks_alone = multiple > 0.0 && libm::fmod(multiple, scans) != 0.0;
                (near && of_blocks_alone).then_some(Mistaken {
                    line_hz,
                    multiple: multiple as u32,
                    harmonic,
                })
            })
    };
    lines_hz
        .iter()
        .find_map(|line_hz| (1..=HARMONICS as u32).find_map(|harmonic| shifted(*line_hz, harmonic)))
}

/// The largest block for `periods` periods of a drive at `frequency_hz`, scanned at `rate_hz`. The disturbances at
/// `lines_hz` stay at least `distance_hz` away from the frequencies that look like a harmonic (twice the reciprocal of
/// the summed time is enough for a steady disturbance).
///
/// Single scans are the last resort, with any disturbance. `None` when even they cannot hold five harmonics, that is
/// from a tenth of the scan rate on, or when the frequency is not above zero.
#[must_use]
pub fn largest_block(
    frequency_hz: f64,
    rate_hz: f64,
    periods: f64,
    lines_hz: &[f64],
    distance_hz: f64,
) -> Option<BlockSize> {
    let turn = HARMONICS as f64 * frequency_hz / rate_hz;
    let possible = frequency_hz > 0.0 && turn < 0.5;
    let most = largest_turn(periods, rate_hz / frequency_hz);
    possible.then(|| {
        BlockSize::ALL
            .into_iter()
            .rev()
            .find(|block| {
                turn * block.scans() as f64 <= most
                    && mistaken(frequency_hz, rate_hz, *block, lines_hz, distance_hz).is_none()
            })
            .unwrap_or(BlockSize::One)
    })
}
