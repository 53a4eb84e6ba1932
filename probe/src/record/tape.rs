//! The capture of a run as it grows, and the count of what is missing from it.

use std::ops::Range;
use std::path::Path;

use hexsense_core::wire::telemetry::Block;

use super::RecordError;
use crate::capture::CaptureWriter;
use crate::files::FileError;

/// What has been written so far.
pub struct Tape {
    writer: CaptureWriter,
    next_scan: u64,
    taped: Taped,
}

/// What is in a capture, and what is missing from it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Taped {
    /// Scans in the capture.
    pub scans: u64,
    /// Scans that are missing between the first and the last.
    pub lost: u64,
    /// Where they are missing.
    pub gaps: Vec<Missing>,
}

/// A stretch of scans that did not arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Missing {
    /// Counter of the first of them.
    pub first_scan: u64,
    /// How many they are.
    pub scans: u64,
}

impl Tape {
    /// An empty tape in the place of whatever was at `path`.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn create(path: &Path, values: bool) -> Result<Self, FileError> {
        Ok(Self {
            writer: CaptureWriter::create(path, values)?,
            next_scan: 0,
            taped: Taped::default(),
        })
    }

    /// Appends a block.
    ///
    /// # Errors
    /// [`RecordError::Restarted`] when the scans begin anew, and [`RecordError::File`].
    pub fn push(&mut self, block: &Block) -> Result<(), RecordError> {
        let scan = block.header.first_scan;
        if scan < self.next_scan {
            return Err(RecordError::Restarted {
                scan,
                expected: self.next_scan,
            });
        }
        let scans = u64::from(block.header.scans);
        if self.taped.scans > 0 {
            self.miss(self.next_scan..scan);
        }
        self.next_scan = scan + scans;
        if !self.writer.takes(block) {
            // Its rows are not in the capture, whatever the reason.
            if self.taped.scans > 0 {
                self.miss(scan..self.next_scan);
            }
            return Ok(());
        }
        self.writer.push(block)?;
        self.taped.scans += scans;
        Ok(())
    }

    /// Notes that these scans are not in the capture.
    fn miss(&mut self, missing: Range<u64>) {
        let scans = missing.end - missing.start;
        self.taped.lost += scans;
        match self.taped.gaps.last_mut() {
            Some(gap) if gap.first_scan + gap.scans == missing.start => gap.scans += scans,
            _ if scans > 0 => self.taped.gaps.push(Missing {
                first_scan: missing.start,
                scans,
            }),
            _ => {}
        }
    }

    /// What is in the capture so far.
    pub fn taped(&self) -> &Taped {
        &self.taped
    }

    /// Counter of the scan that is due next.
    pub fn next_scan(&self) -> u64 {
        self.next_scan
    }

    /// Completes the capture; what is in it.
    ///
    /// # Errors
    /// [`FileError::BrokenOff`].
    pub fn finish(self) -> Result<Taped, FileError> {
        self.writer.finish()?;
        Ok(self.taped)
    }
}
