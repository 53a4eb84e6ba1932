//! The board's own pose: jack counts → jack lengths → pose, block by block.
//!
//! ```text
//! l_k = l° + m_k · (c·ū_k − u°_k)       ū_k: mean of a block's counts of jack k, c: supply factor
//! pose = forward kinematics of l        from the last pose; from home at the start and after a refusal
//! ```
//!
//! The board does this in `f32`, a host that checks it in `f64` on the same counts and coefficients. Lengths of metres
//! are to be good to a tenth of a micrometre, the last place of an `f32`, so c·ū − u° is put together from small
//! numbers, as (ū − u°) + (c − 1)·ū, and only the sum with l° is rounded.

use nalgebra::{RealField, convert};

use crate::channel::{JACKS, Scan};
use crate::kinematics::{ForwardError, Options, Pose, Solution, Solver};
use crate::records::{BaseError, JackCoefficients, MotionBase};
use crate::sampling::{BlockSize, BlockSums};

/// How far a jack may read beyond its stroke, m: a transducer is off by some millimetres at most.
pub const STROKE_MARGIN_M: f64 = 0.01;

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
    solver: Solver<T>,
    zero_length_m: T,
    zero_counts: [T; JACKS],
    metres_per_count: [T; JACKS],
    last: Option<Pose<T>>,
}

impl<T: RealField + Copy> Tracker<T> {
    /// A tracker for the base and transducers of a coefficient set, to start from home.
    ///
    /// # Errors
    /// [`BaseError`] when base or transducers are not usable.
    pub fn new(base: &MotionBase, jacks: &JackCoefficients) -> Result<Self, BaseError> {
        jacks.check()?;
        let options = Options {
            stroke_margin_m: convert(STROKE_MARGIN_M),
            ..Options::default()
        };
        Ok(Self {
            solver: Solver::bounded(&base.geometry()?.cast::<T>(), options),
            zero_length_m: single(jacks.zero_length_m),
            zero_counts: jacks.zero_counts.map(single),
            metres_per_count: jacks.metres_per_count.map(single),
            last: None,
        })
    }

    /// The solver of this base.
    pub fn solver(&self) -> &Solver<T> {
        &self.solver
    }

    /// Hinge-to-hinge length of each jack over a block, m.
    #[inline]
    pub fn lengths_m(&self, block: &JackBlock) -> [T; JACKS] {
        let excess = single::<T>(block.supply) - T::one();
        core::array::from_fn(|jack| {
            // A sum has 21 bits at most and is divided by a power of two, so the mean is exact.
            let mean = single::<T>(block.sums[jack] as f32 / block.block.scans() as f32);
            let counts = (mean - self.zero_counts[jack]) + excess * mean;
            self.zero_length_m + self.metres_per_count[jack] * counts
        })
    }

    /// The pose over a block, solved from the last one.
    ///
    /// # Errors
    /// Any [`ForwardError`]; the next block is then solved from home.
    pub fn next(&mut self, block: &JackBlock) -> Result<Solution<T>, ForwardError<T>> {
        let lengths = self.lengths_m(block);
        let solution = match self.last.take() {
            Some(last) => self.solver.track(&lengths, &last),
            None => self.solver.solve(&lengths),
        }?;
        self.last = Some(solution.pose);
        Ok(solution)
    }

    /// Forgets the last pose: the next block is solved from home. Due after a pause, in which the base may have moved.
    pub fn restart(&mut self) {
        self.last = None;
    }
}

impl Tracker<f32> {
    /// Hinge-to-hinge length of each jack at counts that need not be whole, m.
    pub fn lengths_of(&self, counts: &[f64; JACKS], supply: f32) -> [f32; JACKS] {
        core::array::from_fn(|jack| {
            let counts = counts[jack] * f64::from(supply) - f64::from(self.zero_counts[jack]);
            self.zero_length_m + self.metres_per_count[jack] * counts as f32
        })
    }
}

fn single<T: RealField + Copy>(value: f32) -> T {
    convert(value)
}
