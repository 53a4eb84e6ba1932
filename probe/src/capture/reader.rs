//! From the file to a capture in memory.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use hexsense_core::channel::{CHANNELS, INERTIAL};

use super::{Capture, header};
use crate::files::{self, FileError};

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
        Self::parse(&path.display().to_string(), &files::read(path)?)
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

    /// Reads the file of a capture that broke off: every whole row, and the torn one that was passed over.
    ///
    /// # Errors
    /// [`FileError`]; a row that is wrong before the last one is damage, not the end of a recording.
    pub fn salvage(path: &Path) -> Result<(Self, Option<Torn>), FileError> {
        Self::rows(&path.display().to_string(), &files::read(path)?)
    }

    /// All whole rows, and the torn one.
    fn rows(file: &str, text: &str) -> Result<(Self, Option<Torn>), FileError> {
        let mut lines = text.split_inclusive('\n').zip(1..);
        let head = lines.next().map_or("", |(line, _)| line.trim_end());
        let has_values = head == header(true);
        if !has_values && head != header(false) {
            let problem = format!(
                "the header must be {}, with or without values",
                header(true)
            );
            return Err(line_error(file, 1, problem));
        }
        let mut capture = Self {
            values: has_values.then(Vec::new),
            ..Self::default()
        };
        for (text, line) in lines {
            let Some(row) = text.strip_suffix('\n') else {
                let bytes = text.len();
                return Ok((capture, Some(Torn { line, bytes })));
            };
            capture
                .push_row(row)
                .map_err(|problem| line_error(file, line, problem))?;
        }
        Ok((capture, None))
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

fn line_error(file: &str, line: usize, problem: impl Into<String>) -> FileError {
    FileError::Line {
        file: file.to_owned(),
        line,
        problem: problem.into(),
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

#[cfg(test)]
mod tests;
