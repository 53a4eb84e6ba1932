//! The capture of a run as it grows, and the count of what is missing from it.

use std::path::Path;

use hexsense::wire::telemetry::Block;

use super::RecordError;
use crate::capture::CaptureWriter;
use crate::files::FileError;

/// What has been written so far.
pub struct Tape {
    writer: CaptureWriter,
    first_scan: Option<u64>,
    next_scan: u64,
    scans: u64,
}

impl Tape {
    /// An empty tape in the place of whatever was at `path`.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn create(path: &Path, values: bool) -> Result<Self, FileError> {
        Ok(Self {
            writer: CaptureWriter::create(path, values)?,
            first_scan: None,
            next_scan: 0,
            scans: 0,
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
        self.first_scan.get_or_insert(scan);
        let scans = u64::from(block.header.scans);
        self.next_scan = scan + scans;
        self.scans += scans;
        Ok(self.writer.push(block)?)
    }

    /// Counter of the scan that is due next.
    pub fn next_scan(&self) -> u64 {
        self.next_scan
    }

    /// Completes the capture; the scans that are in it, and those that are missing.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn finish(self) -> Result<(u64, u64), FileError> {
        self.writer.finish()?;
        let first_scan = self.first_scan.unwrap_or(self.next_scan);
        Ok((self.scans, self.next_scan - first_scan - self.scans))
    }
}
