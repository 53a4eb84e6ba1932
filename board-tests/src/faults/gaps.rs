//! The sample counter as it arrives: which scans are missing, and what the stream itself says of them.
//!
//! A frame that was damaged on the line shows in the numbers of the frames, a block that the link could not carry in the
//! header's count of dropped blocks. What is missing beyond that was lost in the converters, and the board's status must
//! say so.

use crate::line::Line;

/// Most scans of a frame.
const FRAME: u64 = hexsense_core::wire::telemetry::MAX_SCANS as u64;

/// What is missing between the blocks that came.
#[derive(Debug, Default)]
pub struct Gaps {
    /// Scan and frame that are due, and blocks dropped before.
    due: Option<(u64, u16, u32)>,
    /// Scans that came.
    pub scans: u64,
    /// Scans that did not.
    pub missing: u64,
    /// Frames that were lost on the line.
    pub frames: u64,
    /// Blocks that the link dropped, by its own account.
    pub dropped: u64,
    /// Scans that came a second time, or back in time.
    pub repeated: u64,
}

impl Gaps {
    /// Takes the blocks that have come.
    pub fn follow(&mut self, line: &mut Line) {
        for arrived in line.blocks.drain(..) {
            let (sequence, header) = (arrived.sequence, arrived.block.header);
            if let Some((scan, frame, dropped)) = self.due {
                self.missing += header.first_scan.saturating_sub(scan);
                self.repeated += scan.saturating_sub(header.first_scan);
                self.frames += u64::from(sequence.wrapping_sub(frame));
                self.dropped += u64::from(header.dropped.saturating_sub(dropped));
            }
            let next = header.first_scan + u64::from(header.scans);
            self.due = Some((next, sequence.wrapping_add(1), header.dropped));
            self.scans += u64::from(header.scans);
        }
    }

    /// Missing scans that neither the line nor the link nor the `lost` scans of the board's status explain; `block` is
    /// the number of scans of a block.
    pub fn unexplained(&self, lost: u64, block: u64) -> u64 {
        let explained = self.frames * FRAME + self.dropped * block + lost;
        self.missing.saturating_sub(explained) + self.repeated
    }
}
