//! `hexsense kinematics`: jack lengths from poses and poses from jack lengths, table to table.
//!
//! - [`table`]: the CSV that goes in and out.
//! - [`rows`]: all cores at once, or row after row.
//!
//! A pose is six numbers, `x,y,z,roll,pitch,yaw` (m, rad), in the axes and with the angles of a [`Convention`]. With
//! `zyx` and `xyz` these axes have z up, as in a geometry file with `axes = "z-up"`, and the numbers are used as they are,
//! without a change of axes. The solvers work in the frames of the core.

mod rows;
mod table;

use std::io::{self, BufWriter, Write};
use std::num::NonZero;
use std::path::PathBuf;
use std::thread;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};
use hexsense_core::kinematics::{
    Angles, Convention, ForwardError, Options, Pose, Solution, Solver, Tracker, inverse,
};
use nalgebra::Vector3;

use super::arguments::Base;
use crate::files::FileError;
use crate::geometry_file::GeometryFile;
use table::{Columns, Lines, Row};

const POSE: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];
const JACKS: [&str; 6] = ["l1", "l2", "l3", "l4", "l5", "l6"];
/// Columns of a solution beside the pose.
const SOLUTION: [&str; 3] = ["residual", "condition", "iterations"];

/// Compute jack lengths from poses, or poses from jack lengths.
///
/// Tables are CSV. In a table with a header the columns are found by their names, and other columns are passed over, so
/// that each of the two commands reads what the other prints. Without a header a row is six numbers. A bad row ends the
/// command with its line number, after the rows before it.
#[derive(Args)]
pub struct Kinematics {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    #[command(alias = "legs")]
    Jacks(Jacks),
    Pose(Poses),
}

/// Print the jack lengths l1 to l6 (hinge to hinge, m) of poses. The limits of the stroke are not checked.
#[derive(Args)]
struct Jacks {
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
/// The columns are x,y,z,roll,pitch,yaw (m, rad), residual (the greatest difference between a given length and that of the
/// pose, m), condition (the condition number of the Jacobian) and iterations. Rows are solved on all cores in blocks of 1024.
/// The first row of a block is solved from home, every other row from the pose before it or, where that is far away, from
/// home.
#[derive(Args)]
struct Poses {
    #[command(flatten)]
    base: Base,
    /// Table of jack lengths l1 to l6 (hinge to hinge, m); - reads standard input
    #[arg(long, alias = "legs", value_name = "FILE")]
    jacks: PathBuf,
    #[command(flatten)]
    writing: Writing,
    /// Solve the first row from this pose, on the assembly branch of this pose, and every other row from the pose before
    /// it; after a jump a row is solved from home
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
            Task::Jacks(command) => command.run(),
            Task::Pose(command) => command.run(),
        };
        match result {
            // The reader of the table has closed it, and has seen enough.
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

impl Jacks {
    fn run(self) -> anyhow::Result<()> {
        let geometry = GeometryFile::load(&self.base.geometry)?.geometry;
        let (columns, lines) = table::open(&self.poses, &POSE)?;
        let convention = self.writing.convention;
        let answer = |_: &mut (), row: &Row, line: &mut String| {
            let pose = pose(convention, &columns.numbers(row)?);
            let lengths = inverse(&geometry, &pose);
            if !lengths.iter().all(|length| length.is_finite()) {
                return Err(columns.error(row, "so far away that lengths overflow; give metres"));
            }
            table::write(line, &lengths);
            Ok(())
        };
        rows::by_blocks(&JACKS.join(","), lines, cores(), output(), || (), answer)
    }
}

fn cores() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

fn output() -> impl Write {
    BufWriter::new(io::stdout().lock())
}

impl Poses {
    fn run(self) -> anyhow::Result<()> {
        let geometry = GeometryFile::load(&self.base.geometry)?.geometry;
        let (columns, lines) = table::open(&self.jacks, &JACKS)?;
        let printed = Printed {
            solver: &Solver::new(&geometry, Options::default()),
            convention: self.writing.convention,
            columns,
        };
        let Some(seed) = self.seed else {
            return printed.on_homes_branch(lines, cores(), output());
        };
        let mut seeded = Seeded::new(printed.solver, pose(printed.convention, &seed));
        rows::in_order(&Printed::header(), lines, output(), |row, line| {
            printed.answer(row, line, |lengths| seeded.next(lengths))
        })?;
        if seeded.jumps > 0 {
            eprintln!(
                "rows solved from home, a jump away from the row before: {}",
                seeded.jumps
            );
        }
        Ok(())
    }
}

/// How solutions are printed.
struct Printed<'a> {
    solver: &'a Solver<f64>,
    convention: Convention,
    columns: Columns,
}

impl Printed<'_> {
    fn header() -> String {
        [POSE.as_slice(), &SOLUTION].concat().join(",")
    }

