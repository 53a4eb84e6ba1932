//! What differs from board to board: one value, which the firmware gives to the core and the board sends to the host
//! in its [`Identity`](crate::wire::Identity).
//!
//! The core computes with these numbers and knows no chip. A host that talks to a board takes them from the board.
//!
//! ```text
//! trigger ──▶│ rank 0 │ rank 1 │ …      each rank takes rank_ns; a channel is sampled in the middle of its rank
//! count = counts_at_supply · voltage / supply            supply factor c = supply / nominal_supply_v
//! flash bank: │ sets, one to a page │ key, two pages │ log … │
//! ```

use core::ops::Range;

use serde::{Deserialize, Serialize};

use crate::channel::INERTIAL;

/// Pages of the archive: one for each set that is kept. The data sheet (DS12288) guarantees 10,000 erasures of a page; an
/// upload erases one of them.
pub const ARCHIVE_PAGES: u32 = 8;
/// Pages of the key: a new one is written beside the old one.
const KEY_PAGES: u32 = 2;

/// The least and the largest supply factor that a working board can have. A regulator holds its nominal output to a few
/// percent, and the chip is made for 3.6 V at most, factor 1.09 (DS12288, general operating conditions); the reference
/// that the supply is measured against, 1.182 to 1.232 V (DS12288, embedded voltage reference), is off by 2 % at most when
/// its calibration is lost.
pub const SUPPLY_FACTORS: [f32; 2] = [0.9, 1.1];

/// The numbers of one kind of board.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BoardFacts {
    /// Scan rates that the board offers, Hz. The first is used after a start.
    pub rates_hz: [u32; 3],
    /// Time from one rank of a scan to the next, ns.
    pub rank_ns: u32,
    /// Count that the supply voltage would read; the largest count of a `u16` or one more.
    pub counts_at_supply: u32,
    /// Supply at which the supply factor is one, V.
    pub nominal_supply_v: f32,
    /// Speed of the serial line, bit/s.
    pub baud: u32,
    /// The flash that the board keeps coefficients, key and log in.
    pub flash: FlashLayout,
}

impl BoardFacts {
    /// Instant at which a channel (0 to 14) is sampled, s after the trigger of its scan: the middle of its rank. The
    /// inertial channels are ranks 0 to 8 of one converter, the jacks ranks 0 to 5 of another.
    #[must_use]
    pub fn instant_s(&self, channel: usize) -> f64 {
        let rank = channel.checked_sub(INERTIAL).unwrap_or(channel);
        (rank as f64 + 0.5) * f64::from(self.rank_ns) * 1e-9
    }

    /// The part of the line that telemetry may use, bit/s: the rest is for answers.
    #[must_use]
    pub const fn max_telemetry_bits_per_s(&self) -> u32 {
        self.baud / 5 * 4
    }
}

/// Pages of the flash, from its first address on: archive, key, log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct FlashLayout {
    /// Size of a page, the smallest unit that is erased, bytes.
    pub page_bytes: u32,
    /// Number of pages, at least eleven: eight of the archive, two of the key, and the log.
    pub pages: u32,
}

impl FlashLayout {
    /// Address of the archive, bytes.
    pub const ARCHIVE: u32 = 0;

    /// Address of the first page of the key, bytes.
    #[must_use]
    pub const fn key(&self) -> u32 {
        ARCHIVE_PAGES * self.page_bytes
    }

    /// Addresses of the log, bytes: of 128 pages of 2 KiB it takes 118.
    #[must_use]
    pub const fn log(&self) -> Range<u32> {
        (ARCHIVE_PAGES + KEY_PAGES) * self.page_bytes..self.pages * self.page_bytes
    }
}
