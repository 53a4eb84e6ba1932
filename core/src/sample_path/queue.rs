//! Blocks on their way to the link: a ring of scans, into which the sample path writes and out of which the link reads.
//!
//! ```text
//! scans:  0 ┄┄┄ │ next to send ▒▒▒▒▒▒▒▒▒▒▒▒ │ latest block │ ┄┄┄ 63
//!                 └ waiting ─────────────┘    └ written by every block, kept when it is wanted and there is room
//! ```
//!
//! Room is counted in scans, so that many small blocks fit or few large ones. Every size divides the ring: a block lies
//! in one part. What goes into one frame is a *piece*: a block, the half of a large one, or as many small ones as the
//! link gathers. The scans of a piece follow on one another, in the ring too, and have in common what seldom changes,
//! supply, temperature and set, a [`Context`], of which the latest few are kept; where they do not, a piece ends early.

use crate::channel::{INERTIAL, JACKS};
use crate::records::SetId;
use crate::sampling::{BlockSize, Values};
use crate::wire::telemetry::{MAX_SCANS, Samples};

/// Scans in the ring: 16 ms at 4 kHz, three times as long as the longest frame takes.
const SCANS: usize = 2 * BlockSize::MAX_SCANS;
/// Contexts that are kept. The supply is read ten times a second, and no block waits for a tenth of that.
const CONTEXTS: usize = 4;

/// What the scans of a block have in common.
#[derive(Clone, Copy)]
pub struct Context {
    /// Supply factor.
    pub supply: f32,
    /// Temperature of the die, °C.
    pub temperature_c: f32,
    /// Set that makes the values.
    pub set: Option<SetId>,
    /// Whether no good reading of the supply has come for a second.
    pub supply_is_old: bool,
}

impl Context {
    const NOTHING: Self = Self {
        supply: 0.0,
        temperature_c: 0.0,
        set: None,
        supply_is_old: false,
    };
}

/// First scan and context of a piece.
#[derive(Clone, Copy)]
struct Stamp {
    /// Scan counter, with the index of the context above its lower 56 bits.
    scan_and_context: u64,
}

impl Stamp {
    const CONTEXT: u32 = 56;

    fn new(first_scan: u64, context: usize) -> Self {
        Self {
            scan_and_context: first_scan | (context as u64) << Self::CONTEXT,
        }
    }

    fn first_scan(self) -> u64 {
        self.scan_and_context & ((1 << Self::CONTEXT) - 1)
    }

    fn context(self) -> usize {
        (self.scan_and_context >> Self::CONTEXT) as usize % CONTEXTS
    }
}

/// A piece to send, copied out of the queue, so that the sample path does not wait while a frame is made of it.
pub struct Piece {
    /// Scan counter of its first scan.
    pub first_scan: u64,
    /// Scans in it, at most [`MAX_SCANS`].
    pub scans: usize,
    /// Whether a block begins with it.
    pub begins: bool,
    /// The size of its blocks.
    pub block: BlockSize,
    /// What they have in common.
    pub context: Context,
    inertial: [[u16; INERTIAL]; MAX_SCANS],
    jacks: [[u16; JACKS]; MAX_SCANS],
    values: [Values; MAX_SCANS],
}

impl Piece {
    /// Room for a piece.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            first_scan: 0,
            scans: 0,
            begins: false,
            block: BlockSize::One,
            context: Context::NOTHING,
            inertial: [[0; INERTIAL]; MAX_SCANS],
            jacks: [[0; JACKS]; MAX_SCANS],
            values: [[0.0; INERTIAL]; MAX_SCANS],
        }
    }

    /// The samples.
    #[must_use]
    pub fn samples(&self) -> Samples<'_> {
        Samples {
            inertial: &self.inertial[..self.scans],
            jacks: &self.jacks[..self.scans],
            values: &self.values[..self.scans],
        }
    }
}

impl Default for Piece {
    fn default() -> Self {
        Self::new()
    }
}

/// Where the sample path writes a block.
pub struct Slot<'a> {
    /// Counts of the inertial channels.
    pub inertial: &'a mut [[u16; INERTIAL]],
    /// Counts of the jacks.
    pub jacks: &'a mut [[u16; JACKS]],
    /// Calibrated values.
    pub values: &'a mut [Values],
}

/// The ring. All zero is an empty one.
pub struct Queue {
    inertial: [[u16; INERTIAL]; SCANS],
    jacks: [[u16; JACKS]; SCANS],
    values: [Values; SCANS],
    stamps: [Stamp; SCANS],
    contexts: [Context; CONTEXTS],
    context: usize,
    block: BlockSize,
    /// Scans that must wait before a piece is due, 0 for as many as a block has.
    gathered: usize,
    /// Where the next block is written, a multiple of the block.
    head: usize,
    /// Scans before the head that wait to be sent.
    waiting: usize,
    /// Where the latest block is.
    latest: usize,
}

