//! Where a recording goes: the interface of all sinks.
//!
//! ```text
//! begin ── block ── block ── gap ── block ── … ── end
//! ```
//!
//! The [recorder](super::recorder) calls a sink in this order. Without an `end` the recording broke off, and what the sink
//! has by then must stay readable.

use hexsense_core::records::SetId;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::StreamContent;
use hexsense_core::wire::telemetry::Block;

use crate::campaign::BoardRecord;
use crate::capture::Gap;
use crate::files::FileError;

/// Takes a recording, block by block.
pub trait Sink {
    /// Begins a recording. One that has begun and not ended is dropped: its blocks were of no use.
    ///
    /// # Errors
    /// [`FileError`].
    fn begin(&mut self, notes: &Notes) -> Result<(), FileError>;

    /// Takes the next block. It has what the notes name as content.
    ///
    /// # Errors
    /// [`FileError`].
    fn block(&mut self, block: &Block) -> Result<(), FileError>;

    /// Learns that scans are missing between the last block and the next.
    ///
    /// # Errors
    /// [`FileError`].
    fn gap(&mut self, gap: Gap) -> Result<(), FileError>;

    /// Completes the recording.
    ///
    /// # Errors
    /// [`FileError`].
    fn end(&mut self, recorded: &Recorded) -> Result<(), FileError>;
}

/// What a recording belongs to.
#[derive(Debug, Clone, PartialEq)]
pub struct Notes {
    /// The board.
    pub board: BoardRecord,
    /// The set that is active on it, and that stays active during the recording.
    pub set: Option<SetId>,
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Scans that the board takes at a time.
    pub block: BlockSize,
    /// What it streams.
    pub content: StreamContent,
}

/// What is in a recording, and what is missing from it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Recorded {
    /// Scans in the recording.
    pub scans: u64,
    /// Scans that are missing between the first and the last.
    pub lost: u64,
    /// Where they are missing.
    pub gaps: Vec<Gap>,
}
