//! The state of the board: the answer to [`super::Request::Status`], and its parts.

use serde::{Deserialize, Serialize};

use crate::harmonics::{ANALYSERS, AnalyserState};
use crate::sampling::BlockSize;

/// Why the board last started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// The supply came up, and RAM had lost its content.
    PowerOn,
    /// The supply dipped, and RAM kept its content.
    BrownOut,
    /// The reset pin.
    Pin,
    /// Software requested it without a panic: usually a debugger.
    Software,
    /// The firmware panicked or faulted; [`Status::panic`] says how.
    Panic,
    /// The watchdog bit: a part of the board made no progress.
    Watchdog,
    /// Another cause that the chip reports.
    Other,
    /// The crystal failed; the board started again on its internal oscillator.
    Crystal,
}

/// Starts of the board since its power came on, by cause. RAM keeps the counts over resets.
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
    /// By another cause.
    pub other: u32,
    /// Uptime at the last reset, ms, to within the interval at which the watchdog is fed: 0.1 s, or 1 s after a
    /// watchdog reset. `None` after power-on, and when that run was shorter.
    pub previous_uptime_ms: Option<u64>,
    /// Because the crystal failed.
    pub crystal: u32,
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
            ResetCause::Crystal => Some(&mut self.crystal),
        };
        for count in of_cause.into_iter().chain([&mut self.starts]) {
            *count = count.saturating_add(1);
        }
    }
}

/// The count of an event, and its last time.
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

    /// Counts one event at this uptime.
    pub fn note(&mut self, uptime_ms: u64) {
        *self = Self {
            count: self.count.saturating_add(1),
            last_ms: uptime_ms,
        };
    }
}

/// Faults since the start. Each of them lost data or could have.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Events {
    /// The next result of a converter came before the last was fetched. The converters were restarted.
    pub overruns: EventCount,
    /// A block was overwritten before it was read. The converters were restarted.
    pub late_blocks: EventCount,
    /// The converters gave no block and were restarted.
    pub stuck: EventCount,
    /// The link had no room for a block.
    pub blocks_dropped: EventCount,
    /// An answer or a block could not be sent.
    pub frames_unsent: EventCount,
    /// Received bytes between two zeros were not COBS.
    pub frames_not_cobs: EventCount,
    /// A received frame was too short or too long.
    pub frames_of_wrong_length: EventCount,
    /// The checksum of a received frame did not match.
    pub frames_of_wrong_checksum: EventCount,
    /// The kind of a received frame was not one that a host sends.
    pub frames_of_wrong_kind: EventCount,
    /// Bytes came faster than they were taken from the receiver.
    pub receiver_overruns: EventCount,
    /// The receiver saw a framing error or noise.
    pub receiver_errors: EventCount,
    /// The flash corrected a bit of a word that was read.
    pub flash_corrections: EventCount,
    /// A torn word of flash was read, whose programming or erasure had been cut short.
    pub torn_words: EventCount,
    /// A result of a converter was lost or taken twice on its way into memory, so that the counts were those of other
    /// channels. The converters were restarted.
    pub slips: EventCount,
    /// A reading of supply and temperature did not come, or no working board has it. The mean of the good ones stays.
    pub supply_refused: EventCount,
    /// The coefficients at work were not those of the stored set. They were read from flash again.
    pub coefficients_restored: EventCount,
    /// A change had the wrong tag: it came from somebody without the board's key.
    pub wrong_tags: EventCount,
    /// A change, or a step of an upload, was refused for another reason.
    pub changes_refused: EventCount,
    /// Another request was refused. A board that is busy refuses nothing.
    pub requests_refused: EventCount,
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
        slips: EventCount::NONE,
        supply_refused: EventCount::NONE,
        coefficients_restored: EventCount::NONE,
        wrong_tags: EventCount::NONE,
        changes_refused: EventCount::NONE,
        requests_refused: EventCount::NONE,
    };

    /// Restarts of the converters after a fault.
    #[must_use]
    pub fn converter_faults(&self) -> u32 {
        total([self.overruns, self.late_blocks, self.stuck, self.slips])
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

fn total<const N: usize>(counts: [EventCount; N]) -> u32 {
    counts
        .iter()
        .fold(0, |sum, event| sum.saturating_add(event.count))
}

/// Use of the single stack of tasks and interrupts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct StackUse {
    /// Most bytes in use since the start.
    pub deepest: u32,
    /// Bytes of the stack.
    pub size: u32,
}

