//! The sums at the drive frequency, which the board makes while it samples.
//!
//! The scans of a block are added first, and the block's sum s enters each wide sum once, with the sine and cosine of
//! the phase at the block's centre:
//!
//! ```text
//! block b:  s = Σ u     offset += s     drift += p(b)·s     square += s²
//!           cosine[k] += s·cos(kθ_b)    sine[k] += s·sin(kθ_b)     θ_b: phase at the block's centre
//! ```
//!
//! p(b) is the number of the block, or of its place among at most 4096 (see [`Drive`]); θ is 64 bits of a turn, shared
//! by all channels. Everything is an integer, so the order of additions does not matter and a replay on the host gives
//! the very same sums. Summing in blocks scales harmonic k by sin(kω·B/2)/sin(kω/2); [`super::solution`] undoes that.
//!
//! The sums of a channel take 100 bytes: ten sums of 62 bits, a square of 63, a drift of 53, and an offset of 42, whose
//! upper ten bits lie above the drift.

use core::hint::black_box;

use crate::channel::{CHANNELS, INERTIAL, JACKS, unrolled};
use crate::sampling::{BlockSize, BlockSums};
use serde::{Deserialize, Serialize};

use super::HARMONICS;
use super::drive::Drive;
use super::table::Waves;

pub use super::drive::MAX_BLOCKS;

/// Progress of the harmonic sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum AnalyserState {
    /// No drive was set.
    Idle,
    /// Transients are passing.
    Settling,
    /// Sums are growing.
    Summing,
    /// The sums are complete and stay.
    Complete,
}

/// Sums of one channel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChannelSums {
    /// Σ s, counts.
    pub offset: i64,
    /// Σ p·s with p = 0, 1, 2 …, the number of the block, cut to 4096 places.
    pub drift: i64,
    /// Σ s².
    pub square: u64,
    /// Σ s·cos(kθ)·[`super::table::ONE`], k = 1 to 5.
    pub cosine: [i64; HARMONICS],
    /// Σ s·sin(kθ)·[`super::table::ONE`], k = 1 to 5.
    pub sine: [i64; HARMONICS],
}

/// Bit of the drift's word at which the offset's upper bits begin.
const ABOVE_DRIFT: u32 = 54;

/// Sums of `N` channels.
#[derive(Debug, Clone)]
struct Sums<const N: usize> {
    cosine: [[i64; HARMONICS]; N],
    sine: [[i64; HARMONICS]; N],
    square: [u64; N],
    /// The drift; from bit [`ABOVE_DRIFT`] on, the offset's bits from 32 on.
    mixed: [u64; N],
    /// The offset's lower 32 bits.
    offset: [u32; N],
}

impl<const N: usize> Sums<N> {
    const ZERO: Self = Self {
        cosine: [[0; HARMONICS]; N],
        sine: [[0; HARMONICS]; N],
        square: [0; N],
        mixed: [0; N],
        offset: [0; N],
    };

    /// Adds one block to all sums at the place in `step`, with the same work for every input.
    #[inline(never)]
    fn add(&mut self, block: &[u32; N], step: &Step) {
        add_waves(&mut self.cosine, block, &step.waves.cosine);
        add_waves(&mut self.sine, block, &step.waves.sine);
        unrolled::<N>(
            #[inline(always)]
            |channel| {
                let wide = u64::from(block[channel]);
                self.square[channel] += wide * wide;
                let (offset, carried) = self.offset[channel].overflowing_add(block[channel]);
                self.offset[channel] = offset;
                self.mixed[channel] +=
                    wide * u64::from(step.place) + (u64::from(carried) << ABOVE_DRIFT);
            },
        );
    }

    fn channel(&self, channel: usize) -> Option<ChannelSums> {
        let mixed = *self.mixed.get(channel)?;
        let above = mixed >> ABOVE_DRIFT << 32;
        Some(ChannelSums {
            offset: (above | u64::from(self.offset[channel])) as i64,
            drift: (mixed & ((1 << ABOVE_DRIFT) - 1)) as i64,
            square: self.square[channel],
            cosine: self.cosine[channel],
            sine: self.sine[channel],
        })
    }
}

/// What an analyser does with one block, first with the sums of the inertial channels, then with those of the jacks.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    waves: Waves,
    place: u32,
    takes: Takes,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Takes {
    /// It is idle.
    Nothing,
    /// It settles or is complete: it adds zeros, so that it takes the same time as an analyser that sums.
    Zeros,
    /// It sums.
    Block,
}

impl Step {
    /// Nothing is done.
    pub const NONE: Self = Self {
        waves: Waves {
            cosine: [0; HARMONICS],
            sine: [0; HARMONICS],
        },
        place: 0,
        takes: Takes::Nothing,
    };

    /// The sums that are added: those of a block, or zeros.
    #[inline(always)]
    fn taken<'a, const N: usize>(&self, block: &'a [u32; N]) -> &'a [u32; N] {
        if self.takes == Takes::Block {
            block
        } else {
            &[0; N]
        }
    }
}

