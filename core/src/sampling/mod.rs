//! From counts to calibrated values and block sums, in fixed time.
//!
//! The converters leave a *block* of scans in one half of a ring; the sample path takes it where it lies:
//!
//! ```text
//! ring half ──▶ Prepared::block ──▶ calibrated values of every scan
//!                     └───────────▶ sum of every channel over the block ──▶ harmonics::Analyser
//! ```
//!
//! - [`block`]: how many scans a block has, and its sums.
//! - [`calibrator`]: value = M · (c·u − u0) for every scan.
//!
//! The work is the same for every input: no branch on data, no division, no square root. How many instructions that
//! is, measured on the firmware: `cargo xtask bench sample-path` and `docs/timing.md`.

pub mod block;
pub mod calibrator;

pub use block::{BlockSize, BlockSums, add_up};
pub use calibrator::{Calibrator, Prepared, Values};

/// Scans of a block unless another [`BlockSize`] is chosen.
pub const BLOCK: usize = BlockSize::Sixteen.scans();
