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

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use hexsense::channel::{CHANNELS, INERTIAL, NAMES, Scan, Triad};
use hexsense::sampling::Values;
use hexsense::wire::telemetry::Block;

use crate::files::{self, FileError};

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

/// A stretch of scans that did not arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gap {
    /// Index in the capture of the first scan after the gap.
    pub before: usize,
    /// Scans that are missing.
    pub missing: u64,
}

impl Capture {
    /// Stretches that did not arrive.
    #[must_use]
    pub fn gaps(&self) -> Vec<Gap> {
        let steps = self.scans.windows(2).enumerate();
        steps
            .filter(|(_, pair)| pair[1] - pair[0] > 1)
            .map(|(index, pair)| Gap {
                before: index + 1,
                missing: pair[1] - pair[0] - 1,
            })
            .collect()
    }

    /// Indices of `scans` scans from counter `first_scan` on; `None` when one of them is missing, or none is asked for.
    #[must_use]
    pub fn window(&self, first_scan: u64, scans: usize) -> Option<Range<usize>> {
        let first = self.scans.binary_search(&first_scan).ok()?;
        let last = first + scans.checked_sub(1)?;
        (*self.scans.get(last)? == first_scan + scans as u64 - 1).then_some(first..last + 1)
    }

    /// Reads a capture file.
    ///
    /// # Errors
    /// [`FileError`] with the line and column of the first thing that is wrong.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        Self::parse(&path.display().to_string(), &files::read(path)?)
    }

    /// Reads `text`, which came from `file`.
    ///
    /// # Errors
    /// [`FileError::Line`].
    pub fn parse(file: &str, text: &str) -> Result<Self, FileError> {
        let line_error = |line: usize, problem: String| FileError::Line {
            file: file.to_owned(),
            line,
            problem,
        };
        let mut lines = text.split_inclusive('\n').zip(1..);
        let head = lines.next().map_or("", |(line, _)| line.trim_end());
        let has_values = head == header(true);
        if !has_values && head != header(false) {
            let problem = format!(
                "the header must be {}, with or without values",
                header(true)
            );
            return Err(line_error(1, problem));
        }
        let mut capture = Self {
            values: has_values.then(Vec::new),
            ..Self::default()
        };
        for (line, number) in lines {
            let row = line
                .strip_suffix('\n')
                .ok_or_else(|| line_error(number, "the file is cut off here".to_owned()))?;
            capture
                .push_row(row)
                .map_err(|problem| line_error(number, problem))?;
        }
        Ok(capture)
    }

    fn push_row(&mut self, row: &str) -> Result<(), String> {
        let mut fields = Fields {
            cells: row.split(','),
            column: 0,
        };
        let scan = fields.next()?;
        if let Some(last) = self.scans.last().filter(|last| **last >= scan) {
            return Err(format!("scan {scan} does not follow scan {last}"));
        }
        let mut counts = [0; CHANNELS];
        for count in &mut counts {
            *count = fields.next()?;
        }
        let supply = fields.next_finite()?;
        let temperature_c = fields.next_finite()?;
        let mut values = [0.0; INERTIAL];
        if self.values.is_some() {
            for value in &mut values {
                *value = fields.next_finite()?;
            }
        }
        fields.end()?;
        self.scans.push(scan);
        self.counts.push(counts);
        self.supply.push(supply);
        self.temperature_c.push(temperature_c);
        if let Some(all) = &mut self.values {
            all.push(values);
        }
        Ok(())
    }
}

/// The cells of one row, taken from left to right.
struct Fields<'a> {
    cells: std::str::Split<'a, char>,
    column: usize,
}

impl Fields<'_> {
    fn next<T: FromStr>(&mut self) -> Result<T, String> {
        self.column += 1;
        let cell = self
            .cells
            .next()
            .ok_or_else(|| format!("column {} is missing", self.column))?;
        cell.parse()
            .map_err(|_| format!("column {}: {cell:?} is not a usable number", self.column))
    }

    fn next_finite(&mut self) -> Result<f32, String> {
        let value: f32 = self.next()?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(format!(
                "column {}: {value} is not a finite number",
                self.column
            ))
        }
    }

    fn end(&mut self) -> Result<(), String> {
        match self.cells.next() {
            None => Ok(()),
            Some(_) => Err(format!("there are more than {} columns", self.column)),
        }
    }
}

/// The first line of a capture file, without its end.
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

/// Writes a capture block by block. The file takes its name when the run is complete; until then it ends in `.part`.
#[derive(Debug)]
pub struct CaptureWriter {
    path: PathBuf,
    file: BufWriter<File>,
    values: bool,
    rows: String,
}

impl CaptureWriter {
    /// Starts the capture file `path`, with or without calibrated values.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn create(path: &Path, values: bool) -> Result<Self, FileError> {
        let file =
            File::create(files::part_of(path)).map_err(|reason| write_error(path, reason))?;
        Ok(Self {
            path: path.to_owned(),
            file: BufWriter::new(file),
            values,
            rows: header(values) + "\n",
        })
    }

    /// Appends the scans of a block. A block without counts, or without values that were promised, adds nothing.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn push(&mut self, block: &Block) -> Result<(), FileError> {
        let common = format!(",{},{}", block.header.supply, block.header.temperature_c);
        let values = block.values.as_ref();
        if self.values && values.is_none() {
            return Ok(());
        }
        for (index, counts) in block.counts.iter().flatten().enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(self.rows, "{}", block.header.first_scan + index as u64);
            for count in counts {
                let _ = write!(self.rows, ",{count}");
            }
            self.rows.push_str(&common);
            for value in values
                .filter(|_| self.values)
                .map_or(&[][..], |values| &values[index])
            {
                let _ = write!(self.rows, ",{value}");
            }
            self.rows.push('\n');
        }
        let written = self.file.write_all(self.rows.as_bytes());
        self.rows.clear();
        written.map_err(|reason| write_error(&self.path, reason))
    }

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn finish(mut self) -> Result<(), FileError> {
        self.file
            .write_all(self.rows.as_bytes())
            .and_then(|()| self.file.flush())
            .and_then(|()| self.file.get_ref().sync_all())
            .and_then(|()| fs::rename(files::part_of(&self.path), &self.path))
            .map_err(|reason| write_error(&self.path, reason))
    }
}

fn write_error(path: &Path, reason: std::io::Error) -> FileError {
    FileError::Write {
        file: path.display().to_string(),
        reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hexsense::sampling::BLOCK;
    use hexsense::wire::StreamContent;
    use hexsense::wire::telemetry::Header;

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
                before: BLOCK,
                missing: 16
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
    fn a_damaged_row_is_refused_with_its_line() {
        let (_folder, path) = written(&[block(160)]);
        let text = files::read(&path).unwrap();
        let problem = |text: &str| Capture::parse("run.csv", text).unwrap_err().to_string();
        assert!(
            problem(&text.replace("\n162,", "\n162,x")).starts_with("run.csv, line 4: column 2")
        );
        assert!(problem(&text.replace("\n162,", "\n161,")).contains("does not follow scan 161"));
        assert!(problem(&text.replace(",31.62,", ",NaN,")).contains("column 18: NaN"));
        assert!(problem(&text[..text.len() - 3]).contains("line 17: the file is cut off"));
        assert!(problem("time,ax\n").starts_with("run.csv, line 1: the header must be"));
    }
}
