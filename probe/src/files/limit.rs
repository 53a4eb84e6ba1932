//! How large files may be that are read whole.

/// How large a file may be that is read whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limit {
    /// Most bytes.
    pub bytes: u64,
    /// What such a file is.
    pub kind: &'static str,
}

/// What people write: geometry, sensors, plan, coefficients. The largest that hexsense writes has 20 kB.
pub const SETTINGS: Limit = Limit {
    bytes: 1 << 20,
    kind: "a file of settings",
};
/// What hexsense notes in a campaign's folder, as JSON.
pub const NOTES: Limit = Limit {
    bytes: 16 << 20,
    kind: "a note of a campaign",
};
/// The scans of a run: more than an hour at 1 kHz.
pub const CAPTURE: Limit = Limit {
    bytes: 1 << 30,
    kind: "a capture",
};
/// An export of the log. A whole volume has less than 2 MB.
pub const LOG: Limit = Limit {
    bytes: 16 << 20,
    kind: "an export of the log",
};
/// A key.
pub const KEY: Limit = Limit {
    bytes: 1_024,
    kind: "a key file",
};
