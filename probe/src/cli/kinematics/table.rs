//! Tables of numbers: six columns are read, by the names in the header or, without a header, by their order.
//! [`columns`] says what the names mean.
//!
//! A first row in which no cell is a number is a header. How lines are written, and what is passed over, is for the crate
//! [`tables`] to say. Lines are read as they are needed, so a table of any length takes little memory.

use std::array;
use std::fmt::{Display, Write};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use tables::{BYTE_ORDER_MARK, Format, Problem};

use crate::columns::{self, Column, Found};
use crate::files::FileError;

/// Longest line of a table, bytes; six numbers and what stands beside them are far shorter.
const MAX_LINE: u64 = 65_536;

/// The places of the six wanted columns in a row.
pub struct Columns {
    file: String,
    found: [Found; 6],
    /// Cells of a row.
    width: usize,
}

/// The lines of a table, one after another.
pub struct Lines {
    reader: Box<dyn BufRead>,
    /// Number of the last line that was read.
    line: usize,
    /// Whether there is more to read.
    open: bool,
    /// How the table is written; known from the first line on.
    format: Option<Format>,
    /// The first row of a table without a header.
    first: Option<Row>,
    /// Size of the file, bytes; unknown of standard input.
    size: Option<u64>,
}

/// A line of a table that is not empty.
pub struct Row {
    /// Number of the line, from 1.
    line: usize,
    /// How it is written, by the lines up to it.
    format: Format,
    /// The line, or why it cannot be read.
    text: Result<String, String>,
}

/// Opens the table at `path`, or standard input when that is `-`, and finds the columns `wanted`.
///
/// # Errors
/// [`FileError::Read`], and [`FileError::Line`] when the header lacks a column or there is not a single line.
pub fn open(path: &Path, wanted: &[Column; 6]) -> Result<(Columns, Lines), FileError> {
    if path == Path::new("-") {
        let reader = Box::new(BufReader::new(io::stdin()));
        return parse("standard input".to_owned(), reader, None, wanted);
    }
    let file = path.display().to_string();
    match File::open(path) {
        Ok(opened) => {
            let size = opened.metadata().ok().map(|metadata| metadata.len());
            parse(file, Box::new(BufReader::new(opened)), size, wanted)
        }
        Err(reason) => Err(FileError::Read { file, reason }),
    }
}

/// Finds the columns `wanted` in what `reader` reads from `file`.
///
/// # Errors
/// As [`open`].
pub fn parse(
    file: String,
    reader: Box<dyn BufRead>,
    size: Option<u64>,
    wanted: &[Column; 6],
) -> Result<(Columns, Lines), FileError> {
    let mut columns = Columns {
        file,
        found: array::from_fn(|place| wanted[place].at(place)),
        width: 6,
    };
    let mut lines = Lines {
        reader,
        line: 0,
        open: true,
        format: None,
        first: None,
        size,
    };
    let Some(first) = lines.next() else {
        let names = wanted.map(|column| column.name).join(",");
        let problem = format!("there is no row; give six columns {names}");
        return Err(columns.line_error(1, problem));
    };
    let (format, text) = (first.format, columns.text(&first)?);
    if format.cells(text).any(|cell| format.finite(cell).is_ok()) {
        lines.first = Some(first);
        return Ok((columns, lines));
    }
    let header = tables::names(format, text);
    columns.found = columns::find(&header, wanted).map_err(|problem| {
        let separator = format.separator();
        let problem = format!("{problem}. Its cells were taken apart at {separator}s");
        columns.error(&first, problem)
    })?;
    columns.width = header.len();
    Ok((columns, lines))
}

impl Lines {
    /// Size of the file, bytes; `None` for standard input.
    pub fn size(&self) -> Option<u64> {
        self.size
    }
}

impl Iterator for Lines {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        if let Some(first) = self.first.take() {
            return Some(first);
        }
        while self.open {
            let text = self.read();
            if text.as_ref().is_ok_and(|text| self.passes_over(text)) {
                continue;
            }
            let text = text.and_then(|text| self.note_format(text));
            self.open &= text.is_ok();
            let (line, format) = (self.line, self.format.unwrap_or(Format::COMMAS));
            return Some(Row { line, format, text });
        }
        None
    }
}

impl Lines {
    /// Whether a line is empty, or declares the separator.
    fn passes_over(&mut self, text: &str) -> bool {
        if self.line == 1
            && let Some(format) = Format::declared(text)
        {
            self.format = Some(format);
            return true;
        }
        match self.format {
            Some(format) => format.is_empty(text),
            None => text.trim().is_empty(),
        }
    }

