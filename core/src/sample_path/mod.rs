//! The sample path: from a block of scans to calibrated values, harmonic sums and the queue of the link, in fixed time.
//!
//! The sample interrupt of the board calls [`Path::sample`] and [`Path::finish`] for each block; everything else here runs
//! between two blocks.
//!
//! ```text
//!                 ┌─▶ Prepared::block ──▶ calibrated values ─┐
//! block of scans ─┤        └──▶ sums ──▶ analysers           ├─▶ queue ──▶ link
//!                 └─▶ counts ────────────────────────────────┘
//! ```
//!
//! For one size of block, and as many analysers that are not idle, every block takes the same instructions: no branch
//! depends on a count, nothing waits and nothing is woken.
//!
//! The file [`queue`] is the ring of blocks between sample path and link.

pub mod queue;

use core::sync::atomic::{Ordering, compiler_fence};

use crate::channel::{INERTIAL, JACKS, unrolled};
use crate::facts::BoardFacts;
use crate::harmonics::{ANALYSERS, Analyser, AnalyserState, ChannelSums, Drive, Step};
use crate::sampling::{BlockSize, Prepared, Values, add_up};
use crate::wire::status::{EventCount, PathCycles};
use crate::wire::{StreamContent, telemetry};

use self::queue::{Context, Queue};

/// How far the sample path has come since the start.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Scans of a block.
    pub block: BlockSize,
    /// Scan counter of the next block: scans taken and scans lost.
    pub next_scan: u64,
    /// Scans lost in the converters or their rings, or while those were started anew.
    pub lost: u64,
    /// Scan counter of the first that was lost.
    pub first_lost: Option<u64>,
    /// Blocks that the link had no room for; stops at its largest value.
    pub dropped: u32,
}

impl Progress {
    /// Scans taken.
    #[must_use]
    pub const fn scans(&self) -> u64 {
        self.next_scan - self.lost
    }
}

/// Complete sums of one channel, and what belongs to them.
#[derive(Debug, Clone, Copy)]
pub struct CompleteSums {
    /// What was estimated.
    pub drive: Drive,
    /// Scan counter of the first scan in the sums.
    pub first_scan: u64,
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// The sums.
    pub sums: ChannelSums,
}

/// State of the sample path.
pub struct Path {
    /// How far it has come.
    pub progress: Progress,
    /// The analysers.
    pub analysers: [Analyser; ANALYSERS],
    /// Blocks for the link.
    pub queue: Queue,
    stream: StreamContent,
    /// The part of the line that the stream may use, bit/s.
    max_bits_per_s: u32,
    /// Whether the link wants blocks.
    wanted: bool,
    /// Blocks that the link had no room for, with their time.
    pub dropped: EventCount,
    /// Uptime at the first block with a set, ms.
    pub first_with_set_ms: Option<u64>,
    prepared: Prepared,
    /// What the analysers do with the block at hand; here because to make room for it every time would take longer.
    steps: [Step; ANALYSERS],
    cycles: PathCycles,
}

