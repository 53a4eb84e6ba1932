//! `hexsense kinematics figure`: the motion base with the numbers of its jacks.

use std::path::PathBuf;

use clap::Args;

use crate::base_figure;
use crate::cli::arguments::Base;
use crate::files;
use crate::geometry_file::GeometryFile;
use crate::terminal;

/// Draw the base at home from above and from the right: which jack is number 1, how the numbers run, where the axes
/// point.
#[derive(Args)]
pub struct Figure {
    #[command(flatten)]
    base: Base,
    /// Write the figure (SVG) to this file; without it, print it
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Figure {
    /// Runs the command.
    ///
    /// # Errors
    /// Files that cannot be used.
    pub fn run(self) -> anyhow::Result<()> {
        let page = base_figure::page(&GeometryFile::load(&self.base.geometry)?);
        match self.out {
            Some(path) => files::replace(&path, &page)?,
            None => terminal::print(&page)?,
        }
        Ok(())
    }
}
