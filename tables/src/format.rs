//! Separator and decimal mark of a table.

use std::str::FromStr;

use crate::{Cell, Cells, Mark, Problem, Separator};

/// How a table is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Format {
    separator: Separator,
    /// Unknown until a number has one.
    mark: Option<Mark>,
}

/// Bytes of the longest number: the longest decimal fraction of a double that is not rounded has about 770, but nobody
/// writes it.
const MAX_NUMBER: usize = 64;

impl Format {
    /// Commas between cells, no number yet.
    pub const COMMAS: Self = Self::separated_by(Separator::Comma);

    /// The format of a table by its first line that is not empty.
    ///
    /// # Errors
    /// [`Problem::Separators`].
    pub fn of(line: &str) -> Result<Self, Problem> {
        let line = line.trim();
        let stands = |separator: Separator| Cells::new(line, separator.byte()).nth(1).is_some();
        let separator = match (stands(Separator::Tab), stands(Separator::Semicolon)) {
            (true, true) => return Err(Problem::Separators),
            (true, false) => Separator::Tab,
            (false, true) => Separator::Semicolon,
            (false, false) => Separator::Comma,
        };
        Ok(Self::separated_by(separator))
    }

    /// The format that a line `sep=;` declares, as spreadsheets write it above the table.
    #[must_use]
    pub fn declared(line: &str) -> Option<Self> {
        let line = line.trim_matches(['\r', '\n', '"']);
        let [byte] = *line.strip_prefix("sep=")?.as_bytes() else {
            return None;
        };
        let mut all = Separator::ALL.into_iter();
        all.find(|separator| separator.byte() == byte)
            .map(Self::separated_by)
    }

    const fn separated_by(separator: Separator) -> Self {
        Self {
            separator,
            mark: None,
        }
    }

    /// What stands between cells.
    #[must_use]
    pub fn separator(self) -> Separator {
        self.separator
    }

    /// Whether a line has no text in any cell.
    #[must_use]
    #[inline]
    pub fn is_empty(self, line: &str) -> bool {
        let separator = self.separator.byte();
        line.bytes()
            .all(|byte| byte == separator || byte.is_ascii_whitespace())
    }

    /// The cells of a line.
    #[must_use]
    #[inline]
    pub fn cells(self, line: &str) -> Cells<'_> {
        Cells::new(
            line.trim_end_matches([' ', '\r', '\n']),
            self.separator.byte(),
        )
    }

    /// Takes note of the decimal mark if a number of this row is the first that has one.
    #[inline]
    pub fn learn(&mut self, row: &str) {
        if self.mark.is_none() {
            self.mark = self.cells(row).find_map(|cell| self.mark_of(cell));
        }
    }

    fn mark_of(self, cell: Cell) -> Option<Mark> {
        let (marks, others) = marks(cell.text)?;
        match (marks, others) {
            (1, b'.') => Some(Mark::Point),
            (1, _) if self.may_be_thousands(cell.text) => None,
            (1, _) => Some(Mark::Comma),
            _ => None,
        }
    }

    /// Whether a comma may separate thousands: 1,234. Spreadsheets that do so have no semicolons between cells.
    fn may_be_thousands(self, text: &str) -> bool {
        let digits = text.trim_start_matches(['+', '-']);
        let Some((before, after)) = digits.split_once(',') else {
            return false;
        };
        self.separator != Separator::Semicolon
            && (1..=3).contains(&before.len())
            && !before.starts_with('0')
            && after.len() == 3
            && after.bytes().all(|byte| byte.is_ascii_digit())
    }

    /// The number in a cell of a row that [`Format::learn`] has seen.
    ///
    /// # Errors
    /// [`Problem::NoNumber`], [`Problem::OtherMark`], [`Problem::Thousands`].
    #[inline]
    pub fn number<T: FromStr>(self, cell: Cell) -> Result<T, Problem> {
        let text = cell.text;
        if self.mark == Some(Mark::Comma) {
            return with_comma(text);
        }
        text.parse().map_err(|_| self.no_number(text))
    }

    /// As [`Format::number`], but finite.
    ///
    /// # Errors
    /// As [`Format::number`].
    pub fn finite(self, cell: Cell) -> Result<f64, Problem> {
        let number: f64 = self.number(cell)?;
        if number.is_finite() {
            return Ok(number);
        }
        Err(Problem::NoNumber {
            text: cell.text.to_owned(),
        })
    }

    #[cold]
    fn no_number(self, text: &str) -> Problem {
        let text = text.to_owned();
        match (marks(&text), self.mark) {
            (Some((1, b',')), Some(mark)) => Problem::OtherMark { text, mark },
            (Some((1, b',')), None) => Problem::Thousands { text },
            _ => Problem::NoNumber { text },
        }
    }
}

/// How many points and commas a number has, and the last of them; `None` for what is no number.
fn marks(text: &str) -> Option<(usize, u8)> {
    let is_digit = |byte: u8| byte.is_ascii_digit();
    let is_part = |byte: u8| is_digit(byte) || b"+-eE.,".contains(&byte);
    if !text.bytes().any(is_digit) || !text.bytes().all(is_part) {
        return None;
    }
    let mut marks = text.bytes().filter(|byte| b".,".contains(byte));
    let last = marks.clone().next_back().unwrap_or(0);
    Some((marks.by_ref().count(), last))
}

/// A number with a decimal comma.
fn with_comma<T: FromStr>(text: &str) -> Result<T, Problem> {
    if text.contains('.') && marks(text).is_some() {
        return Err(Problem::OtherMark {
            text: text.to_owned(),
            mark: Mark::Comma,
        });
    }
    let mut bytes = [0; MAX_NUMBER];
    let number = bytes.get_mut(..text.len()).and_then(|bytes| {
        bytes.copy_from_slice(text.as_bytes());
        if let Some(comma) = bytes.iter_mut().find(|byte| **byte == b',') {
            *comma = b'.';
        }
        std::str::from_utf8(bytes).ok()?.parse().ok()
    });
    number.ok_or_else(|| Problem::NoNumber {
        text: text.to_owned(),
    })
}
