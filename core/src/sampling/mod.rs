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
//! - [`supply`]: the supply factor c, as the mean of its readings.
//!
//! The work is the same for every input: no branch on data, no division, no square root. `cargo xtask bench
//! sample-path` and `docs/timing.md` give the number of instructions, measured on the firmware.

pub mod block;
pub mod calibrator;
pub mod supply;

pub use block::{BLOCK, BlockSize, BlockSums, add_up};
pub use calibrator::{Calibrator, Prepared, Values};
pub use supply::{SupplyMean, SupplyReading};
