//! The figures of `docs/acquisition.md` are those of the code and of the data sheet quoted there: every table is
//! computed again from the constants, so that neither can change alone.

mod board;
mod choices;
mod errors;
mod page;
mod signals;
