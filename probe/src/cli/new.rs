//! `hexsense new`: a commented file to start from.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::files;
use crate::geometry_file::GeometryFile;
use crate::templates;
use crate::terminal::say;

/// Write a geometry, sensor or plan file to start from, in which every key is explained.
///
/// hexsense reads the file as it is. Replace its numbers by those of your base and sensors; docs/files.md has units,
/// ranges and defaults. A file that is there already is not replaced.
#[derive(Args)]
pub struct New {
    /// What to write
    kind: Kind,
    /// The file
    file: PathBuf,
    /// The motion base that a plan is for: a geometry file (TOML) or the name of a preset
    #[arg(long, value_name = "NAME|FILE", default_value = "an-74tk-200")]
    geometry: String,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    Geometry,
    Sensors,
    Plan,
}

impl New {
    /// Runs the command.
    ///
    /// # Errors
    /// A file that is there already or cannot be written, and a geometry that cannot be used.
    pub fn run(self) -> anyhow::Result<()> {
        let file = self.file.display();
        if self.file.exists() {
            anyhow::bail!("{file} is there already and stays as it is; choose another name");
        }
        let (text, next) = match self.kind {
            Kind::Geometry => (
                templates::GEOMETRY.to_owned(),
                format!("hexsense plan --geometry {file}"),
            ),
            Kind::Sensors => (
                templates::SENSORS.to_owned(),
                format!(
                    "hexsense plan --geometry {} --sensors {file}",
                    self.geometry
                ),
            ),
            Kind::Plan => (
                templates::plan(&GeometryFile::load(&self.geometry)?),
                format!("hexsense plan --geometry {} --plan {file}", self.geometry),
            ),
        };
        files::replace(&self.file, &text)?;
        say!("written: {file}; change its numbers, then check it with: {next}")?;
        Ok(())
    }
}
