//! The board's own pose: jack counts → jack lengths → pose, block by block.
//!
//! ```text
//! mean counts of a block ──transducers──▶ lengths ──forward kinematics──▶ pose
//! ```
//!
//! Each pose is solved from the last one; from home at the start and after a refusal. The board does this in `f32`, a
//! host that checks it in `f64` on the same counts and coefficients.

use nalgebra::{RealField, convert};

use crate::channel::{JACKS, Ratiometric, Scan};
use crate::kinematics::{ForwardError, Options, PoseTracker, ReportFailure, Solution, Solver};
use crate::records::{BaseError, JackCoefficients, MotionBase};
use crate::sampling::{BlockSize, BlockSums};
use crate::transducers::Transducers;

/// The jacks of one block of scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JackBlock {
    /// Scan counter of the block's first scan.
    pub first_scan: u64,
    /// Supply factor of the block.
    pub supply: f32,
    /// Scans of the block.
    pub block: BlockSize,
    /// Sum of each jack's counts over the block.
    pub sums: [u32; JACKS],
}

impl JackBlock {
    /// Sums up the jacks of a block's scans; `None` when there is no block of so many.
    #[must_use]
    pub fn new(first_scan: u64, supply: f32, scans: &[Scan]) -> Option<Self> {
        Some(Self {
            first_scan,
            supply,
            block: BlockSize::of_scans(scans.len())?,
            sums: BlockSums::of_scans(scans, first_scan).jacks,
        })
    }
}

/// Poses of one base from its jacks' counts, one after another.
#[derive(Debug, Clone)]
pub struct Tracker<T: RealField + Copy> {
    poses: PoseTracker<T, ReportFailure>,
    transducers: Transducers<T>,
}

impl<T: RealField + Copy> Tracker<T> {
    /// A tracker for the base and transducers of a coefficient set, to start from home.
    ///
    /// # Errors
    /// [`BaseError`] when base or transducers are not usable.
    pub fn new(
        base: &MotionBase,
        jacks: &JackCoefficients,
        ratiometric: Ratiometric,
    ) -> Result<Self, BaseError> {
        jacks.check()?;
        let solver = Solver::bounded(&base.geometry()?.cast::<T>(), Options::measured());
        Ok(Self {
            transducers: Transducers::new(jacks, ratiometric),
            poses: PoseTracker::new(solver, ReportFailure),
        })
    }

    /// The solver of this base.
    pub fn solver(&self) -> &Solver<T> {
        self.poses.solver()
    }

    /// The transducers of this base.
    pub fn transducers(&self) -> &Transducers<T> {
        &self.transducers
    }

    /// The pose over a block, solved from the last one.
    ///
    /// # Errors
    /// Any [`ForwardError`]; the next block is then solved from home.
    pub fn next(&mut self, block: &JackBlock) -> Result<Solution<T>, ForwardError<T>> {
        // A sum has 21 bits at most and is divided by a power of two, so the mean is exact.
        let mean = |jack: usize| convert(block.sums[jack] as f32 / block.block.scans() as f32);
        let lengths = self
            .transducers
            .lengths_of_means_m(mean, convert(block.supply));
        self.poses.next(&lengths)
    }

    /// Forgets the last pose: the next block is solved from home. Due after a pause, in which the base may have moved.
    pub fn restart(&mut self) {
        self.poses.restart();
    }
}
