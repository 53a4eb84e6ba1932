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

use core::hint::black_box;

use crate::channel::{CHANNELS, INERTIAL, JACKS};
use crate::sampling::{BlockSize, BlockSums};
use serde::{Deserialize, Serialize};

use super::drive::Drive;
use super::sums::{ChannelSums, Step, Sums, Takes};
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
