//! Tables of numbers as CSV: six columns are read, by the names in the header or, without a header, by their order.
//! [`columns`] says what the names mean.
//!
//! A first row in which no cell is a number is a header. Empty lines are passed over, but counted. Lines are read as
//! they are needed, so a table of any length takes little memory.

use std::array;
use std::fmt::{Display, Write};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

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
    /// The first row of a table without a header.
    first: Option<Row>,
    /// Size of the file, bytes; unknown of standard input.
    size: Option<u64>,
}

/// A line of a table that is not empty.
pub struct Row {
    /// Number of the line, from 1.
    line: usize,
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
        first: None,
        size,
    };
    let Some(first) = lines.next() else {
        let nothing = Row {
            line: 1,
            text: Ok(String::new()),
        };
        let names = wanted.map(|column| column.name).join(",");
        let problem = format!("there is no row; give six columns {names}");
        return Err(columns.error(&nothing, problem));
    };
    let text = columns.text(&first)?;
    if cells(text).any(|cell| cell.parse::<f64>().is_ok()) {
        lines.first = Some(first);
        return Ok((columns, lines));
    }
    let header: Vec<&str> = cells(text).collect();
    let found = columns::find(&header, wanted);
    columns.found = found.map_err(|problem| columns.error(&first, problem))?;
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
            if text.as_ref().is_ok_and(|text| text.trim().is_empty()) {
                continue;
            }
            self.open &= text.is_ok();
            let line = self.line;
            return Some(Row { line, text });
        }
        None
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
        let text = String::from_utf8(bytes).map_err(|_| "not UTF-8 text".to_owned())?;
        // Spreadsheets begin a file with a byte order mark.
        match text.strip_prefix('\u{feff}') {
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
        let text = self.text(row)?;
        let width = cells(text).count();
        if width != self.width {
            let problem = format!("{width} cells; there must be {}", self.width);
            return Err(self.error(row, problem));
        }
        let mut numbers = [0.0; 6];
        for (place, cell) in cells(text).enumerate() {
            if let Some(column) = self.found.iter().position(|found| found.place == place) {
                let number = number(cell).and_then(|number| self.found[column].si(number));
                numbers[column] = number.map_err(|problem| self.error(row, problem))?;
            }
        }
        Ok(numbers)
    }

    /// The error that a row has a problem.
    pub fn error(&self, row: &Row, problem: impl Display) -> FileError {
        FileError::Line {
            file: self.file.clone(),
            line: row.line,
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

fn cells(row: &str) -> impl Iterator<Item = &str> {
    row.split(',').map(str::trim)
}

fn number(cell: &str) -> Result<f64, String> {
    match cell.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("{cell:?} is not a finite number")),
    }
}

/// The six numbers of the columns `wanted`, m and rad, with commas between them, as on a command line.
///
/// # Errors
/// What is wrong, in words.
pub fn six(text: &str, wanted: &[Column; 6]) -> Result<[f64; 6], String> {
    let numbers = cells(text).map(number).collect::<Result<Vec<_>, _>>()?;
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
