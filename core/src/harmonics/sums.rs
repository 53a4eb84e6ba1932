//! The sums of several channels, and the step that adds one block to them.
//!
//! The sums of a channel take 100 bytes: ten sums of 62 bits, a square of 63, a drift of 53, and an offset of 42, whose
//! upper ten bits lie above the drift.

use serde::{Deserialize, Serialize};

use super::HARMONICS;
use super::table::Waves;
use crate::channel::unrolled;

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
pub(super) struct Sums<const N: usize> {
    cosine: [[i64; HARMONICS]; N],
    sine: [[i64; HARMONICS]; N],
    square: [u64; N],
    /// The drift; from bit [`ABOVE_DRIFT`] on, the offset's bits from 32 on.
    mixed: [u64; N],
    /// The offset's lower 32 bits.
    offset: [u32; N],
}

impl<const N: usize> Sums<N> {
    pub(super) const ZERO: Self = Self {
        cosine: [[0; HARMONICS]; N],
        sine: [[0; HARMONICS]; N],
        square: [0; N],
        mixed: [0; N],
        offset: [0; N],
    };

    /// Adds one block to all sums at the place in `step`, with the same work for every input.
    #[inline(never)]
    pub(super) fn add(&mut self, block: &[u32; N], step: &Step) {
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

    pub(super) fn channel(&self, channel: usize) -> Option<ChannelSums> {
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
    pub(super) waves: Waves,
    pub(super) place: u32,
    pub(super) takes: Takes,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Takes {
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
    pub(super) fn taken<'a, const N: usize>(&self, block: &'a [u32; N]) -> &'a [u32; N] {
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
