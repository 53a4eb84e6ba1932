//! From counts to calibrated values and block sums, in fixed time.
//!
//! The converters leave a *block* of scans in one half of a ring, and the sample path processes it there:
//!
//! ```text
//! ring half ──▶ Prepared::block ──▶ calibrated values of every scan
//!                     └───────────▶ sum of every channel over the block ──▶ harmonics::Analyser
//! ```
//!
//! - [`block`]: the size of a block, and its sums.
//! - [`calibrator`]: value = M · (c·u − u0) for every scan.
//!
//! The work is the same for every input: no branch on data, no division, no square root. `cargo xtask bench
//! sample-path` and `docs/timing.md` give the number of instructions, measured on the firmware.

pub mod block;
pub mod calibrator;

pub use block::{BlockSize, BlockSums, add_up};
pub use calibrator::{Calibrator, Prepared, Values};

use crate::channel::INERTIAL;

/// Scans of a block unless another [`BlockSize`] is chosen.
pub const BLOCK: usize = BlockSize::Sixteen.scans();
/// Scan rates that the board offers, Hz.
pub const RATES_HZ: [u32; 3] = [1_000, 2_000, 4_000];
/// Supply at which the supply factor is one, V.
pub const NOMINAL_SUPPLY_V: f32 = 3.3;

/// Time from one rank of a scan to the next, ns: sixteen conversions of 60 cycles at 37.5 MHz.
pub const RANK_NS: u32 = 25_600;

/// Instant at which a channel (0 to 14) is sampled, s after the trigger of its scan: the middle of its sixteen
/// conversions. The inertial channels are ranks 0 to 8 of one converter, the jacks ranks 0 to 5 of another.
#[must_use]
pub fn instant_s(channel: usize) -> f64 {
    let rank = channel.checked_sub(INERTIAL).unwrap_or(channel);
    (rank as f64 + 0.5) * f64::from(RANK_NS) * 1e-9
}
