//! From the file to a capture in memory.

use std::borrow::Cow;
use std::fmt;
use std::path::Path;
use std::str::FromStr;

use hexsense_client::bounds::MAX_COUNT;
use hexsense_core::channel::{CHANNELS, INERTIAL};
use tables::{Cells, Format, Problem, Table};

use super::{Capture, header};
use crate::files::{self, CAPTURE, FileError};

/// The last row of a capture that broke off, when it is not whole; the reader passes over it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Torn {
    /// Its line, from 1.
    pub line: usize,
    /// Bytes of it that are there.
    pub bytes: usize,
}

impl fmt::Display for Torn {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "line {} is torn after {} bytes and passed over",
            self.line, self.bytes
        )
    }
}

impl Capture {
    /// Reads the file of a complete capture.
    ///
    /// # Errors
    /// [`FileError`] with the line and column of the first thing that is wrong.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        Self::parse(&path.display().to_string(), &files::read(path, CAPTURE)?)
    }

    /// Reads `text`, which came from `file` and is complete.
    ///
    /// # Errors
    /// [`FileError::Line`].
    pub fn parse(file: &str, text: &str) -> Result<Self, FileError> {
        let (capture, torn) = Self::rows(file, text)?;
        match torn {
            None => Ok(capture),
            Some(torn) => Err(line_error(file, torn.line, "the file is cut off here")),
        }
    }

    /// The text of a capture as it was recorded: `text` itself, unless it shows that `file` was written anew since.
    ///
    /// # Errors
    /// [`FileError::Line`].
    pub fn as_recorded<'a>(file: &str, text: &'a str) -> Result<Cow<'a, str>, FileError> {
        let never_written = |byte| matches!(byte, b'\r' | b'\t' | b' ' | b'"' | b';');
        let head = text.lines().next().unwrap_or_default();
        let is_own = (head == header(false) || head == header(true))
            && !text.bytes().any(never_written)
            && !text.contains("\n\n");
        if is_own {
            return Ok(Cow::Borrowed(text));
        }
        Ok(Cow::Owned(Self::parse(file, text)?.to_text()))
    }

    /// Reads the file of a capture that broke off: every whole row, and the torn one that was passed over.
    ///
    /// # Errors
    /// [`FileError`]; a row that is wrong before the last one is damage, not the end of a recording.
    pub fn salvage(path: &Path) -> Result<(Self, Option<Torn>), FileError> {
        Self::rows(&path.display().to_string(), &files::read(path, CAPTURE)?)
    }

    /// All whole rows, and the torn one.
    fn rows(file: &str, text: &str) -> Result<(Self, Option<Torn>), FileError> {
        let at = |line| move |problem: Problem| line_error(file, line, problem.to_string());
        let mut table = Table::of(text).map_err(|(line, problem)| at(line)(problem))?;
        let head = table.header;
        let columns = tables::names(table.format(), head.text).len();
        let has_values = columns > header(false).split(',').count();
        tables::expect(table.format(), head.text, &header(has_values)).map_err(at(head.number))?;
        let mut capture = Self {
            values: has_values.then(Vec::new),
            ..Self::default()
        };
        while let Some(row) = table.next() {
            if !row.is_whole() {
                let (line, bytes) = (row.number, row.text.len());
                return Ok((capture, Some(Torn { line, bytes })));
            }
            capture
                .push_row(table.format(), row.text)
                .map_err(|problem| line_error(file, row.number, problem))?;
        }
        Ok((capture, None))
    }

    fn push_row(&mut self, format: Format, row: &str) -> Result<(), String> {
        let mut fields = Fields {
            format,
            cells: format.cells(row),
            column: 0,
        };
        let scan = fields.next()?;
        if scan > MAX_COUNT {
            return Err(format!(
                "column 1: scan {scan} is beyond {MAX_COUNT}, to which no board counts"
            ));
        }
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

fn line_error(file: &str, line: usize, problem: impl Into<String>) -> FileError {
    FileError::Line {
        file: file.to_owned(),
        line,
        problem: problem.into(),
    }
}

/// The cells of one row, taken from left to right.
struct Fields<'a> {
    format: Format,
    cells: Cells<'a>,
    column: usize,
}

impl Fields<'_> {
    fn next<T: FromStr>(&mut self) -> Result<T, String> {
        self.column += 1;
        let cell = self
            .cells
            .next()
            .ok_or_else(|| format!("column {} is missing", self.column))?;
        self.format
            .number(cell)
            .map_err(|problem| format!("column {}: {problem}", self.column))
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
        if self.cells.all(|cell| cell.text.is_empty()) {
            Ok(())
        } else {
            Err(format!("there are more than {} columns", self.column))
        }
    }
}

#[cfg(test)]
mod tests;