    /// The line, by which more may be known of the format.
    fn note_format(&mut self, text: String) -> Result<String, String> {
        let known = self.format.map_or_else(|| Format::of(&text), Ok);
        let mut format = known.map_err(|problem| problem.to_string())?;
        format.learn(&text);
        self.format = Some(format);
        Ok(text)
    }
}

impl Lines {
    /// The next line; empty at the end, which it notes.
    fn read(&mut self) -> Result<String, String> {
        let mut bytes = Vec::new();
        self.line += 1;
        match (&mut self.reader)
            .take(MAX_LINE)
            .read_until(b'\n', &mut bytes)
        {
            Ok(0) => self.open = false,
            Ok(count) if count as u64 == MAX_LINE => {
                return Err(format!("longer than {MAX_LINE} bytes; this is no table"));
            }
            Ok(_) => {}
            Err(reason) => return Err(format!("cannot be read: {reason}")),
        }
        let text = String::from_utf8(bytes)
            .map_err(|_| "not UTF-8 text; save the table as \"CSV UTF-8\"".to_owned())?;
        match text.strip_prefix(BYTE_ORDER_MARK) {
            Some(rest) if self.line == 1 => Ok(rest.to_owned()),
            _ => Ok(text),
        }
    }
}

impl Row {
    /// Size of the row in its table, bytes.
    pub fn size(&self) -> u64 {
        self.text.as_ref().map_or(0, |text| text.len() as u64)
    }
}

impl Columns {
    /// The six numbers of a row, in metres and radians.
    ///
    /// # Errors
    /// [`FileError::Line`].
    pub fn numbers(&self, row: &Row) -> Result<[f64; 6], FileError> {
        let (format, text) = (row.format, self.text(row)?);
        let mut numbers = [0.0; 6];
        let mut cells = 0;
        for (place, cell) in format.cells(text).enumerate() {
            if place < self.width || !cell.text.is_empty() {
                cells = place + 1;
            }
            if let Some(column) = self.found.iter().position(|found| found.place == place) {
                let number = format.finite(cell).map_err(|problem| problem.to_string());
                let number = number.and_then(|number| self.found[column].si(number));
                numbers[column] = number.map_err(|problem| self.error(row, problem))?;
            }
        }
        if cells == self.width {
            return Ok(numbers);
        }
        let (width, separator) = (self.width, format.separator());
        let problem = Problem::Width {
            cells,
            width,
            separator,
        };
        Err(self.error(row, problem))
    }

    /// The error that a row has a problem.
    pub fn error(&self, row: &Row, problem: impl Display) -> FileError {
        self.line_error(row.line, problem)
    }

    fn line_error(&self, line: usize, problem: impl Display) -> FileError {
        FileError::Line {
            file: self.file.clone(),
            line,
            problem: problem.to_string(),
        }
    }

    fn text<'a>(&self, row: &'a Row) -> Result<&'a str, FileError> {
        match &row.text {
            Ok(text) => Ok(text),
            Err(problem) => Err(self.error(row, problem)),
        }
    }
}

/// The six numbers of the columns `wanted`, m and rad, with commas between them, as on a command line.
///
/// # Errors
/// What is wrong, in words.
pub fn six(text: &str, wanted: &[Column; 6]) -> Result<[f64; 6], String> {
    let format = Format::COMMAS;
    let numbers = format.cells(text).map(|cell| format.finite(cell));
    let numbers: Vec<f64> = numbers
        .collect::<Result<_, _>>()
        .map_err(|problem| problem.to_string())?;
    let mut six: [f64; 6] = numbers
        .try_into()
        .map_err(|numbers: Vec<f64>| format!("{} numbers; there must be 6", numbers.len()))?;
    for (place, number) in six.iter_mut().enumerate() {
        *number = wanted[place].at(place).si(*number)?;
    }
    Ok(six)
}

/// Appends numbers to a line, with commas between them and digits enough to read the same numbers back.
pub fn write(line: &mut String, numbers: &[f64]) {
    for (index, number) in numbers.iter().enumerate() {
        let comma = if index == 0 { "" } else { "," };
        // A sum with zero has no negative zero; text takes whatever is written to it.
        let _ = write!(line, "{comma}{:?}", number + 0.0);
    }
}
