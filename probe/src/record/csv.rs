//! The sink that writes a [capture](crate::capture) file.

use std::path::PathBuf;

use hexsense_core::wire::telemetry::Block;

use super::sink::{Notes, Recorded, Sink};
use crate::capture::{CaptureWriter, Gap};
use crate::files::FileError;

/// Writes the file `NAME.csv`, which is `NAME.csv.part` until the recording ends.
pub struct CsvSink {
    path: PathBuf,
    writer: Option<CaptureWriter>,
}

impl CsvSink {
    /// A sink for the file `path`.
    #[must_use]
    pub fn new(path: PathBuf) -> Self {
        Self { path, writer: None }
    }
}

impl Sink for CsvSink {
    fn begin(&mut self, notes: &Notes) -> Result<(), FileError> {
        self.writer = Some(CaptureWriter::create(&self.path, notes.content.values)?);
        Ok(())
    }

    fn block(&mut self, block: &Block) -> Result<(), FileError> {
        self.writer
            .as_mut()
            .map_or(Ok(()), |writer| writer.push(block))
    }

    /// Missing scans are missing rows.
    fn gap(&mut self, _gap: Gap) -> Result<(), FileError> {
        Ok(())
    }

    fn end(&mut self, _recorded: &Recorded) -> Result<(), FileError> {
        self.writer.take().map_or(Ok(()), CaptureWriter::finish)
    }
}
