//! Why a table cannot be read.

use crate::{Mark, Separator};

/// Why a line of a table cannot be read, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// Two characters that could both be the separator.
    #[error(
        "both tabs and semicolons stand between the cells; separate all cells with one of them, or put a line sep=; above"
    )]
    Separators,
    /// Rows begin where the header should stand.
    #[error("the header is missing; put this line above the rows: {wanted}")]
    NoHeader {
        /// The header that it must have.
        wanted: String,
    },
    /// The header has another column than it must have.
    #[error(
        "column {column} of the header is {found:?} and must be {name:?}; the header must be {wanted}"
    )]
    Header {
        /// The column, from 1.
        column: usize,
        /// What stands there.
        found: String,
        /// What must stand there.
        name: String,
        /// The whole header.
        wanted: String,
    },
    /// A column that occurs twice.
    #[error(
        "the header has {name} twice, in columns {first} and {second}; delete or rename one of them"
    )]
    Twice {
        /// The name.
        name: String,
        /// The column where it stands first, from 1.
        first: usize,
        /// The column where it stands again.
        second: usize,
    },
    /// A row with too few or too many cells.
    #[error("{cells} cells; there must be {width}. {}", width_hint(*cells, *width, *separator))]
    Width {
        /// Cells of the row.
        cells: usize,
        /// Cells that it must have.
        width: usize,
        /// The separator.
        separator: Separator,
    },
    /// A cell that is no number.
    #[error("{text:?} is not a finite number")]
    NoNumber {
        /// The cell.
        text: String,
    },
    /// A cell with the other decimal mark than the numbers before it.
    #[error(
        "{text:?} has a decimal {}, but the numbers before it have decimal {}s; write all numbers alike, without \
         separators of thousands",
        mark.other().name(), mark.name()
    )]
    OtherMark {
        /// The cell.
        text: String,
        /// The mark of the numbers before.
        mark: Mark,
    },
    /// A comma that may stand for thousands.
    #[error(
        "{text:?} may be a decimal comma or a separator of thousands, and no number before it tells which; export the \
         table with decimal points, or with ; between the cells"
    )]
    Thousands {
        /// The cell.
        text: String,
    },
}

fn width_hint(cells: usize, width: usize, separator: Separator) -> String {
    if separator == Separator::Comma && cells > width {
        return "Cells were taken apart at commas; decimal commas need another separator: export the table with ; \
                between the cells, or with decimal points"
            .to_owned();
    }
    format!("Cells were taken apart at {separator}s; commas, semicolons and tabs are understood")
}