/// Handles five waves at a time, which fit into the registers.
#[inline(always)]
fn add_waves<const N: usize>(
    sums: &mut [[i64; HARMONICS]; N],
    block: &[u32; N],
    waves: &[i32; HARMONICS],
) {
    unrolled::<N>(
        #[inline(always)]
        |channel| {
            let wide = i64::from(block[channel] as i32);
            let sums = &mut sums[channel];
            sums[0] += wide * i64::from(waves[0]);
            sums[1] += wide * i64::from(waves[1]);
            sums[2] += wide * i64::from(waves[2]);
            sums[3] += wide * i64::from(waves[3]);
            sums[4] += wide * i64::from(waves[4]);
        },
    );
}

/// Harmonic sums of all channels at one drive frequency.
#[derive(Debug, Clone)]
pub struct Analyser {
    increment: u64,
    size: BlockSize,
    settle_blocks: u32,
    /// Blocks to sum; zero without a drive.
    blocks: u32,
    /// Blocks since the start, settling included.
    taken: u32,
    /// Scan counter of the first scan after the start.
    began: u64,
    inertial: Sums<INERTIAL>,
    jacks: Sums<JACKS>,
}

impl Default for Analyser {
    fn default() -> Self {
        Self::new()
    }
}

impl Analyser {
    /// An analyser that waits for a drive.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            increment: 0,
            size: BlockSize::One,
            settle_blocks: 0,
            blocks: 0,
            taken: 0,
            began: 0,
            inertial: Sums::ZERO,
            jacks: Sums::ZERO,
        }
    }

    /// Starts with the next block at this drive, which must pass [`Drive::check`].
    pub fn start(&mut self, drive: Drive) {
        *self = Self {
            increment: drive.increment,
            size: drive.block,
            settle_blocks: drive.settle_blocks,
            blocks: drive.blocks,
            ..Self::new()
        };
    }

    /// Takes the sums of one block of the drive's size.
    ///
    /// A block that does not follow the one before it leaves a hole, and no window with a hole can be fitted: the
    /// analyser starts again with that block, settling included.
    pub fn take(&mut self, block: &BlockSums) {
        let mut step = Step::NONE;
        self.take_inertial(block.first_scan, &block.inertial, &mut step);
        self.take_jacks(&step, &block.jacks);
    }

    /// The first part of [`Self::take`]: everything but the jacks. They follow with [`Self::take_jacks`] and the `step`
    /// from here. The work is the same whether the analyser settles, sums or is complete.
    #[inline(never)]
    pub fn take_inertial(&mut self, first_scan: u64, sums: &[u32; INERTIAL], step: &mut Step) {
        if self.blocks == 0 {
            step.takes = Takes::Nothing;
            return;
        }
        let complete = self.is_complete();
        // Always stored, new or not: the same work for the first block.
        self.began = if self.taken == 0 {
            first_scan
        } else {
            self.began
        };
        let hole = !complete & (first_scan != self.began + self.scans(self.taken));
        // Without the black box the compiler branches on either half, and a complete analyser skips the other.
        if black_box(hole) {
            self.start(self.drive());
            self.began = first_scan;
        }
        let summing = !complete & (self.taken >= self.settle_blocks);
        let number = self.taken.wrapping_sub(self.settle_blocks);
        self.taken += u32::from(!complete);
        let drive = self.drive();
        *step = Step {
            waves: Waves::at((drive.centre_phase(number) >> 32) as u32),
            place: drive.place(number),
            takes: if summing { Takes::Block } else { Takes::Zeros },
        };
        self.inertial.add(step.taken(sums), step);
    }

    /// The second part of [`Self::take`]: the jacks of the same block.
    #[inline(always)]
    pub fn take_jacks(&mut self, step: &Step, sums: &[u32; JACKS]) {
        if step.takes != Takes::Nothing {
            self.jacks.add(step.taken(sums), step);
        }
    }

    fn drive(&self) -> Drive {
        Drive {
            increment: self.increment,
            block: self.size,
            settle_blocks: self.settle_blocks,
            blocks: self.blocks,
        }
    }

    fn scans(&self, blocks: u32) -> u64 {
        u64::from(blocks) * self.size.scans() as u64
    }

    fn is_complete(&self) -> bool {
        self.taken.saturating_sub(self.settle_blocks) >= self.blocks
    }

    /// Progress of the sums.
    #[must_use]
    pub fn state(&self) -> AnalyserState {
        if self.blocks == 0 {
            AnalyserState::Idle
        } else if self.taken < self.settle_blocks {
            AnalyserState::Settling
        } else if self.is_complete() {
            AnalyserState::Complete
        } else {
            AnalyserState::Summing
        }
    }

    /// The drive, its first summed scan, and the sums of a channel (0 to 14); `None` when idle or without this channel.
    #[must_use]
    pub fn report(&self, channel: usize) -> Option<(Drive, u64, ChannelSums)> {
        if self.blocks == 0 || channel >= CHANNELS {
            return None;
        }
        let sums = match channel.checked_sub(INERTIAL) {
            None => self.inertial.channel(channel),
            Some(jack) => self.jacks.channel(jack),
        };
        let begun = self.taken > self.settle_blocks;
        let first = if begun {
            self.began + self.scans(self.settle_blocks)
        } else {
            0
        };
        Some((self.drive(), first, sums?))
    }
}
