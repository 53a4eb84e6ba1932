//! How the board is: the answer to [`super::Request::Status`], and its parts.

use serde::{Deserialize, Serialize};

use crate::harmonics::{ANALYSERS, AnalyserState};
use crate::sampling::BlockSize;

/// Why the board last started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// The supply came up, and what RAM had held was gone.
    PowerOn,
    /// The supply dipped, and RAM kept what it held.
    BrownOut,
    /// The reset pin.
    Pin,
    /// Software asked for it, and there was no panic: a debugger, as a rule.
    Software,
    /// The firmware panicked or faulted; [`Status::panic`] says how.
    Panic,
    /// The watchdog bit: a part of the board made no progress.
    Watchdog,
    /// Anything else that the chip reports.
    Other,
}

/// How often the board started since its power came on, and why. It is kept in RAM over resets.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resets {
    /// Starts, the one at power-on included.
    pub starts: u32,
    /// Resets of each cause, see [`ResetCause`].
    pub brown_outs: u32,
    /// By the pin.
    pub pin: u32,
    /// By software.
    pub software: u32,
    /// By a panic or a fault.
    pub panics: u32,
    /// By the watchdog.
    pub watchdog: u32,
    /// By anything else.
    pub other: u32,
    /// How long the board had run when the last reset came, ms, to within the time in which the watchdog is fed: 0.1 s,
    /// or 1 s when it bit. `None` after power-on, and when that run was shorter.
    pub previous_uptime_ms: Option<u64>,
}

impl Resets {
    /// Counts a start.
    pub fn count(&mut self, cause: ResetCause) {
        let of_cause = match cause {
            ResetCause::PowerOn => None,
            ResetCause::BrownOut => Some(&mut self.brown_outs),
            ResetCause::Pin => Some(&mut self.pin),
            ResetCause::Software => Some(&mut self.software),
            ResetCause::Panic => Some(&mut self.panics),
            ResetCause::Watchdog => Some(&mut self.watchdog),
            ResetCause::Other => Some(&mut self.other),
        };
        for count in of_cause.into_iter().chain([&mut self.starts]) {
            *count = count.saturating_add(1);
        }
    }
}

/// How often something happened, and when last.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EventCount {
    /// Times since the start; the count stops at its largest value.
    pub count: u32,
    /// Uptime at the last time, ms; 0 when it never happened.
    pub last_ms: u64,
}

impl EventCount {
    /// Never.
    pub const NONE: Self = Self {
        count: 0,
        last_ms: 0,
    };

    /// Counts one more, at this uptime.
    pub fn note(&mut self, uptime_ms: u64) {
        *self = Self {
            count: self.count.saturating_add(1),
            last_ms: uptime_ms,
        };
    }
}

/// What went wrong since the start. Each of them lost something or could have.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Events {
    /// A result of a converter was not fetched before the next came. The converters were started anew.
    pub overruns: EventCount,
    /// A block was not read before it was overwritten. The converters were started anew.
    pub late_blocks: EventCount,
    /// The converters gave no block. They were started anew.
    pub stuck: EventCount,
    /// The link had no room for a block.
    pub blocks_dropped: EventCount,
    /// An answer or a block could not be sent.
    pub frames_unsent: EventCount,
    /// Received bytes between two zeros were not COBS.
    pub frames_not_cobs: EventCount,
    /// A received frame was too short or too long to be one.
    pub frames_of_wrong_length: EventCount,
    /// The checksum of a received frame did not fit.
    pub frames_of_wrong_checksum: EventCount,
    /// A received frame was of no kind that a host sends.
    pub frames_of_wrong_kind: EventCount,
    /// Bytes came faster than they were taken from the receiver.
    pub receiver_overruns: EventCount,
    /// The receiver saw a framing error or noise.
    pub receiver_errors: EventCount,
    /// The flash corrected a bit of a word that was read.
    pub flash_corrections: EventCount,
    /// A torn word of flash was read: one whose programming or erasure had been cut short.
    pub torn_words: EventCount,
}

impl Events {
    /// None yet.
    pub const NONE: Self = Self {
        overruns: EventCount::NONE,
        late_blocks: EventCount::NONE,
        stuck: EventCount::NONE,
        blocks_dropped: EventCount::NONE,
        frames_unsent: EventCount::NONE,
        frames_not_cobs: EventCount::NONE,
        frames_of_wrong_length: EventCount::NONE,
        frames_of_wrong_checksum: EventCount::NONE,
        frames_of_wrong_kind: EventCount::NONE,
        receiver_overruns: EventCount::NONE,
        receiver_errors: EventCount::NONE,
        flash_corrections: EventCount::NONE,
        torn_words: EventCount::NONE,
    };

    /// Times that the converters were started anew after a fault.
    #[must_use]
    pub fn converter_faults(&self) -> u32 {
        total([self.overruns, self.late_blocks, self.stuck])
    }

    /// Received frames that were damaged.
    #[must_use]
    pub fn frames_damaged(&self) -> u32 {
        total([
            self.frames_not_cobs,
            self.frames_of_wrong_length,
            self.frames_of_wrong_checksum,
            self.frames_of_wrong_kind,
        ])
    }
}

fn total<const N: usize>(tallies: [EventCount; N]) -> u32 {
    tallies
        .iter()
        .fold(0, |sum, tally| sum.saturating_add(tally.count))
}

/// Use of the one stack, on which tasks and interrupts run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct StackUse {
    /// Most bytes in use at a time since the start.
    pub deepest: u32,
    /// Bytes that there are.
    pub size: u32,
}

/// How the board is. Counters count from the last start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Time since start, ms.
    pub uptime_ms: u64,
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Scans taken.
    pub scans: u64,
    /// Scans that are taken at a time, see [`super::Request::Block`].
    pub block: BlockSize,
    /// Scans lost: in the converters, in their rings, and while they were started anew.
    pub scans_lost: u64,
    /// Scan counter of the first scan that was lost.
    pub first_lost_scan: Option<u64>,
    /// What went wrong, how often and when last.
    pub events: Events,
    /// Uptime at the first block that was taken with a set, ms.
    pub first_with_set_ms: Option<u64>,
    /// Core cycles that the sample path took for a block.
    pub path_cycles: PathCycles,
    /// How far each analyser is.
    pub analysers: [AnalyserState; ANALYSERS],
    /// Whether the crystal drives the clock; without it the board is not fit to calibrate.
    pub crystal: bool,
    /// Supply factor VDDA / 3.3 V.
    pub supply: f32,
    /// Readings of the supply that this factor is the mean of: 16, but fewer in the first 0.3 s after a start, and 0
    /// before the first. With n of them its noise is √(16 / n) times as large.
    pub supply_readings: u8,
    /// Temperature of the die, °C.
    pub temperature_c: f32,
    /// Whether the die is within 10 K of the temperature of the calibration.
    pub in_calibrated_range: bool,
    /// Tilt by the accelerometers, roll and pitch in rad; approximate, for a quick look only.
    pub tilt_approximate_rad: Option<[f32; 2]>,
    /// Why the board started, and how often.
    pub resets: Resets,
    /// How much of the stack is used.
    pub stack: StackUse,
    /// Whether the board has a key; without one it takes no changes.
    pub provisioned: bool,
    /// The message of a panic before the last start.
    pub panic: Option<heapless::String<128>>,
}

/// Core cycles from the first to the last instruction of the sample path, since the converters were last started; all
/// zero before the first block.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PathCycles {
    /// Least of all blocks.
    pub min: u32,
    /// Most of all blocks.
    pub max: u32,
    /// Latest block.
    pub last: u32,
}
