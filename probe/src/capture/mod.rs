//! A capture: what the board sent during one run, as a CSV file that any tool opens.
//!
//! ```text
//! scan,ax,ay,az,ex,ey,ez,wx,wy,wz,jack1,…,jack6,supply,temperature_c[,ax_m_s2,…,wz_rad_s]
//! ```
//!
//! | column | meaning |
//! |---|---|
//! | `scan` | counter of the scan since the board's start; scans that were lost are missing rows |
//! | `ax` … `jack6` | raw counts, 65536 at the supply voltage |
//! | `supply` | supply factor c of the scan's block; counts · c mean the same at every supply |
//! | `temperature_c` | temperature of the die |
//! | `ax_m_s2` … `wz_rad_s` | the board's own calibrated values, where they were streamed |
//!
//! Numbers are written with the digits that bring back the very same number, so equal input gives equal bytes.
//!
//! A capture that is under way, or that broke off, is the file `NAME.csv.part` of the same format. It becomes `NAME.csv`
//! when it is complete, so the name shows whether it is complete. Every block is handed to the system as it comes, and the
//! system writes it to the disk twice a second: when hexsense is killed or the power goes, everything up to the last second
//! is there. Only the last row can be torn then; [`Capture::salvage`] passes over it and reports it.
//!
//! - `gap`: [`Gap`], scans that are missing.
//! - `reader`: from the file to a [`Capture`].
//! - `writer`: [`CaptureWriter`], from blocks to the file.

mod gap;
mod reader;
mod writer;

use std::ops::Range;

use hexsense_core::channel::{NAMES, Scan, Triad};
use hexsense_core::sampling::Values;

pub use gap::Gap;
pub use reader::Torn;
pub use writer::CaptureWriter;

/// A capture in memory: one entry of each list for each scan that arrived.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Capture {
    /// Counters of the scans, rising.
    pub scans: Vec<u64>,
    /// Raw counts.
    pub counts: Vec<Scan>,
    /// Supply factors.
    pub supply: Vec<f32>,
    /// Temperatures of the die, °C.
    pub temperature_c: Vec<f32>,
    /// Values calibrated by the board, when they were streamed.
    pub values: Option<Vec<Values>>,
}

impl Capture {
    /// The scans that are missing between the first and the last.
    #[must_use]
    pub fn gaps(&self) -> Vec<Gap> {
        let pairs = self.scans.windows(2);
        pairs
            .filter_map(|pair| Gap::between(pair[0] + 1, pair[1]))
            .collect()
    }

    /// Indices of `scans` scans from counter `first_scan` on; `None` when a scan is missing or `scans` is zero.
    #[must_use]
    pub fn window(&self, first_scan: u64, scans: usize) -> Option<Range<usize>> {
        let first = self.scans.binary_search(&first_scan).ok()?;
        let last = first + scans.checked_sub(1)?;
        (*self.scans.get(last)? == first_scan + scans as u64 - 1).then_some(first..last + 1)
    }
}

/// The first line of a capture file, without the newline.
fn header(values: bool) -> String {
    let mut header = format!("scan,{},supply,temperature_c", NAMES.join(","));
    if values {
        for triad in Triad::ALL {
            let unit = match triad {
                Triad::LinearAcceleration => "m_s2",
                Triad::AngularAcceleration => "rad_s2",
                Triad::AngularRate => "rad_s",
            };
            for name in &NAMES[triad.first_channel()..][..3] {
                header = header + "," + name + "_" + unit;
            }
        }
    }
    header
}