impl Path {
    /// A path that has taken no block. All zero, so that it takes no flash.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            progress: Progress {
                rate_hz: 0,
                block: BlockSize::One,
                next_scan: 0,
                lost: 0,
                first_lost: None,
                dropped: 0,
            },
            analysers: [const { Analyser::new() }; ANALYSERS],
            queue: Queue::new(),
            stream: StreamContent {
                counts: false,
                values: false,
                pose: false,
            },
            max_bits_per_s: 0,
            wanted: false,
            dropped: EventCount::NONE,
            first_with_set_ms: None,
            prepared: Prepared::NONE,
            steps: [Step::NONE; ANALYSERS],
            cycles: PathCycles {
                min: 0,
                max: 0,
                last: 0,
            },
        }
    }

    /// Begins a run after `lost` scans that were not taken; the analysers stop.
    pub fn begin(&mut self, facts: &BoardFacts, rate_hz: u32, block: BlockSize, lost: u64) {
        if lost > 0 {
            self.progress
                .first_lost
                .get_or_insert(self.progress.next_scan);
        }
        self.progress.lost += lost;
        self.progress.next_scan += lost;
        (self.progress.rate_hz, self.progress.block) = (rate_hz, block);
        self.max_bits_per_s = facts.max_telemetry_bits_per_s();
        self.queue.restart(block);
        self.gather();
        self.analysers
            .iter_mut()
            .for_each(|analyser| *analyser = Analyser::new());
        self.cycles = PathCycles {
            min: u32::MAX,
            max: 0,
            last: 0,
        };
    }

    /// What the link streams from the next block on. Without blocks and poses the queue forgets what waits.
    pub fn set_stream(&mut self, content: StreamContent) {
        self.stream = content;
        self.wanted = content.has_blocks() || content.pose;
        if !self.wanted {
            self.queue.forget();
        }
        self.gather();
    }

    fn gather(&mut self) {
        let Progress { rate_hz, block, .. } = self.progress;
        let limit = self.max_bits_per_s;
        let scans = telemetry::scans_of_frame(self.stream, rate_hz, block, limit);
        self.queue.gather(scans);
    }

    /// The supply and set of the next blocks; `false` when the queue has no place for them and they must be offered again
    /// later.
    pub fn set_context(&mut self, context: Context, prepared: &Prepared) -> bool {
        let taken = self.queue.set_context(context);
        if taken {
            self.prepared.clone_from(prepared);
        }
        taken
    }

    /// The coefficients at work.
    #[must_use]
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// Notes the time of what has happened since the last call, and keeps the count of dropped blocks from wrapping. The
    /// sample interrupt does not do this, because it takes the same time for every block.
    pub fn note_times(&mut self, uptime_ms: u64) {
        if self.progress.dropped != self.dropped.count {
            let count = self.progress.dropped.max(self.dropped.count);
            self.progress.dropped = count;
            self.dropped = EventCount {
                count,
                last_ms: uptime_ms,
            };
        }
        if self.first_with_set_ms.is_none() && self.queue.latest_values().is_some() {
            self.first_with_set_ms = Some(uptime_ms);
        }
    }

    /// Core cycles of the blocks of this run.
    #[must_use]
    pub fn cycles(&self) -> PathCycles {
        if self.cycles.max == 0 {
            PathCycles::default()
        } else {
            self.cycles
        }
    }

    /// The sums of one channel of one analyser; `None` when they are not complete or there is no such analyser or channel.
    #[must_use]
    pub fn complete_sums(&self, analyser: u8, channel: u8) -> Option<CompleteSums> {
        let found = self.analysers.get(usize::from(analyser))?;
        if found.state() != AnalyserState::Complete {
            return None;
        }
        let (drive, first_scan, sums) = found.report(channel.into())?;
        Some(CompleteSums {
            drive,
            first_scan,
            rate_hz: self.progress.rate_hz,
            sums,
        })
    }

    /// Takes the scans of a block: values, sums, and copies for the link.
    #[inline(always)]
    pub fn sample(&mut self, inertial: &[[u16; INERTIAL]], jacks: &[[u16; JACKS]]) {
        let first_scan = self.progress.next_scan;
        let slot = self.queue.slot();
        sample_inertial(
            &self.prepared,
            &mut self.analysers,
            first_scan,
            inertial,
            slot.values,
            &mut self.steps,
        );
        let mut sums = [0; JACKS];
        add_up(jacks, &mut sums);
        for (analyser, step) in self.analysers.iter_mut().zip(&self.steps) {
            analyser.take_jacks(step, &sums);
        }
        copy(inertial, slot.inertial);
        copy(jacks, slot.jacks);
    }

    /// Counts the block of [`Self::sample`] and hands it to the link; then asks `cycles` how long it took.
    #[inline(always)]
    pub fn finish(&mut self, cycles: impl FnOnce() -> u32) {
        let kept = self.queue.close(self.progress.next_scan, self.wanted);
        let dropped = u32::from(self.wanted & !kept);
        self.progress.dropped = self.progress.dropped.wrapping_add(dropped);
        self.progress.next_scan += self.progress.block.scans() as u64;
        let last = cycles();
        self.cycles = PathCycles {
            min: self.cycles.min.min(last),
            max: self.cycles.max.max(last),
            last,
        };
    }
}

impl Default for Path {
    fn default() -> Self {
        Self::new()
    }
}

/// Copies scans, by the same instructions wherever they lie; a copy of the whole would depend on that. Two scans at a
/// time are whole words.
#[inline(always)]
fn copy<const N: usize>(from: &[[u16; N]], to: &mut [[u16; N]]) {
    let (from_pairs, from_rest) = from.as_chunks::<2>();
    let (to_pairs, to_rest) = to.as_chunks_mut::<2>();
    for (to, from) in to_pairs.iter_mut().zip(from_pairs) {
        let to = bytemuck::cast_slice_mut::<u16, u8>(to.as_flattened_mut());
        let from = bytemuck::cast_slice::<u16, u8>(from.as_flattened());
        let (to, from) = (to.as_chunks_mut::<4>().0, from.as_chunks::<4>().0);
        unrolled::<N>(
            #[inline(always)]
            |word| to[word] = from[word],
        );
        // Otherwise the compiler makes a call of it.
        compiler_fence(Ordering::SeqCst);
    }
    if let ([to], [from]) = (to_rest, from_rest) {
        unrolled::<N>(
            #[inline(always)]
            |channel| to[channel] = from[channel],
        );
        compiler_fence(Ordering::SeqCst);
    }
}

/// The nine inertial channels of a block: values and sums; the jacks go on with `steps`. Its instructions are counted on
/// the virtual board by the symbol of this function.
#[inline(never)]
fn sample_inertial(
    prepared: &Prepared,
    analysers: &mut [Analyser; ANALYSERS],
    first_scan: u64,
    counts: &[[u16; INERTIAL]],
    values: &mut [Values],
    steps: &mut [Step; ANALYSERS],
) {
    let mut sums = [0; INERTIAL];
    prepared.block(counts, values, &mut sums);
    for (analyser, step) in analysers.iter_mut().zip(steps) {
        analyser.take_inertial(first_scan, &sums, step);
    }
}
