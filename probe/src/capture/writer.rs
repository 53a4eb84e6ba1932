//! From blocks to the file, row by row.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use hexsense_core::channel::Scan;
use hexsense_core::sampling::Values;
use hexsense_core::wire::telemetry::Block;

use super::{Capture, header};
use crate::files::{self, FileError};

/// How often the system is made to put a capture on the disk: twice in the second that may be lost at most.
const SYNC_EVERY: Duration = Duration::from_millis(500);

/// Writes a capture block by block. The file takes its name when the run is complete; until then it ends in `.part`.
#[derive(Debug)]
pub struct CaptureWriter {
    path: PathBuf,
    file: File,
    values: bool,
    text: String,
    rows: u64,
    /// Bytes of whole rows in the file.
    length: u64,
    syncer: Syncer,
}

impl CaptureWriter {
    /// Starts the capture file `path`, with or without calibrated values. It replaces the `.part` file of an earlier one.
    ///
    /// # Errors
    /// [`FileError::Write`] and [`FileError::BrokenOff`].
    pub fn create(path: &Path, values: bool) -> Result<Self, FileError> {
        let part = files::part_of(path);
        let write_error = |reason| FileError::Write {
            file: part.display().to_string(),
            reason,
        };
        let file = files::create(&part).map_err(write_error)?;
        files::sync_folder_of(&part);
        let mut writer = Self {
            path: path.to_owned(),
            syncer: Syncer::start(&file).map_err(write_error)?,
            file,
            values,
            text: header(values) + "\n",
            rows: 0,
            length: 0,
        };
        writer.append(0)?;
        Ok(writer)
    }

    /// Appends the scans of a block; without counts, or without the values that the file has columns for, it has no rows.
    ///
    /// # Errors
    /// [`FileError::BrokenOff`].
    pub fn push(&mut self, block: &Block) -> Result<(), FileError> {
        if block.counts.is_none() || (self.values && block.values.is_none()) {
            return Ok(());
        }
        let (supply, temperature_c) = (block.header.supply, block.header.temperature_c);
        let values = block.values.as_deref().filter(|_| self.values);
        let counts = block.counts.as_deref().unwrap_or_default();
        for (index, counts) in counts.iter().enumerate() {
            let scan = block.header.first_scan + index as u64;
            let values = values.map(|values| &values[index]);
            write_row(&mut self.text, scan, counts, supply, temperature_c, values);
        }
        self.append(counts.len() as u64)
    }

    /// Hands the rows in `text` to the system.
    fn append(&mut self, rows: u64) -> Result<(), FileError> {
        let synced = self.syncer.failure();
        let written = synced.and_then(|()| self.file.write_all(self.text.as_bytes()));
        written.map_err(|reason| self.broken_off(reason))?;
        self.length += self.text.len() as u64;
        self.rows += rows;
        self.text.clear();
        Ok(())
    }

    fn broken_off(&mut self, reason: io::Error) -> FileError {
        // Half a row is of no use. Where it cannot be cut off, the reader passes over it.
        let _ = self.file.set_len(self.length);
        FileError::BrokenOff {
            file: files::part_of(&self.path).display().to_string(),
            reason,
            rows: self.rows,
        }
    }

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// [`FileError::BrokenOff`].
    pub fn finish(mut self) -> Result<(), FileError> {
        let synced = self.syncer.end().and_then(|()| self.file.sync_all());
        synced
            .and_then(|()| fs::rename(files::part_of(&self.path), &self.path))
            .map_err(|reason| self.broken_off(reason))?;
        files::sync_folder_of(&self.path);
        Ok(())
    }
}

/// Appends a row. Writing to a string cannot fail.
fn write_row(
    text: &mut String,
    scan: u64,
    counts: &Scan,
    supply: f32,
    temperature_c: f32,
    values: Option<&Values>,
) {
    let _ = write!(text, "{scan}");
    for count in counts {
        let _ = write!(text, ",{count}");
    }
    let _ = write!(text, ",{supply},{temperature_c}");
    for value in values.into_iter().flatten() {
        let _ = write!(text, ",{value}");
    }
    text.push('\n');
}

impl Capture {
    /// The capture as the text of a file, the very text that was written when it was recorded.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = header(self.values.is_some()) + "\n";
        for (row, counts) in self.counts.iter().enumerate() {
            let values = self.values.as_ref().map(|values| &values[row]);
            let (supply, temperature_c) = (self.supply[row], self.temperature_c[row]);
            write_row(
                &mut text,
                self.scans[row],
                counts,
                supply,
                temperature_c,
                values,
            );
        }
        text
    }
}

impl Drop for CaptureWriter {
    /// A recording that broke off is put on the disk too. A failure here adds nothing to the error at hand.
    fn drop(&mut self) {
        let _ = self.file.sync_data();
    }
}