/// The option bytes of the chip that decide what its flash does: settings that a debug probe makes, outside of the
/// firmware.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct OptionBytes {
    /// Whether the flash has two banks (DBANK). With one bank the board takes no changes.
    pub dual_bank: bool,
    /// Level of the readout protection (RDP): 0, 1 or 2.
    pub readout_protection: u8,
    /// Level of the supply at which the chip resets (BOR_LEV): 0 to 4, from 1.7 to 2.8 V.
    pub brown_out_level: u8,
    /// First and last page of each area that is protected from writing (WRP1A, WRP1B, WRP2A, WRP2B), in pages of its bank,
    /// or of the whole flash when it has one bank.
    pub write_protected: [Option<(u8, u8)>; 4],
}

impl OptionBytes {
    /// As the chip leaves its factory.
    pub const FACTORY: Self = Self {
        dual_bank: true,
        readout_protection: 0,
        brown_out_level: 0,
        write_protected: [None; 4],
    };

    /// Whether the board can write what it keeps: the flash has two banks, and no page of the second is protected.
    #[must_use]
    pub fn allow_changes(&self) -> bool {
        let [_, _, second @ ..] = self.write_protected;
        self.dual_bank && second == [None; 2]
    }
}

/// The state of the board. Counters count from the last start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Time since start, ms.
    pub uptime_ms: u64,
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Scans taken.
    pub scans: u64,
    /// Scans of a block, see [`super::Request::Block`].
    pub block: BlockSize,
    /// Scans lost: in the converters, in their rings, and during restarts.
    pub scans_lost: u64,
    /// Scan counter of the first scan that was lost.
    pub first_lost_scan: Option<u64>,
    /// Faults, with count and last time.
    pub events: Events,
    /// Uptime at the first block with a set, ms.
    pub first_with_set_ms: Option<u64>,
    /// Core cycles of the sample path for a block.
    pub path_cycles: PathCycles,
    /// Progress of each analyser.
    pub analysers: [AnalyserState; ANALYSERS],
    /// Whether the crystal drives the clock; without it the board is not fit to calibrate.
    pub crystal: bool,
    /// Supply factor VDDA / 3.3 V.
    pub supply: f32,
    /// Number of supply readings in this mean: 16, but fewer in the first 0.3 s after a start, and 0 before the first,
    /// when supply and temperature are not known. With n of them its noise is √(16 / n) times as large.
    pub supply_readings: u8,
    /// Temperature of the die, °C.
    pub temperature_c: f32,
    /// Whether the die is within 10 K of the temperature of the calibration.
    pub in_calibrated_range: bool,
    /// Tilt by the accelerometers, roll and pitch in rad; approximate, for a quick look only.
    pub tilt_approximate_rad: Option<[f32; 2]>,
    /// Why the board started, and how often.
    pub resets: Resets,
    /// Use of the stack.
    pub stack: StackUse,
    /// Whether the board has a key; without one it takes no changes.
    pub provisioned: bool,
    /// The message of a panic before the last start.
    pub panic: Option<heapless::String<128>>,
    /// Option bytes of the chip.
    pub option_bytes: OptionBytes,
    /// Whether no good reading of the supply has come for a second.
    pub supply_is_old: bool,
    /// Whether the board had a key and cannot read it any more; it takes no changes then.
    pub key_damaged: bool,
    /// Places of the log's volume that are used, of [`capacity`](crate::records::log::capacity).
    /// `None` when the flash has no record of this firmware and is not erased: the first key makes it the board's.
    pub log_used: Option<u32>,
}

/// Core cycles from the first to the last instruction of the sample path, since the converters last started; all zero
/// before the first block.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PathCycles {
    /// Least of all blocks.
    pub min: u32,
    /// Most of all blocks.
    pub max: u32,
    /// Latest block.
    pub last: u32,
}
