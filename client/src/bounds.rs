//! What a board can say. A number beyond these bounds comes from something else than a board, or from one that is defective;
//! it is refused by name ([`ProtocolError::Impossible`]) before anything is computed, stored or printed with it.
//!
//! Behind these checks sums of counters and products with rates cannot overflow, and no answer makes the host keep more
//! than a few megabytes.

use std::fmt::Display;
use std::ops::RangeInclusive;

use hexsense_core::facts::{ARCHIVE_PAGES, BoardFacts};
use hexsense_core::records::MAX_ENCODED;
use hexsense_core::wire::message::ActiveSet;
use hexsense_core::wire::status::Resets;
use hexsense_core::wire::telemetry::Header;
use hexsense_core::wire::{BoardPose, PoseReport, Status};

use super::error::ProtocolError;

/// Largest counter of scans, and largest time in ms: a double has every integer up to here, and so has JSON. At 4 kHz it
/// is reached after 71,000 years.
pub const MAX_COUNT: u64 = 1 << 53;
/// Highest scan rate, Hz.
pub const MAX_RATE_HZ: u32 = 1_000_000;
/// Most sets that a board keeps.
pub const MAX_SETS: usize = ARCHIVE_PAGES as usize;
/// Most entries of a log: a flash bank of 256 KiB has room for fewer.
pub const MAX_LOG: usize = 16_384;
/// No position of a motion base is farther from its origin, m.
const MAX_POSITION_M: f32 = 100.0;
/// Lengths of the quaternion of a rotation; rounding moves it off one by 1e-6.
const ROTATION: RangeInclusive<f32> = 0.99..=1.01;

/// What one message says, field by field.
pub(crate) struct Said(pub &'static str);

impl Said {
    /// Refuses a value outside of its range.
    pub fn within<T: PartialOrd + Display>(
        &self,
        field: &'static str,
        value: T,
        range: RangeInclusive<T>,
    ) -> Result<(), ProtocolError> {
        if range.contains(&value) {
            return Ok(());
        }
        Err(ProtocolError::Impossible {
            message: self.0,
            field,
            value: value.to_string(),
            limit: format!("{} to {}", range.start(), range.end()),
        })
    }

    fn count(&self, field: &'static str, value: u64) -> Result<(), ProtocolError> {
        self.within(field, value, 0..=MAX_COUNT)
    }

    fn rate(&self, hz: u32) -> Result<(), ProtocolError> {
        self.within("the scan rate in Hz", hz, 1..=MAX_RATE_HZ)
    }
}

/// Whether numbers of a board can be right.
///
/// # Errors
/// [`ProtocolError::Impossible`].
pub fn facts(facts: &BoardFacts) -> Result<(), ProtocolError> {
    let said = Said("identity");
    facts.rates_hz.iter().try_for_each(|hz| said.rate(*hz))?;
    said.within("the time of a rank in ns", facts.rank_ns, 1..=1_000_000_000)?;
    let counts = facts.counts_at_supply;
    said.within("the count at supply", counts, 1..=65_536)?;
    let nominal = facts.nominal_supply_v;
    said.within("the nominal supply in V", nominal, 0.1..=100.0)?;
    said.within("the line's speed in bit/s", facts.baud, 1..=1_000_000_000)?;
    let page = facts.flash.page_bytes;
    said.within("the bytes of a flash page", page, 1..=65_536)?;
    said.within("the number of flash pages", facts.flash.pages, 1..=4_096)
}

pub(crate) fn status(status: &Status) -> Result<(), ProtocolError> {
    let said = Said("status");
    said.rate(status.rate_hz)?;
    said.count("the number of scans", status.scans)?;
    said.count("the number of lost scans", status.scans_lost)?;
    said.count("the first lost scan", status.first_lost_scan.unwrap_or(0))?;
    said.count("the uptime in ms", status.uptime_ms)?;
    let first = status.first_with_set_ms.unwrap_or(0);
    said.count("the time of the first block with a set in ms", first)?;
    let Resets {
        previous_uptime_ms, ..
    } = status.resets;
    let previous = previous_uptime_ms.unwrap_or(0);
    said.count("the uptime before the start in ms", previous)
}

/// The number of the first scan of harmonics or sums.
pub(crate) fn first_scan(message: &'static str, scan: u64) -> Result<(), ProtocolError> {
    Said(message).count("the first scan", scan)
}

pub(crate) fn active_set(active: &ActiveSet) -> Result<(), ProtocolError> {
    let length = usize::from(active.length);
    Said("active set").within("the length in bytes", length, 1..=MAX_ENCODED)
}

pub(crate) fn block(header: &Header) -> Result<(), ProtocolError> {
    let said = Said("block of samples");
    said.rate(header.rate_hz)?;
    said.count("the first scan", header.first_scan)
}

pub(crate) fn pose(report: &PoseReport) -> Result<(), ProtocolError> {
    let said = Said("pose");
    said.count("the first scan", report.first_scan)?;
    let Ok(BoardPose {
        position_m,
        rotation,
        ..
    }) = report.outcome
    else {
        return Ok(());
    };
    for coordinate in position_m {
        let range = -MAX_POSITION_M..=MAX_POSITION_M;
        said.within("a coordinate in m", coordinate, range)?;
    }
    let norm = rotation.iter().map(|part| part * part).sum::<f32>().sqrt();
    said.within("the length of the quaternion", norm, ROTATION)
}
