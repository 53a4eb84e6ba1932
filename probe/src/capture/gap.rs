//! Scans that are missing.

/// A stretch of scans that did not arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gap {
    /// Counter of the first scan that is missing.
    pub first_scan: u64,
    /// How many are missing.
    pub scans: u64,
}

impl Gap {
    /// The gap before `scan` when the scan `expected` is due; `None` when none is missing.
    #[must_use]
    pub fn between(expected: u64, scan: u64) -> Option<Self> {
        let scans = scan.checked_sub(expected).filter(|scans| *scans > 0)?;
        Some(Self {
            first_scan: expected,
            scans,
        })
    }
}
