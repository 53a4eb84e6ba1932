//! A table printed row by row: each row of the input gives a row of the output, in the same order.
//!
//! Rows that do not depend on each other are computed on all cores, in blocks; each round of blocks is printed before
//! the next is begun. At the first bad row printing ends, after the rows before it. Long tables have a progress bar,
//! where standard error is a terminal.

use std::io::{self, BufWriter, StdoutLock, Write};
use std::num::NonZero;
use std::panic::resume_unwind;
use std::thread;

use indicatif::{ProgressBar, ProgressStyle};

use super::table::Row;
use crate::files::FileError;

/// Rows of a block: some tens of milliseconds of work.
const BLOCK: usize = 4096;
/// A table with fewer rows is done before a bar could be read.
const LONG: usize = 20_000;

/// Prints `header` and what `answer` appends for each row; rows are answered on all cores.
///
/// # Errors
/// That of the first bad row, or that of standard output.
pub fn on_all_cores(
    header: &str,
    rows: &[Row<'_>],
    answer: impl Fn(&Row<'_>, &mut String) -> Result<(), FileError> + Sync,
) -> anyhow::Result<()> {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let mut output = Output::new(header, rows.len())?;
    for round in rows.chunks(BLOCK * cores) {
        // A round shorter than the others is shared out as well.
        let share = round.len().div_ceil(cores);
        let blocks: Vec<Block> = thread::scope(|scope| {
            let workers: Vec<_> = round
                .chunks(share)
                .map(|rows| scope.spawn(|| Block::new(rows, &answer)))
                .collect();
            workers
                .into_iter()
                .map(|worker| worker.join().unwrap_or_else(|panic| resume_unwind(panic)))
                .collect()
        });
        for block in blocks {
            output.print(block)?;
        }
    }
    output.finish()
}

/// Prints `header` and what `answer` appends for each row; rows are answered one after another.
///
/// # Errors
/// That of the first bad row, or that of standard output.
pub fn in_order(
    header: &str,
    rows: &[Row<'_>],
    mut answer: impl FnMut(&Row<'_>, &mut String) -> Result<(), FileError>,
) -> anyhow::Result<()> {
    let mut output = Output::new(header, rows.len())?;
    for rows in rows.chunks(BLOCK) {
        output.print(Block::new(rows, &mut answer))?;
    }
    output.finish()
}

/// Rows that are answered.
struct Block {
    text: String,
    rows: usize,
    /// Why the rows end before their time.
    error: Option<FileError>,
}

impl Block {
    fn new(
        rows: &[Row<'_>],
        mut answer: impl FnMut(&Row<'_>, &mut String) -> Result<(), FileError>,
    ) -> Self {
        let mut text = String::new();
        for (done, row) in rows.iter().enumerate() {
            if let Err(error) = answer(row, &mut text) {
                return Self {
                    text,
                    rows: done,
                    error: Some(error),
                };
            }
            text.push('\n');
        }
        Self {
            text,
            rows: rows.len(),
            error: None,
        }
    }
}

struct Output {
    table: BufWriter<StdoutLock<'static>>,
    bar: ProgressBar,
}

impl Output {
    fn new(header: &str, rows: usize) -> io::Result<Self> {
        let mut table = BufWriter::new(io::stdout().lock());
        writeln!(table, "{header}")?;
        let bar = if rows < LONG {
            ProgressBar::hidden()
        } else {
            let style =
                ProgressStyle::with_template("[{bar:40}] {human_pos} of {human_len} rows, {eta}")
                    .unwrap_or_else(|_| ProgressStyle::default_bar());
            ProgressBar::new(rows as u64).with_style(style)
        };
        Ok(Self { table, bar })
    }

    fn print(&mut self, block: Block) -> anyhow::Result<()> {
        self.table.write_all(block.text.as_bytes())?;
        self.bar.inc(block.rows as u64);
        match block.error {
            None => Ok(()),
            Some(error) => {
                self.table.flush()?;
                self.bar.finish_and_clear();
                Err(error.into())
            }
        }
    }

    fn finish(mut self) -> anyhow::Result<()> {
        self.table.flush()?;
        self.bar.finish_and_clear();
        Ok(())
    }
}
