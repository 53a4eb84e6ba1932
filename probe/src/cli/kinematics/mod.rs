//! `hexsense kinematics`: jack lengths from poses and poses from jack lengths, table to table.
//!
//! - [`table`]: the CSV that goes in and out.
//! - [`rows`]: row after row, or all cores at once.
//!
//! A pose is six numbers, `x,y,z,roll,pitch,yaw` (m, rad), in the axes and with the angles of a [`Convention`]. With
//! `zyx` and `xyz` those axes have z up, as those of a geometry file with `axes = "z-up"`: what such files and tables
//! say is neither turned on the way in nor on the way out. The files behind them are in the frames of the core.

mod rows;
mod table;

use std::io;
use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};
use hexsense::kinematics::{
    Angles, Convention, ForwardError, Options, Pose, Solution, Solver, inverse,
};
use nalgebra::Vector3;

use super::arguments::Base;
use crate::files::FileError;
use crate::geometry_file::GeometryFile;
use table::{Row, Table};

const POSE: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];
const LEGS: [&str; 6] = ["l1", "l2", "l3", "l4", "l5", "l6"];
/// Columns beside the pose that a solution prints.
const SOLUTION: [&str; 3] = ["residual", "condition", "iterations"];

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
    Legs(Legs),
    Pose(Poses),
}

/// Print the jack lengths l1 to l6 (hinge to hinge, m) of poses; whether they lie inside the stroke is not asked.
#[derive(Args)]
struct Legs {
    #[command(flatten)]
    base: Base,
    /// Table of poses x,y,z,roll,pitch,yaw (m, rad); - reads standard input
    #[arg(long, value_name = "FILE")]
    poses: PathBuf,
    #[command(flatten)]
    writing: Writing,
}

/// Print the poses that have given jack lengths.
///
/// Printed are x,y,z,roll,pitch,yaw (m, rad), residual (the greatest difference between a length asked for and that of
/// the pose, m), condition (the condition number of the Jacobian) and iterations. Every row is solved from home, on
/// all cores.
#[derive(Args)]
struct Poses {
    #[command(flatten)]
    base: Base,
    /// Table of jack lengths l1 to l6 (hinge to hinge, m); - reads standard input
    #[arg(long, value_name = "FILE")]
    legs: PathBuf,
    #[command(flatten)]
    writing: Writing,
    /// Start the first row at this pose, on whatever assembly branch it is, and every other row at the pose before; a
    /// row that is a jump away from the one before is solved from home
    #[arg(long, value_name = "X,Y,Z,ROLL,PITCH,YAW", value_parser = table::six, allow_hyphen_values = true)]
    seed: Option<[f64; 6]>,
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
            Task::Legs(command) => command.run(),
            Task::Pose(command) => command.run(),
        };
        match result {
            // Whoever reads the table has seen enough of it.
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

impl Legs {
    fn run(self) -> anyhow::Result<()> {
        let geometry = GeometryFile::load(&self.base.geometry)?.geometry;
        let table = Table::read(&self.poses, &POSE)?;
        let convention = self.writing.convention;
        rows::on_all_cores(&LEGS.join(","), &table.rows(), |row, line| {
            let pose = pose(convention, &table.numbers(row)?);
            let lengths = inverse(&geometry, &pose);
            if !lengths.iter().all(|length| length.is_finite()) {
                return Err(table.error(row, "so far away that lengths overflow; give metres"));
            }
            table::write(line, &lengths);
            Ok(())
        })
    }
}

impl Poses {
    fn run(self) -> anyhow::Result<()> {
        let geometry = GeometryFile::load(&self.base.geometry)?.geometry;
        let table = Table::read(&self.legs, &LEGS)?;
        let convention = self.writing.convention;
        let solver = Solver::new(&geometry, Options::default());
        let header = [POSE.as_slice(), &SOLUTION].concat().join(",");
        let answer = |row: &Row<'_>,
                      line: &mut String,
                      solve: &mut dyn FnMut(&[f64; 6]) -> Found|
         -> Result<(), FileError> {
            let lengths = table.numbers(row)?;
            let solution = solve(&lengths).map_err(|error| table.error(row, error))?;
            write_solution(line, &solver, convention, &lengths, &solution);
            Ok(())
        };
        let Some(seed) = self.seed else {
            return rows::on_all_cores(&header, &table.rows(), |row, line| {
                answer(row, line, &mut |lengths| solver.solve(lengths))
            });
        };
        let mut tracker = Tracker::new(&solver, pose(convention, &seed));
        rows::in_order(&header, &table.rows(), |row, line| {
            answer(row, line, &mut |lengths| tracker.next(lengths))
        })?;
        if tracker.jumps > 0 {
            eprintln!(
                "rows solved from home, a jump away from the row before: {}",
                tracker.jumps
            );
        }
        Ok(())
    }
}

type Found = Result<Solution<f64>, ForwardError<f64>>;

/// Pose after pose of a moving base, the first near a seed.
struct Tracker<'a> {
    solver: &'a Solver<f64>,
    start: Pose<f64>,
    /// Whether `start` is a pose that was found.
    moving: bool,
    jumps: usize,
}

impl<'a> Tracker<'a> {
    fn new(solver: &'a Solver<f64>, seed: Pose<f64>) -> Self {
        Self {
            solver,
            start: seed,
            moving: false,
            jumps: 0,
        }
    }

    fn next(&mut self, lengths: &[f64; 6]) -> Found {
        let found = if self.moving {
            self.solver.track(lengths, &self.start)
        } else {
            self.solver.solve_near(lengths, &self.start)
        };
        let solution = match found {
            Err(ForwardError::Jump { .. }) => {
                self.jumps += 1;
                self.solver.solve(lengths)?
            }
            found => found?,
        };
        (self.start, self.moving) = (solution.pose, true);
        Ok(solution)
    }
}

fn pose(convention: Convention, numbers: &[f64; 6]) -> Pose<f64> {
    let &[x, y, z, roll, pitch, yaw] = numbers;
    convention.pose(Vector3::new(x, y, z), Angles { roll, pitch, yaw })
}

fn write_solution(
    line: &mut String,
    solver: &Solver<f64>,
    convention: Convention,
    lengths: &[f64; 6],
    solution: &Solution<f64>,
) {
    let there = inverse(solver.geometry(), &solution.pose);
    let residual = there
        .iter()
        .zip(lengths)
        .map(|(there, wanted)| (there - wanted).abs())
        .fold(0.0, f64::max);
    let (position, angles) = convention.coordinates(&solution.pose);
    let numbers = [
        position.x,
        position.y,
        position.z,
        angles.roll,
        angles.pitch,
        angles.yaw,
        residual,
        solver.condition(&solution.pose),
    ];
    table::write(line, &numbers);
    line.push_str(&format!(",{}", solution.iterations));
}
