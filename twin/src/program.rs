//! A jack program: the CSV file that an operator loads into the motion controller.
//!
//! ```text
//! time_s,jack1_m,jack2_m,jack3_m,jack4_m,jack5_m,jack6_m
//! 0.000,0.000000,…
//! ```
//!
//! Rows come at a constant period; displacements are from mid-stroke in metres. Between rows the controller
//! interpolates with cubics. Their slope at a row is that of the chord of its neighbours (Catmull and Rom, 1974), so
//! that neither position nor speed has steps.

use std::path::Path;

use tables::{Format, Problem, Table};
use thiserror::Error;

/// The header of a program file.
pub const HEADER: &str = "time_s,jack1_m,jack2_m,jack3_m,jack4_m,jack5_m,jack6_m";
/// Greatest deviation of a row from its place in time, in periods: rounding, not jitter.
const PERIOD_TOLERANCE: f64 = 0.05;

/// Six commanded displacements against time.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    period_s: f64,
    rows: Vec<[f64; 6]>,
}

/// Why a program file cannot be loaded.
#[derive(Debug, Error)]
pub enum ProgramError {
    /// The file cannot be read.
    #[error("{path}: {source}")]
    Unreadable {
        /// The file.
        path: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file is readable, but it is not a program.
    #[error("{path}: {source}")]
    InFile {
        /// The file.
        path: String,
        /// What is wrong.
        #[source]
        source: Box<ProgramError>,
    },
    /// A line that is no line of a program.
    #[error("line {line}: {problem}")]
    Line {
        /// Line of the file, from 1.
        line: usize,
        /// What is wrong.
        problem: Problem,
    },
    /// A program without a period.
    #[error("{rows} rows, must be at least 2")]
    TooShort {
        /// Number of rows.
        rows: usize,
    },
    /// Times that do not rise evenly.
    #[error(
        "line {line}: time {time_s} s, must be {expected_s:.6} s (constant period of {period_s:.6} s)"
    )]
    Uneven {
        /// Line of the file, from 1.
        line: usize,
        /// The time there, s.
        time_s: f64,
        /// The time that an even program has there, s.
        expected_s: f64,
        /// The mean period, s.
        period_s: f64,
    },
}

impl Program {
    /// Reads a program file.
    ///
    /// # Errors
    /// [`ProgramError`], with the file's name in front.
    pub fn load(path: &Path) -> Result<Self, ProgramError> {
        let shown = || path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|source| ProgramError::Unreadable {
            path: shown(),
            source,
        })?;
        Self::parse(&text).map_err(|source| ProgramError::InFile {
            path: shown(),
            source: Box::new(source),
        })
    }

    /// Reads the text of a program file.
    ///
    /// # Errors
    /// [`ProgramError`] for anything but the right header and even rows of finite numbers.
    pub fn parse(text: &str) -> Result<Self, ProgramError> {
        let at = |line| move |problem| ProgramError::Line { line, problem };
        let mut table = Table::of(text).map_err(|(line, problem)| at(line)(problem))?;
        let header = table.header;
        tables::expect(table.format(), header.text, HEADER).map_err(at(header.number))?;
        let (mut times, mut rows) = (Vec::new(), Vec::new());
        while let Some(line) = table.next() {
            let [time, jacks @ ..] = numbers(table.format(), line.text).map_err(at(line.number))?;
            times.push((line.number, time));
            rows.push(jacks);
        }
        let period_s = even_period(&times)?;
        Ok(Self { period_s, rows })
    }

    /// A program of the given rows (m), `period_s` apart.
    ///
    /// # Errors
    /// [`ProgramError::TooShort`] below two rows; [`ProgramError::Uneven`] if the period is not above zero.
    pub fn new(period_s: f64, rows: Vec<[f64; 6]>) -> Result<Self, ProgramError> {
        let times: Vec<(usize, f64)> = (0..rows.len())
            .map(|row| (row + 2, row as f64 * period_s))
            .collect();
        even_period(&times)?;
        Ok(Self { period_s, rows })
    }

    /// Time from the first to the last row, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.period_s * (self.rows.len() - 1) as f64
    }

    /// Time between rows, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// The rows, m.
    #[must_use]
    pub fn rows(&self) -> &[[f64; 6]] {
        &self.rows
    }

    /// Displacement of one jack (0 to 5), m, at a time since the first row, s; constant before the first row and after
    /// the last.
    #[must_use]
    pub fn at(&self, jack: usize, time_s: f64) -> f64 {
        let last = self.rows.len() - 1;
        let place = (time_s / self.period_s).clamp(0.0, last as f64);
        let row = (place as usize).min(last - 1);
        let s = place - row as f64;
        let value = |index: usize| self.rows[index.min(last)][jack];
        let (before, from, to, after) = (
            value(row.saturating_sub(1)),
            value(row),
            value(row + 1),
            value(row + 2),
        );
        let (slope_from, slope_to) = (0.5 * (to - before), 0.5 * (after - from));
        let rise = to - from;
        from + s
            * (slope_from
                + s * (3.0 * rise - 2.0 * slope_from - slope_to
                    + s * (slope_from + slope_to - 2.0 * rise)))
    }
}

fn numbers(format: Format, line: &str) -> Result<[f64; 7], Problem> {
    let mut values = [0.0; 7];
    let mut count = 0;
    for (column, cell) in format.cells(line).enumerate() {
        if column < values.len() || !cell.text.is_empty() {
            count = column + 1;
        }
        if let Some(value) = values.get_mut(column) {
            *value = format.finite(cell)?;
        }
    }
    if count == values.len() {
        return Ok(values);
    }
    Err(Problem::Width {
        cells: count,
        width: values.len(),
        separator: format.separator(),
    })
}

/// The period of evenly rising times, s, each with its line.
fn even_period(times: &[(usize, f64)]) -> Result<f64, ProgramError> {
    let (Some((_, first)), Some((_, last))) = (times.first(), times.last()) else {
        return Err(ProgramError::TooShort { rows: 0 });
    };
    if times.len() < 2 {
        return Err(ProgramError::TooShort { rows: times.len() });
    }
    let period_s = (last - first) / (times.len() - 1) as f64;
    for (row, (line, time)) in times.iter().enumerate() {
        let expected_s = first + row as f64 * period_s;
        let even = (time - expected_s).abs() <= PERIOD_TOLERANCE * period_s;
        if !even || period_s <= 0.0 {
            return Err(ProgramError::Uneven {
                line: *line,
                time_s: *time,
                expected_s,
                period_s,
            });
        }
    }
    Ok(period_s)
}
