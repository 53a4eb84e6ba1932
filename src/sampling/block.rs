//! Blocks of scans: how many scans, and the sum of each channel over them.
//!
//! A large block costs fewer instructions for each scan, a small one is sooner there. What summing does to harmonics
//! is told in [`crate::harmonics::choice`].

use serde::{Deserialize, Serialize};

use crate::channel::{CHANNELS, INERTIAL, JACKS, Scan};

/// Scans that are handled together: one half of each converter's ring buffer.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
pub enum BlockSize {
    /// Each scan by itself: least latency.
    One,
    /// Four scans.
    Four,
    /// Eight scans.
    Eight,
    /// Sixteen scans.
    #[default]
    Sixteen,
    /// Thirty-two scans: least work.
    ThirtyTwo,
}

impl BlockSize {
    /// All sizes, smallest first.
    pub const ALL: [Self; 5] = [
        Self::One,
        Self::Four,
        Self::Eight,
        Self::Sixteen,
        Self::ThirtyTwo,
    ];
    /// Scans of the largest block.
    pub const MOST: usize = Self::ThirtyTwo.scans();

    /// Number of scans.
    #[must_use]
    pub const fn scans(self) -> usize {
        match self {
            Self::One => 1,
            Self::Four => 4,
            Self::Eight => 8,
            Self::Sixteen => 16,
            Self::ThirtyTwo => 32,
        }
    }

    /// The size with so many scans; `None` when there is none.
    #[must_use]
    pub fn of_scans(scans: usize) -> Option<Self> {
        Self::ALL.into_iter().find(|size| size.scans() == scans)
    }
}

/// Sum of every channel over one block, and where in time the block is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockSums {
    /// Scan counter of the block's first scan.
    pub first_scan: u64,
    /// Sums of the inertial channels, counts.
    pub inertial: [u32; INERTIAL],
    /// Sums of the jacks, counts.
    pub jacks: [u32; JACKS],
}

impl BlockSums {
    /// Sums of whole scans, of at most [`BlockSize::MOST`].
    #[must_use]
    pub fn of_scans(scans: &[Scan], first_scan: u64) -> Self {
        let mut all = [0; CHANNELS];
        add_up(scans, &mut all);
        let mut sums = Self {
            first_scan,
            inertial: [0; INERTIAL],
            jacks: [0; JACKS],
        };
        sums.inertial.copy_from_slice(&all[..INERTIAL]);
        sums.jacks.copy_from_slice(&all[INERTIAL..]);
        sums
    }
}

/// Sum of each column of a ring's half, counts; below 2²¹ for the largest block.
#[inline(never)]
pub fn add_up<const COLUMNS: usize>(scans: &[[u16; COLUMNS]], sums: &mut [u32; COLUMNS]) {
    const { assert!(COLUMNS.is_multiple_of(3) && COLUMNS <= CHANNELS) };
    add_up_three::<0, COLUMNS>(scans, sums);
    add_up_three::<3, COLUMNS>(scans, sums);
    add_up_three::<6, COLUMNS>(scans, sums);
    add_up_three::<9, COLUMNS>(scans, sums);
    add_up_three::<12, COLUMNS>(scans, sums);
}

/// Three columns stay in registers, and eight scans need no loop.
#[inline(always)]
fn add_up_three<const FIRST: usize, const COLUMNS: usize>(
    scans: &[[u16; COLUMNS]],
    sums: &mut [u32; COLUMNS],
) {
    if FIRST >= COLUMNS {
        return;
    }
    let mut totals = [0_u32; 3];
    let mut add = |scan: &[u16; COLUMNS]| {
        totals[0] += u32::from(scan[FIRST]);
        totals[1] += u32::from(scan[FIRST + 1]);
        totals[2] += u32::from(scan[FIRST + 2]);
    };
    let (eights, rest) = scans.as_chunks::<8>();
    eights
        .iter()
        .for_each(|eight| eight.iter().for_each(&mut add));
    rest.iter().for_each(&mut add);
    sums[FIRST..FIRST + 3].copy_from_slice(&totals);
}
