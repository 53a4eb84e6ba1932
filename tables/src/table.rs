//! The lines of a whole text.

use std::str::SplitInclusive;

use crate::{Format, Problem};

/// What spreadsheets put at the beginning of a file.
pub const BYTE_ORDER_MARK: char = '\u{feff}';

/// A table in memory: its header, then its rows one after another.
#[derive(Debug, Clone)]
pub struct Table<'a> {
    /// The first line that is not empty.
    pub header: Line<'a>,
    lines: Lines<'a>,
    format: Format,
}

/// A line that is not empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line<'a> {
    /// Its number, from 1.
    pub number: usize,
    /// Its text, with its end.
    pub text: &'a str,
}

impl Line<'_> {
    /// Whether the line has an end; the last line of a file that was cut off has none.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.text.ends_with('\n')
    }
}

#[derive(Debug, Clone)]
struct Lines<'a> {
    texts: SplitInclusive<'a, char>,
    number: usize,
}

impl<'a> Lines<'a> {
    /// The next line, empty or not.
    #[inline]
    fn next(&mut self) -> Option<Line<'a>> {
        let text = self.texts.next()?;
        self.number += 1;
        let number = self.number;
        Some(Line { number, text })
    }
}

impl<'a> Table<'a> {
    /// Finds the header of `text` and how the table is written. A text without any line has an empty header.
    ///
    /// # Errors
    /// [`Problem::Separators`], with the line.
    pub fn of(text: &'a str) -> Result<Self, (usize, Problem)> {
        let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        let mut lines = Lines {
            texts: text.split_inclusive('\n'),
            number: 0,
        };
        let mut declared = None;
        let mut header = Line {
            number: 1,
            text: "",
        };
        while let Some(line) = lines.next() {
            if line.number == 1 {
                declared = Format::declared(line.text);
            }
            let is_header = !line.text.trim().is_empty() && (line.number > 1 || declared.is_none());
            if is_header {
                header = line;
                break;
            }
        }
        let format = match declared {
            Some(format) => format,
            None => Format::of(header.text).map_err(|problem| (header.number, problem))?,
        };
        Ok(Self {
            header,
            lines,
            format,
        })
    }

    /// How the table is written, by the rows that were read.
    #[must_use]
    #[inline]
    pub fn format(&self) -> Format {
        self.format
    }
}

impl<'a> Iterator for Table<'a> {
    type Item = Line<'a>;

    #[inline]
    fn next(&mut self) -> Option<Line<'a>> {
        loop {
            let line = self.lines.next()?;
            if !self.format.is_empty(line.text) {
                self.format.learn(line.text);
                return Some(line);
            }
        }
    }
}