/// Puts a file on the disk again and again, beside the recording: a slow disk must not hold up the stream.
#[derive(Debug)]
struct Syncer {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

impl Syncer {
    fn start(file: &File) -> io::Result<Self> {
        let file = file.try_clone()?;
        let (stop, stopped) = mpsc::channel();
        let thread = thread::Builder::new().spawn(move || {
            while stopped.recv_timeout(SYNC_EVERY) == Err(RecvTimeoutError::Timeout) {
                file.sync_data()?;
            }
            Ok(())
        })?;
        Ok(Self {
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// The failure that ended it early.
    fn failure(&mut self) -> io::Result<()> {
        match &self.thread {
            Some(thread) if thread.is_finished() => self.end(),
            _ => Ok(()),
        }
    }

    fn end(&mut self) -> io::Result<()> {
        self.stop = None;
        match self.thread.take().map(JoinHandle::join) {
            None => Ok(()),
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(io::Error::other("the thread that syncs it has ended")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Gap;
    use super::*;
    use crate::files::CAPTURE;
    use hexsense_core::channel::INERTIAL;
    use hexsense_core::sampling::BLOCK;
    use hexsense_core::wire::StreamContent;
    use hexsense_core::wire::telemetry::Header;

    fn block(first_scan: u64) -> Block {
        let header = Header {
            first_scan,
            scans: BLOCK as u8,
            rate_hz: 1000,
            supply: 1.000_123_4,
            temperature_c: 31.62,
            set: None,
            dropped: 0,
            content: StreamContent {
                counts: true,
                values: true,
                pose: false,
            },
        };
        let counts = (0..BLOCK)
            .map(|row| std::array::from_fn(|column| (1000 * column + row) as u16))
            .collect();
        let values = (0..BLOCK)
            .map(|row| [row as f32 / 3.0 - 1e-12; INERTIAL])
            .collect();
        Block {
            header,
            counts: Some(counts),
            values: Some(values),
        }
    }

    fn written(blocks: &[Block]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        let mut writer = CaptureWriter::create(&path, true).unwrap();
        blocks.iter().for_each(|block| writer.push(block).unwrap());
        assert!(
            !path.exists(),
            "a run that is not complete has no file of its name"
        );
        writer.finish().unwrap();
        (folder, path)
    }

    #[test]
    fn what_is_written_reads_back_bit_for_bit_with_its_gap() {
        let blocks = [block(160), block(192)];
        let (_folder, path) = written(&blocks);
        let capture = Capture::load(&path).unwrap();
        assert_eq!(capture.scans.len(), 2 * BLOCK);
        assert_eq!(
            capture.gaps(),
            [Gap {
                first_scan: 176,
                scans: 16
            }]
        );
        for (index, block) in blocks.iter().enumerate() {
            let rows = index * BLOCK..(index + 1) * BLOCK;
            assert_eq!(
                &capture.counts[rows.clone()],
                block.counts.as_deref().unwrap()
            );
            assert_eq!(
                &capture.values.as_ref().unwrap()[rows.clone()],
                block.values.as_deref().unwrap()
            );
            assert!(
                capture.supply[rows]
                    .iter()
                    .all(|c| *c == block.header.supply)
            );
        }
    }

    #[test]
    fn a_capture_under_way_is_readable_and_its_torn_last_row_is_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        let part = files::part_of(&path);
        let mut writer = CaptureWriter::create(&path, true).unwrap();
        let (empty, torn) = Capture::salvage(&part).unwrap();
        assert!(empty.scans.is_empty() && torn.is_none());
        writer.push(&block(160)).unwrap();
        let (capture, torn) = Capture::salvage(&part).unwrap();
        assert_eq!(capture.scans, (160..176).collect::<Vec<_>>());
        assert_eq!(torn, None);
        let text = files::read(&part, CAPTURE).unwrap();
        fs::write(&part, &text[..text.len() - 3]).unwrap();
        let (capture, torn) = Capture::salvage(&part).unwrap();
        assert_eq!(capture.scans.len(), BLOCK - 1);
        let torn = torn.unwrap();
        let last = text.lines().last().unwrap();
        assert_eq!((torn.line, torn.bytes), (BLOCK + 1, last.len() - 2));
        let middle = text.replace("\n162,", "\n162,x");
        fs::write(&part, middle).unwrap();
        assert!(Capture::salvage(&part).is_err(), "damage is not an end");
    }

    #[test]
    fn a_row_that_cannot_be_written_whole_is_taken_away_and_the_rows_before_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        let part = files::part_of(&path);
        let mut writer = CaptureWriter::create(&path, true).unwrap();
        writer.push(&block(160)).unwrap();
        let whole = files::read(&part, CAPTURE).unwrap();
        // Half of a row has gone through, and then the disk is full.
        fs::write(&part, whole.clone() + "176,1000,").unwrap();
        let full = io::Error::from(io::ErrorKind::StorageFull);
        let error = writer.broken_off(full).to_string();
        assert!(
            error.contains("run.csv.part: cannot be written on"),
            "{error}"
        );
        assert!(error.contains("16 scans before are in it"), "{error}");
        assert_eq!(files::read(&part, CAPTURE).unwrap(), whole);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_in_the_place_of_a_recording_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let [path, other] = ["run.csv", "other"].map(|name| folder.path().join(name));
        fs::write(&other, "mine").unwrap();
        std::os::unix::fs::symlink(&other, files::part_of(&path)).unwrap();
        let mut writer = CaptureWriter::create(&path, true).unwrap();
        writer.push(&block(160)).unwrap();
        writer.finish().unwrap();
        assert_eq!(fs::read_to_string(&other).unwrap(), "mine");
        assert_eq!(Capture::load(&path).unwrap().scans.len(), BLOCK);
    }

    #[test]
    fn a_damaged_row_is_refused_with_its_line() {
        let (_folder, path) = written(&[block(160)]);
        let text = files::read(&path, CAPTURE).unwrap();
        let problem = |text: &str| Capture::parse("run.csv", text).unwrap_err().to_string();
        assert!(
            problem(&text.replace("\n162,", "\n162,x")).starts_with("run.csv, line 4: column 2")
        );
        assert!(problem(&text.replace("\n162,", "\n161,")).contains("does not follow scan 161"));
        assert!(problem(&text.replace(",31.62,", ",NaN,")).contains("column 18: NaN"));
        assert!(problem(&text[..text.len() - 3]).contains("line 17: the file is cut off"));
        let header = problem("time,ax\n");
        assert!(header.starts_with("run.csv, line 1: column 1 of the header is \"time\""));
    }
}
