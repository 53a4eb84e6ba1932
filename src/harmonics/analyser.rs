//! The sums that the board keeps at the drive frequency while it samples.
//!
//! The sixteen scans of a block are added first, and the block's sum s enters each wide sum once, with the sine and
//! cosine of the phase at the block's centre:
//!
//! ```text
//! block b:  s = Σ u     offset += s     drift += b·s     square += s²
//!           cosine[k] += s·cos(kθ_b)    sine[k] += s·sin(kθ_b)     θ_b: phase at the block's centre
//! ```
//!
//! Everything is an integer, so the order of additions does not matter and a replay on the host gives the very same
//! sums. What summing in blocks does to harmonic k, a factor sin(kω·16/2)/sin(kω/2), is undone by
//! [`super::solution`].

use serde::{Deserialize, Serialize};

use super::{HARMONICS, table};
use crate::channel::{CHANNELS, Scan};
use crate::sampling::BLOCK;
use crate::wire::{Drive, HarmonicState};

/// Sums of one channel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChannelSums {
    /// Σ s, counts.
    pub offset: i64,
    /// Σ b·s with b = 0, 1, 2 … the number of the block.
    pub drift: i64,
    /// Σ s².
    pub square: u64,
    /// Σ s·cos(kθ)·[`table::ONE`], k = 1 to 5.
    pub cosine: [i64; HARMONICS],
    /// Σ s·sin(kθ)·[`table::ONE`], k = 1 to 5.
    pub sine: [i64; HARMONICS],
}

impl ChannelSums {
    fn add(&mut self, block: u32, sum: i32, waves: &Waves) {
        let wide = i64::from(sum);
        self.offset += wide;
        self.drift += wide * i64::from(block);
        self.square += (wide * wide) as u64;
        for k in 0..HARMONICS {
            self.cosine[k] += wide * i64::from(waves.cosine[k]);
            self.sine[k] += wide * i64::from(waves.sine[k]);
        }
    }
}

/// Cosine and sine of the five harmonics at one block's centre.
pub(super) struct Waves {
    pub(super) cosine: [i32; HARMONICS],
    pub(super) sine: [i32; HARMONICS],
}

impl Waves {
    /// Looks up all harmonics of the phase at a block's centre.
    pub(super) fn at(centre: u64) -> Self {
        let mut waves = Self {
            cosine: [0; HARMONICS],
            sine: [0; HARMONICS],
        };
        let mut phase = 0u64;
        for k in 0..HARMONICS {
            phase = phase.wrapping_add(centre);
            waves.cosine[k] = table::cosine(phase);
            waves.sine[k] = table::sine(phase);
        }
        waves
    }
}

/// Phase at the centre of block `block`, counted from the first summed one; scan 0 of block 0 has phase zero.
pub(super) fn centre_phase(drive: &Drive, block: u32) -> u64 {
    let to_centre = (drive.increment >> 1).wrapping_mul(BLOCK as u64 - 1);
    drive
        .increment
        .wrapping_mul(u64::from(block) * BLOCK as u64)
        .wrapping_add(to_centre)
}

/// Longest sum, blocks: beyond it the drift sum of full-scale blocks would overflow.
pub const MAX_BLOCKS: u32 = 1 << 21;

/// Harmonic sums of all channels at one drive frequency.
#[derive(Debug, Clone)]
pub struct Analyser {
    drive: Option<Drive>,
    settled: u32,
    summed: u32,
    first_scan: u64,
    sums: [ChannelSums; CHANNELS],
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
        const ZERO: ChannelSums = ChannelSums {
            offset: 0,
            drift: 0,
            square: 0,
            cosine: [0; HARMONICS],
            sine: [0; HARMONICS],
        };
        Self {
            drive: None,
            settled: 0,
            summed: 0,
            first_scan: 0,
            sums: [ZERO; CHANNELS],
        }
    }

    /// Whether a drive can be estimated: 0 < f < rate / 160, so that five harmonics pass the block sums, and a length
    /// between one block and [`MAX_BLOCKS`].
    #[must_use]
    pub const fn accepts(drive: &Drive) -> bool {
        let limit = u64::MAX / (10 * BLOCK as u64);
        drive.increment > 0
            && drive.increment < limit
            && drive.blocks > 0
            && drive.blocks <= MAX_BLOCKS
    }

    /// Starts anew at this drive with the next block.
    pub fn start(&mut self, drive: Drive) {
        *self = Self {
            drive: Some(drive),
            ..Self::new()
        };
    }

    /// Takes one block of scans; `first_scan` is the counter of its first scan.
    pub fn update(&mut self, scans: &[Scan; BLOCK], first_scan: u64) {
        let Some(drive) = self.drive else { return };
        if self.settled < drive.settle_blocks {
            self.settled += 1;
            return;
        }
        if self.summed >= drive.blocks {
            return;
        }
        if self.summed == 0 {
            self.first_scan = first_scan;
        }
        let waves = Waves::at(centre_phase(&drive, self.summed));
        for (channel, sums) in self.sums.iter_mut().enumerate() {
            let sum = scans.iter().map(|scan| i32::from(scan[channel])).sum();
            sums.add(self.summed, sum, &waves);
        }
        self.summed += 1;
    }

    /// How far the sums are.
    #[must_use]
    pub fn state(&self) -> HarmonicState {
        match self.drive {
            None => HarmonicState::Idle,
            Some(drive) if self.settled < drive.settle_blocks => HarmonicState::Settling,
            Some(drive) if self.summed < drive.blocks => HarmonicState::Summing,
            Some(_) => HarmonicState::Complete,
        }
    }

    /// The drive, its first summed scan, and the sums of a channel (0 to 14); `None` when idle or no such channel.
    #[must_use]
    pub fn report(&self, channel: usize) -> Option<(Drive, u64, ChannelSums)> {
        Some((self.drive?, self.first_scan, *self.sums.get(channel)?))
    }
}
