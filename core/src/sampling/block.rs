//! Blocks of scans: their size, and the sum of each channel over them.
//!
//! A large block costs fewer instructions for each scan; a small one has less latency. [`crate::harmonics::choice`]
//! tells the effect of summing on harmonics.

use core::sync::atomic::{Ordering, compiler_fence};

use serde::{Deserialize, Serialize};

use crate::channel::{CHANNELS, INERTIAL, JACKS, Scan, unrolled};

/// Scans of a block unless another [`BlockSize`] is chosen.
pub const BLOCK: usize = BlockSize::Sixteen.scans();

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
    pub const MAX_SCANS: usize = Self::ThirtyTwo.scans();

    /// Number of scans.
    #[must_use]
    #[inline(always)]
    pub const fn scans(self) -> usize {
        match self {
            Self::One => 1,
            Self::Four => 4,
            Self::Eight => 8,
            Self::Sixteen => 16,
            Self::ThirtyTwo => 32,
        }
    }

    /// The size with this number of scans, if there is one.
    #[must_use]
    pub fn of_scans(scans: usize) -> Option<Self> {
        Self::ALL.into_iter().find(|size| size.scans() == scans)
    }
}

/// Sum of every channel over one block, and the block's place in time.
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
    /// Sums of whole scans, of at most [`BlockSize::MAX_SCANS`].
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
    match scans.as_chunks::<BLOCK>() {
        ([], few) => add_up_few(few, sums),
        ([first, others @ ..], few) => {
            add_up_block(first, sums);
            let mut more = [0; COLUMNS];
            for block in others {
                add_up_block(block, &mut more);
                add(sums, &more);
            }
            few.iter().for_each(|scan| add(sums, &scan.map(u32::from)));
        }
    }
}

fn add<const COLUMNS: usize>(sums: &mut [u32; COLUMNS], more: &[u32; COLUMNS]) {
    sums.iter_mut()
        .zip(more)
        .for_each(|(sum, more)| *sum += *more);
}

/// Sixteen scans, two counts at a time.
///
/// Two scans are as many words as a scan has columns. Every word is added to one sum, its upper half to another; the
/// first less the shifted second leaves the sum of the lower halves. Sums wrap, but the results are below 2²⁰.
#[inline(never)]
fn add_up_block<const COLUMNS: usize>(scans: &[[u16; COLUMNS]; BLOCK], sums: &mut [u32; COLUMNS]) {
    const {
        assert!(
            cfg!(target_endian = "little"),
            "the first count of a word is its lower half"
        )
    };
    unrolled::<COLUMNS>(
        #[inline(always)]
        |word| {
            let (lower, upper) = half_sums(scans, word);
            // Each column occurs once in an even scan and once in an odd one.
            put(sums, 2 * word, lower);
            put(sums, 2 * word + 1, upper);
            // Without the fence the compiler loads more words at once than there are registers.
            compiler_fence(Ordering::SeqCst);
        },
    );
}

/// Sums of the lower and the upper halves of one word of each pair of scans.
#[inline(always)]
fn half_sums<const COLUMNS: usize>(scans: &[[u16; COLUMNS]; BLOCK], word: usize) -> (u32, u32) {
    let sums = (0, 0);
    let sums = with_word(sums, scans, 0, word);
    let sums = with_word(sums, scans, 1, word);
    let sums = with_word(sums, scans, 2, word);
    let sums = with_word(sums, scans, 3, word);
    let sums = with_word(sums, scans, 4, word);
    let sums = with_word(sums, scans, 5, word);
    let sums = with_word(sums, scans, 6, word);
    let (whole, upper) = with_word(sums, scans, 7, word);
    (whole.wrapping_sub(upper << 16), upper)
}

#[inline(always)]
fn with_word<const COLUMNS: usize>(
    (whole, upper): (u32, u32),
    scans: &[[u16; COLUMNS]; BLOCK],
    pair: usize,
    word: usize,
) -> (u32, u32) {
    let pair = &scans.as_chunks::<2>().0[pair];
    let words = bytemuck::cast_slice::<u16, u8>(pair.as_flattened());
    let both = u32::from_le_bytes(words.as_chunks::<4>().0[word]);
    (whole.wrapping_add(both), upper + (both >> 16))
}

#[inline(always)]
fn put<const COLUMNS: usize>(sums: &mut [u32; COLUMNS], place: usize, sum: u32) {
    if place < COLUMNS {
        sums[place] = sum;
    } else {
        sums[place - COLUMNS] += sum;
    }
}

/// Fewer scans: three columns at a time, which fit into the registers.
fn add_up_few<const COLUMNS: usize>(scans: &[[u16; COLUMNS]], sums: &mut [u32; COLUMNS]) {
    for first in (0..COLUMNS).step_by(3) {
        let mut totals = [0_u32; 3];
        for scan in scans {
            for (total, count) in totals.iter_mut().zip(&scan[first..]) {
                *total += u32::from(*count);
            }
        }
        sums[first..]
            .iter_mut()
            .zip(totals)
            .for_each(|(sum, total)| *sum = total);
    }
}
