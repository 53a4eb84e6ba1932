//! `hexsense kinematics pose`: poses from jack lengths.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use hexsense_core::kinematics::{
    Convention, ForwardError, Options, PoseTracker, Solution, SolveFromHome, SolveJumpsFromHome,
    Solver, inverse,
};

use super::rows::{self, cores, output};
use super::table::{self, Columns, Lines, Row};
use super::writing::{LENGTHS, POSE, Writing, header, numbers, pose};
use crate::cli::arguments::Base;
use crate::files::FileError;
use crate::geometry_file::GeometryFile;
use crate::terminal::tell;

/// Columns beside the pose that a solution prints.
const SOLUTION: &str = "residual_m,condition,iterations";

/// Print the poses that have given jack lengths.
///
/// Printed are x,y,z,roll,pitch,yaw (m, rad), residual (m, the greatest difference between a length asked for and that of
/// the pose), condition (the condition number of the Jacobian) and iterations. Rows are solved on all cores, each from
/// the pose before it or, where that is far away, from home; in blocks of 1024 rows, the first of each from home.
#[derive(Args)]
pub struct Poses {
    #[command(flatten)]
    base: Base,
    /// Table of jack lengths l1 to l6 (hinge to hinge; m, or with units in the header: l1_mm); - reads standard input
    #[arg(long, value_name = "FILE", alias = "legs")]
    lengths: PathBuf,
    #[command(flatten)]
    writing: Writing,
    /// Start the first row at this pose, on whatever assembly branch it is, and every other row at the pose before; a
    /// row that is a jump away from the one before is solved from home
    #[arg(long, value_name = "X,Y,Z,ROLL,PITCH,YAW", value_parser = numbers, allow_hyphen_values = true)]
    seed: Option<[f64; 6]>,
}

impl Poses {
    /// Runs the command.
    ///
    /// # Errors
    /// Files that cannot be used, rows that are not six finite numbers, and lengths that no pose has.
    pub fn run(self) -> anyhow::Result<()> {
        let geometry = GeometryFile::load(&self.base.geometry)?.geometry;
        let (columns, lines) = table::open(&self.lengths, &LENGTHS)?;
        let printed = Printed {
            solver: &Solver::new(&geometry, Options::default()),
            convention: self.writing.convention,
            columns,
        };
        let Some(seed) = self.seed else {
            return printed.on_homes_branch(lines, cores(), output());
        };
        let mut seed = Some(pose(printed.convention, &seed));
        let policy = SolveJumpsFromHome::default();
        let mut tracker = PoseTracker::new(printed.solver.clone(), policy);
        rows::in_order(&Printed::header(), lines, output(), |row, line| {
            printed.answer(row, line, |lengths| match seed.take() {
                Some(seed) => tracker.next_near(lengths, &seed),
                None => tracker.next(lengths),
            })
        })?;
        let jumps = tracker.policy().jumps;
        if jumps > 0 {
            tell!("rows solved from home, a jump away from the row before: {jumps}");
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
        format!("{},{SOLUTION}", header(&POSE))
    }

    /// Solves all rows, each from the pose before it in its block, on so many `threads`.
    fn on_homes_branch(
        &self,
        lines: Lines,
        threads: usize,
        output: impl Write,
    ) -> anyhow::Result<()> {
        let start = || PoseTracker::new(self.solver.clone(), SolveFromHome);
        let answer = |tracker: &mut PoseTracker<f64, _>, row: &Row, line: &mut String| {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;

    /// Jack lengths of a movement of `rows` rows with a gap, as a table.
    fn movement(solver: &Solver<f64>, rows: usize) -> String {
        let geometry = solver.geometry();
        let mut text = header(&LENGTHS) + "\n";
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
        let (columns, lines) =
            table::parse("lengths.csv".to_owned(), reader, None, &LENGTHS).unwrap();
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
                "lengths.csv, line 3457: \"nothing\" is not a finite number"
            );
            assert_eq!(
                output.lines().count(),
                3_456,
                "the header and the rows before"
            );
        }
    }
}
