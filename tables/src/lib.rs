//! Tables of numbers as people have them: one reader for pose and length tables, jack programs, captures and truth tables.
//!
//! A table is what a program or a spreadsheet exports. What is read without a guess:
//!
//! | what | how it is told |
//! |---|---|
//! | separator `,` `;` or tab | by the first line, or by a line `sep=;` above it |
//! | decimal point or comma | by the first number that has one; all others must have the same |
//! | quoted cells and headers | by their quotes, which are taken off |
//! | CRLF, byte order mark, blanks around cells, empty lines, empty cells behind the last column | passed over |
//!
//! Anything else is a [`Problem`], which says what to do.
//!
//! - `marks`: [`Separator`] and [`Mark`].
//! - `format`: [`Format`], separator and decimal mark; a number from a cell.
//! - `cells`: [`Cell`], a line split into cells.
//! - `header`: the names of the columns.
//! - `table`: [`Table`], the lines of a whole text.
//!
//! A line is split where it lies and no cell is copied, because a capture has millions of them. That is why this is no
//! general CSV reader: a cell cannot hold a line end, and a doubled quote inside a cell stays doubled.

#![forbid(unsafe_code)]

mod cells;
mod format;
mod header;
mod marks;
mod problem;
mod table;

pub use cells::{Cell, Cells};
pub use format::Format;
pub use header::{expect, names};
pub use marks::{Mark, Separator};
pub use problem::Problem;
pub use table::{BYTE_ORDER_MARK, Line, Table};
