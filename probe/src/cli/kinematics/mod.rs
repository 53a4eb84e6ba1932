//! `hexsense kinematics`: jack lengths from poses and poses from jack lengths, table to table.
//!
//! - [`lengths`], [`poses`]: the two commands.
//! - [`table`]: the CSV that goes in and out.
//! - [`rows`]: all cores at once, or row after row.
//!
//! A pose is six numbers, `x,y,z,roll,pitch,yaw` (m, rad), in the axes and with the angles of a [`Convention`]. With
//! `zyx` and `xyz` those axes have z up, as those of a geometry file with `axes = "z-up"`. The tool turns neither the
//! numbers of such files nor those of such tables. Other files are in the frames of the core.

mod lengths;
mod poses;
mod rows;
mod table;

use std::io::{self, BufWriter, Write};
use std::num::NonZero;
use std::thread;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};
use hexsense_core::kinematics::{Angles, Convention, Pose};
use nalgebra::Vector3;

use lengths::Lengths;
use poses::Poses;

const POSE: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];
const LENGTHS: [&str; 6] = ["l1", "l2", "l3", "l4", "l5", "l6"];
/// Compute jack lengths from poses, or poses from jack lengths.
///
/// Tables are CSV. With a header the columns are found by their names and others are passed over, so that what one of
/// the two commands prints is what the other reads; without one a row is six numbers. A bad row ends the command with
/// its line number, after the rows before it.
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
}

/// How poses are written.
#[derive(Args)]
struct Writing {
    /// Axes and angles of the poses. gost: X forward, Y up, Z right, A = Ry(yaw)·Rz(pitch)·Rx(roll). zyx: z up,
    /// R = Rz(yaw)·Ry(pitch)·Rx(roll). xyz: z up, R = Rx(roll)·Ry(pitch)·Rz(yaw)
    #[arg(long, default_value = "gost", value_parser = convention())]
    convention: Convention,
}

fn convention() -> impl TypedValueParser<Value = Convention> {
    PossibleValuesParser::new(["gost", "zyx", "xyz"]).map(|name| match name.as_str() {
        "zyx" => Convention::Zyx,
        "xyz" => Convention::Xyz,
        _ => Convention::Gost,
    })
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

fn cores() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

fn output() -> impl Write {
    BufWriter::new(io::stdout().lock())
}

fn pose(convention: Convention, numbers: &[f64; 6]) -> Pose<f64> {
    let &[x, y, z, roll, pitch, yaw] = numbers;
    convention.pose(Vector3::new(x, y, z), Angles { roll, pitch, yaw })
}
