//! Tables of numbers as CSV: six columns are read, by the names in the header or, without a header, by their order.
//!
//! A first row in which no cell is a number is a header. Empty lines are passed over, but counted.

use std::fmt::{Display, Write};
use std::io::{self, Read};
use std::path::Path;

use crate::files::{self, FileError};

/// A table with six columns that are wanted.
pub struct Table {
    file: String,
    text: String,
    /// Where in a row the six columns are.
    places: [usize; 6],
    /// Cells of a row.
    width: usize,
    has_header: bool,
}

/// A line of a table that is not empty.
pub struct Row<'a> {
    /// Number of the line, from 1.
    line: usize,
    text: &'a str,
}

impl Table {
    /// Reads the file at `path`, or standard input when that is `-`, for the columns `names`.
    ///
    /// # Errors
    /// [`FileError::Read`], and [`FileError::Line`] when the header lacks a column or there is not a single line.
    pub fn read(path: &Path, names: &[&str; 6]) -> Result<Self, FileError> {
        if path != Path::new("-") {
            return Self::parse(path.display().to_string(), files::read(path)?, names);
        }
        let file = "standard input".to_owned();
        let mut text = String::new();
        match io::stdin().lock().read_to_string(&mut text) {
            Ok(_) => Self::parse(file, text, names),
            Err(reason) => Err(FileError::Read { file, reason }),
        }
    }

    fn parse(file: String, text: String, names: &[&str; 6]) -> Result<Self, FileError> {
        let mut table = Self {
            file,
            text,
            places: [0, 1, 2, 3, 4, 5],
            width: 6,
            has_header: false,
        };
        let Some(first) = lines(&table.text).next() else {
            let problem = format!("there is no row; give six columns {}", names.join(","));
            return Err(table.error(&Row { line: 1, text: "" }, problem));
        };
        let cells: Vec<&str> = cells(first.text).collect();
        if cells.iter().any(|cell| cell.parse::<f64>().is_ok()) {
            return Ok(table);
        }
        let mut places = table.places;
        for (place, name) in places.iter_mut().zip(names) {
            *place = cells.iter().position(|cell| cell == name).ok_or_else(|| {
                let all = names.join(",");
                table.error(
                    &first,
                    format!("the header has no {name}; it must have {all}"),
                )
            })?;
        }
        table.width = cells.len();
        table.places = places;
        table.has_header = true;
        Ok(table)
    }

    /// The rows under the header.
    pub fn rows(&self) -> Vec<Row<'_>> {
        lines(&self.text)
            .skip(usize::from(self.has_header))
            .collect()
    }

    /// The six numbers of a row, all finite.
    ///
    /// # Errors
    /// [`FileError::Line`].
    pub fn numbers(&self, row: &Row<'_>) -> Result<[f64; 6], FileError> {
        let width = cells(row.text).count();
        if width != self.width {
            let problem = format!("{width} cells; there must be {}", self.width);
            return Err(self.error(row, problem));
        }
        let mut numbers = [0.0; 6];
        for (place, cell) in cells(row.text).enumerate() {
            if let Some(column) = self.places.iter().position(|wanted| *wanted == place) {
                numbers[column] = number(cell).map_err(|problem| self.error(row, problem))?;
            }
        }
        Ok(numbers)
    }

    /// The error that a row has a problem.
    pub fn error(&self, row: &Row<'_>, problem: impl Display) -> FileError {
        FileError::Line {
            file: self.file.clone(),
            line: row.line,
            problem: problem.to_string(),
        }
    }
}

fn lines(text: &str) -> impl Iterator<Item = Row<'_>> {
    // Spreadsheets begin a file with a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let rows = (1..)
        .zip(text.lines())
        .map(|(line, text)| Row { line, text });
    rows.filter(|row| !row.text.trim().is_empty())
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

/// Six finite numbers with commas between them, as on a command line.
///
/// # Errors
/// What is wrong, in words.
pub fn six(text: &str) -> Result<[f64; 6], String> {
    let numbers = cells(text).map(number).collect::<Result<Vec<_>, _>>()?;
    let count = numbers.len();
    numbers
        .try_into()
        .map_err(|_| format!("{count} numbers; there must be 6"))
}

/// Appends numbers to a line, with commas between them and digits enough to read the same numbers back.
pub fn write(line: &mut String, numbers: &[f64]) {
    for (index, number) in numbers.iter().enumerate() {
        let comma = if index == 0 { "" } else { "," };
        // A sum with zero has no negative zero; text takes whatever is written to it.
        let _ = write!(line, "{comma}{:?}", number + 0.0);
    }
}
