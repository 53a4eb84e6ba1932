//! How the board is: the answer to [`super::Request::Status`], and its parts.

use serde::{Deserialize, Serialize};

use super::message::HarmonicState;
use crate::harmonics::ANALYSERS;
use crate::sampling::BlockSize;

/// Why the board last started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// The supply came up.
    PowerOn,
    /// The reset pin.
    Pin,
    /// The firmware asked for it, after a panic or on purpose.
    Software,
    /// The watchdog bit.
    Watchdog,
    /// Anything else that the chip reports.
    Other,
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
    /// Times that the converters were started anew because a result was not fetched or a block not read in time.
    pub faults: u32,
    /// Core cycles that the sample path took for a block.
    pub path_cycles: PathCycles,
    /// How far each analyser is.
    pub analysers: [HarmonicState; ANALYSERS],
    /// Blocks that the link could not carry.
    pub blocks_dropped: u32,
    /// Received frames that were damaged.
    pub frames_damaged: u32,
    /// Whether the crystal drives the clock; without it the board is not fit to calibrate.
    pub crystal: bool,
    /// Supply factor VDDA / 3.3 V.
    pub supply: f32,
    /// Temperature of the die, °C.
    pub temperature_c: f32,
    /// Whether the die is within 10 K of the temperature of the calibration.
    pub in_calibrated_range: bool,
    /// Tilt by the accelerometers, roll and pitch in rad; approximate, for a quick look only.
    pub tilt_approximate_rad: Option<[f32; 2]>,
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
