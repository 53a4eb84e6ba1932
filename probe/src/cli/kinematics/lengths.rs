//! `hexsense kinematics lengths`: jack lengths from poses.

use std::path::PathBuf;

use clap::Args;
use hexsense_core::kinematics::inverse;

use super::rows::{self, cores, output};
use super::table::{self, Row};
use super::writing::{LENGTHS, POSE, Writing, header, pose};
use crate::cli::arguments::Base;
use crate::geometry_file::GeometryFile;

/// Print the jack lengths l1 to l6 (hinge to hinge, m) of poses; the lengths may lie outside the stroke.
#[derive(Args)]
pub struct Lengths {
    #[command(flatten)]
    base: Base,
    /// Table of poses x,y,z,roll,pitch,yaw (m and rad, or with units in the header: x_mm, roll_deg); - reads standard
    /// input
    #[arg(long, value_name = "FILE")]
    poses: PathBuf,
    #[command(flatten)]
    writing: Writing,
}

impl Lengths {
    /// Runs the command.
    ///
    /// # Errors
    /// Files that cannot be used, and rows that are not six finite numbers.
    pub fn run(self) -> anyhow::Result<()> {
        let geometry = GeometryFile::load(&self.base.geometry)?.geometry;
        let (columns, lines) = table::open(&self.poses, &POSE)?;
        let convention = self.writing.convention;
        let answer = |_: &mut (), row: &Row, line: &mut String| {
            let pose = pose(convention, &columns.numbers(row)?);
            table::write(line, &inverse(&geometry, &pose));
            Ok(())
        };
        rows::by_blocks(&header(&LENGTHS), lines, cores(), output(), || (), answer)
    }
}