    /// Solves all rows, each from the pose before it in its block, on so many `threads`.
    fn on_homes_branch(
        &self,
        lines: Lines,
        threads: usize,
        output: impl Write,
    ) -> anyhow::Result<()> {
        let start = || Tracker::new(self.solver);
        let answer = |tracker: &mut Tracker<'_, f64>, row: &Row, line: &mut String| {
            self.answer(row, line, |lengths| tracker.next(lengths))
        };
        rows::by_blocks(&Self::header(), lines, threads, output, start, answer)
    }

    fn answer(
        &self,
        row: &Row,
        line: &mut String,
        mut solve: impl FnMut(&[f64; 6]) -> Found,
    ) -> Result<(), FileError> {
        let lengths = self.columns.numbers(row)?;
        let solution = solve(&lengths).map_err(|error| self.columns.error(row, error))?;
        self.write(line, &lengths, &solution);
        Ok(())
    }

    fn write(&self, line: &mut String, lengths: &[f64; 6], solution: &Solution<f64>) {
        let there = inverse(self.solver.geometry(), &solution.pose);
        let residual = there
            .iter()
            .zip(lengths)
            .map(|(there, wanted)| (there - wanted).abs())
            .fold(0.0, f64::max);
        let (position, angles) = self.convention.coordinates(&solution.pose);
        let numbers = [
            position.x,
            position.y,
            position.z,
            angles.roll,
            angles.pitch,
            angles.yaw,
            residual,
            self.solver.condition(&solution.pose),
        ];
        table::write(line, &numbers);
        line.push_str(&format!(",{}", solution.iterations));
    }
}

type Found = Result<Solution<f64>, ForwardError<f64>>;

/// Pose after pose of a moving base, the first near a seed.
struct Seeded<'a> {
    solver: &'a Solver<f64>,
    start: Pose<f64>,
    /// Whether `start` is a pose that was found.
    moving: bool,
    jumps: usize,
}

impl<'a> Seeded<'a> {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Jack lengths of a movement of `rows` rows with a gap, as a table.
    fn movement(solver: &Solver<f64>, rows: usize) -> String {
        let geometry = solver.geometry();
        let mut text = JACKS.join(",") + "\n";
        for row in 0..rows {
            let time_s = row as f64 * 1e-3 + if row > 1500 { 0.4 } else { 0.0 };
            let swing = |phase: f64| 0.1 * (6.0 * time_s + phase).sin();
            let at = [
                swing(0.0),
                2.13 + swing(1.0),
                swing(2.0),
                swing(3.0),
                swing(4.0),
                swing(5.0),
            ];
            table::write(&mut text, &inverse(geometry, &pose(Convention::Gost, &at)));
            text.push('\n');
        }
        text
    }

    fn printed(solver: &Solver<f64>, text: &str, threads: usize) -> (String, anyhow::Result<()>) {
        let reader = Box::new(io::Cursor::new(text.to_owned()));
        let (columns, lines) = table::parse("jacks.csv".to_owned(), reader, None, &JACKS).unwrap();
        let mut output = Vec::new();
        let printed = Printed {
            solver,
            convention: Convention::Gost,
            columns,
        };
        let result = printed.on_homes_branch(lines, threads, &mut output);
        (String::from_utf8(output).unwrap(), result)
    }

    #[test]
    fn many_threads_print_the_very_bytes_that_one_prints() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap().geometry;
        let solver = Solver::new(&geometry, Options::default());
        let table = movement(&solver, 20_000);
        let (one, result) = printed(&solver, &table, 1);
        result.unwrap();
        assert_eq!(one.lines().count(), 20_001);
        // Tracked: more than two iterations are for the first row of a block and for the gap.
        let iterations = one
            .lines()
            .skip(1)
            .map(|line| line.rsplit(',').next().unwrap());
        let many = iterations.filter(|count| count.parse::<u32>().unwrap() > 2);
        assert!(many.count() <= 20_000 / 1024 + 2);
        for threads in [2, 3, 7] {
            let (output, result) = printed(&solver, &table, threads);
            result.unwrap();
            assert!(output == one, "{threads} threads print something else");
        }
    }

    #[test]
    fn a_bad_row_ends_the_table_there_whatever_the_number_of_threads() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap().geometry;
        let solver = Solver::new(&geometry, Options::default());
        let mut lines: Vec<String> = movement(&solver, 5_000)
            .lines()
            .map(str::to_owned)
            .collect();
        lines[3_456] = "2.7,2.7,2.7,2.7,2.7,nothing".to_owned();
        let table = lines.join("\n");
        for threads in [1, 4] {
            let (output, result) = printed(&solver, &table, threads);
            let said = result.unwrap_err().to_string();
            assert_eq!(
                said,
                "jacks.csv, line 3457: \"nothing\" is not a finite number"
            );
            assert_eq!(
                output.lines().count(),
                3_456,
                "the header and the rows before"
            );
        }
    }
}
