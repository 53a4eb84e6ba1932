//! Which scans are missing from a stream, and how the stream itself explains them.
//!
//! The numbers of the frames show a frame that was damaged on the line. The header's count of dropped blocks shows a block
//! that the link could not carry. Other missing scans were lost in the converters, and the board's status must count them.

use crate::line::Line;

/// Most scans of a frame.
const FRAME: u64 = hexsense_core::wire::telemetry::MAX_SCANS as u64;

/// The scans that are missing between the blocks.
#[derive(Debug, Default)]
pub struct Gaps {
    /// Scan and frame that are due, and blocks dropped before.
    due: Option<(u64, u16, u32)>,
    /// Scans that arrived.
    pub scans: u64,
    /// Scans that did not arrive.
    pub missing: u64,
    /// Frames that were lost on the line.
    pub frames: u64,
    /// Blocks that the link dropped, as the headers count them.
    pub dropped: u64,
    /// Scans that arrived twice or too late.
    pub repeated: u64,
}

impl Gaps {
    /// Takes the blocks that have arrived.
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