impl Default for Queue {
    fn default() -> Self {
        Self::new()
    }
}

impl Queue {
    /// An empty queue for blocks of one scan.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            inertial: [[0; INERTIAL]; SCANS],
            jacks: [[0; JACKS]; SCANS],
            values: [[0.0; INERTIAL]; SCANS],
            stamps: [Stamp {
                scan_and_context: 0,
            }; SCANS],
            contexts: [Context::NOTHING; CONTEXTS],
            context: 0,
            block: BlockSize::One,
            gathered: 0,
            head: 0,
            waiting: 0,
            latest: 0,
        }
    }

    /// Forgets what waits and goes on with blocks of another size.
    pub fn restart(&mut self, block: BlockSize) {
        (self.block, self.head, self.waiting, self.latest) = (block, 0, 0, 0);
    }

    /// From now on a piece is due when `scans` wait, at most [`MAX_SCANS`].
    pub fn gather(&mut self, scans: usize) {
        self.gathered = scans.min(MAX_SCANS);
    }

    /// Forgets what waits.
    pub fn forget(&mut self) {
        self.waiting = 0;
    }

    /// What the next blocks have in common; `false` when a piece that waits still has the place.
    pub fn set_context(&mut self, context: Context) -> bool {
        let next = (self.context + 1) % CONTEXTS;
        let oldest = self.stamps[self.tail()].context();
        if self.waiting > 0 && oldest == next {
            return false;
        }
        self.contexts[next] = context;
        self.context = next;
        true
    }

    /// Where the next block goes; there is always room to write it.
    #[inline(always)]
    pub fn slot(&mut self) -> Slot<'_> {
        let place = self.head..self.head + self.block.scans();
        // An empty slot instead of a panic, which is no part of the sample path.
        Slot {
            inertial: self.inertial.get_mut(place.clone()).unwrap_or_default(),
            jacks: self.jacks.get_mut(place.clone()).unwrap_or_default(),
            values: self.values.get_mut(place).unwrap_or_default(),
        }
    }

    /// Closes the block that was written to [`Self::slot`]. It is kept for the link when that is `wanted` and room for
    /// another remains, in the same time if not; returns whether it is.
    pub fn close(&mut self, first_scan: u64, wanted: bool) -> bool {
        let scans = self.block.scans();
        self.stamps[self.head % SCANS] = Stamp::new(first_scan, self.context);
        // The second piece of a block that has one, or the first once more: the same work for every size.
        let second = scans / 2 / MAX_SCANS * MAX_SCANS;
        self.stamps[(self.head + second) % SCANS] =
            Stamp::new(first_scan + second as u64, self.context);
        let kept = wanted & (self.waiting + 2 * scans <= SCANS);
        let step = scans * usize::from(kept);
        self.latest = self.head;
        self.head = (self.head + step) % SCANS;
        self.waiting += step;
        kept
    }

    /// Whether a piece is due.
    pub fn is_due(&self) -> bool {
        self.waiting >= self.unit().max(self.gathered)
    }

    /// Moves the next piece to send into `to`; `false` when none is due.
    pub fn take(&mut self, to: &mut Piece) -> bool {
        if !self.is_due() {
            return false;
        }
        let (first, scans) = (self.tail(), self.piece());
        let place = first..first + scans;
        let stamp = self.stamps[first];
        to.first_scan = stamp.first_scan();
        to.scans = scans;
        to.begins = first.is_multiple_of(self.block.scans());
        to.block = self.block;
        to.context = self.contexts[stamp.context()];
        to.inertial[..scans].copy_from_slice(&self.inertial[place.clone()]);
        to.jacks[..scans].copy_from_slice(&self.jacks[place.clone()]);
        to.values[..scans].copy_from_slice(&self.values[place]);
        self.waiting -= scans;
        true
    }

    /// Values of the latest block, whether it was kept or not, and the set that made them.
    pub fn latest_values(&self) -> Option<&[Values]> {
        let context = self.contexts[self.stamps[self.latest].context()];
        context
            .set
            .map(|_| &self.values[self.latest..self.latest + self.block.scans()])
    }

    /// Scans with one stamp: those of a block, or of a large block's half.
    fn unit(&self) -> usize {
        self.block.scans().min(MAX_SCANS)
    }

    /// Scans of the next piece: as many as are gathered, or those up to where the next does not follow on them.
    fn piece(&self) -> usize {
        let (tail, unit) = (self.tail(), self.unit());
        let first = self.stamps[tail].scan_and_context;
        let mut scans = unit;
        while scans < self.gathered
            && tail + scans < SCANS
            && self.stamps[tail + scans].scan_and_context == first + scans as u64
        {
            scans += unit;
        }
        scans
    }

    fn tail(&self) -> usize {
        (self.head + SCANS - self.waiting) % SCANS
    }
}
