//! `hexsense kinematics`: jack lengths from poses and poses from jack lengths, table to table, and the base as a figure.
//!
//! - [`lengths`], [`poses`], [`figure`]: the three commands.
//! - [`writing`]: how a pose and a row of lengths are written.
//! - [`table`]: the CSV that goes in and out.
//! - [`rows`]: all cores at once, or row after row.

mod figure;
mod lengths;
mod poses;
mod rows;
mod table;
mod writing;

use std::io;

use clap::{Args, Subcommand};

use figure::Figure;
use lengths::Lengths;
use poses::Poses;

/// Compute jack lengths from poses, or poses from jack lengths; draw the base with the numbers of its jacks.
///
/// Tables are CSV. In a table with a header the columns are found by their names, and other columns are passed over, so
/// that each command reads what the other prints. A name may have its unit behind it (x_mm, roll_deg, l1_m); without one
/// the numbers are in m and rad. Without a header a row is six numbers. A bad row ends the command with its line number,
/// after the rows before it.
#[derive(Args)]
pub struct Kinematics {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    #[command(alias = "legs")]
    Lengths(Lengths),
    Pose(Poses),
    Figure(Figure),
}

impl Kinematics {
    /// Runs the command.
    ///
    /// # Errors
    /// Files that cannot be used, rows that are not six finite numbers, and lengths that no pose has.
    pub fn run(self) -> anyhow::Result<()> {
        let result = match self.task {
            Task::Lengths(command) => command.run(),
            Task::Pose(command) => command.run(),
            Task::Figure(command) => command.run(),
        };
        match result {
            // The reader of the table has closed its end.
            Err(error) if is_closed_pipe(&error) => Ok(()),
            result => result,
        }
    }
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<io::Error>()
        .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}
