//! A table printed row by row: each row of the input gives a row of the output, in the same order.
//!
//! Rows are taken in blocks of a fixed number. A row may need the result of the row before it in its block, but nothing of
//! another block. So blocks are solved on all cores, and the output does not depend on the number of cores. Each round of
//! blocks is read, solved and printed before the next round is read, so a table of any length takes the memory of one
//! round. Printing ends at the first bad row, after the rows before it. A long table has a progress bar when standard error
//! is a terminal.

use std::io::Write;
use std::panic::resume_unwind;
use std::thread;

use indicatif::{ProgressBar, ProgressStyle};

use super::table::{Lines, Row};
use crate::files::FileError;

/// Rows of a block: a millisecond or two of work.
const BLOCK: usize = 1024;
/// Blocks of a round for each thread.
const BLOCKS: usize = 8;
/// A table with fewer bytes is done too soon for a bar.
const LONG: u64 = 2_000_000;

/// Prints `header` and what `answer` appends for each row; blocks are answered on so many `threads`. Whatever `start`
/// makes goes with the rows of one block.
///
/// # Errors
/// That of the first bad row, or that of the output.
pub fn by_blocks<S>(
    header: &str,
    mut lines: Lines,
    threads: usize,
    output: impl Write,
    start: impl Fn() -> S + Sync,
    answer: impl Fn(&mut S, &Row, &mut String) -> Result<(), FileError> + Sync,
) -> anyhow::Result<()> {
    let mut output = Output::new(header, &lines, output)?;
    loop {
        let round: Vec<Row> = lines.by_ref().take(BLOCK * BLOCKS * threads).collect();
        if round.is_empty() {
            return output.finish();
        }
        let blocks: Vec<&[Row]> = round.chunks(BLOCK).collect();
        let shares = blocks.chunks(blocks.len().div_ceil(threads));
        let answer_share = |blocks: &[&[Row]]| -> Vec<Block> {
            let answer_block = |rows: &&[Row]| {
                let mut state = start();
                Block::new(rows, |row, text| answer(&mut state, row, text))
            };
            blocks.iter().map(answer_block).collect()
        };
        let answered: Vec<Block> = thread::scope(|scope| {
            let workers: Vec<_> = shares
                .map(|share| scope.spawn(|| answer_share(share)))
                .collect();
            workers
                .into_iter()
                .flat_map(|worker| worker.join().unwrap_or_else(|panic| resume_unwind(panic)))
                .collect()
        });
        for block in answered {
            output.print(block)?;
        }
    }
}

/// Prints `header` and what `answer` appends for each row; rows are answered one after another.
///
/// # Errors
/// That of the first bad row, or that of the output.
pub fn in_order(
    header: &str,
    mut lines: Lines,
    output: impl Write,
    mut answer: impl FnMut(&Row, &mut String) -> Result<(), FileError>,
) -> anyhow::Result<()> {
    let mut output = Output::new(header, &lines, output)?;
    loop {
        let rows: Vec<Row> = lines.by_ref().take(BLOCK).collect();
        if rows.is_empty() {
            return output.finish();
        }
        output.print(Block::new(&rows, &mut answer))?;
    }
}

/// Rows that are answered.
struct Block {
    text: String,
    /// Size of the rows in their table, bytes.
    size: u64,
    /// Why the rows end early.
    error: Option<FileError>,
}

impl Block {
    fn new(
        rows: &[Row],
        mut answer: impl FnMut(&Row, &mut String) -> Result<(), FileError>,
    ) -> Self {
        let mut block = Self {
            text: String::new(),
            size: rows.iter().map(Row::size).sum(),
            error: None,
        };
        for row in rows {
            if let Err(error) = answer(row, &mut block.text) {
                block.error = Some(error);
                return block;
            }
            block.text.push('\n');
        }
        block
    }
}

struct Output<W: Write> {
    table: W,
    bar: ProgressBar,
}

impl<W: Write> Output<W> {
    fn new(header: &str, lines: &Lines, mut table: W) -> anyhow::Result<Self> {
        writeln!(table, "{header}")?;
        let styled = |bar: ProgressBar, template: &str| match ProgressStyle::with_template(template)
        {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        };
        let bar = match lines.size() {
            Some(size) if size < LONG => ProgressBar::hidden(),
            Some(size) => styled(
                ProgressBar::new(size),
                "[{bar:40}] {bytes} of {total_bytes}, {eta}",
            ),
            None => styled(ProgressBar::no_length(), "{spinner} {bytes} read"),
        };
        Ok(Self { table, bar })
    }

    fn print(&mut self, block: Block) -> anyhow::Result<()> {
        self.table.write_all(block.text.as_bytes())?;
        self.bar.inc(block.size);
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
