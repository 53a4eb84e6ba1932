//! The plan of a campaign: which movements the base makes, in numbers that people can read and change.
//!
//! ```toml
//! geometry = "an-74tk-200"
//! geometry_sha256 = "…"
//! period_s = 0.002
//!
//! [[run]]
//! name = "pitch"
//! purpose = "calibrate"
//! [[run.ramps]]
//! freedom = "pitch"
//! levels_deg = [20.0, 20.0, 0.0, 0.0, -20.0, -20.0, 0.0, 0.0]
//! step_s = 4.0
//! shape = "jerk-limited"
//! ```
//!
//! - [`campaign`]: the movements of the method, as large as a base allows.
//! - [`entries`], [`multisine`]: how one degree of freedom is written, and several at once.
//! - [`run`]: one run of the plan.
//! - `fitted`: which runs coefficients can be fitted to.
//! - [`needs`]: which runs a plan must have.
//! - [`forecast`]: what a plan determines and how well, by way of [`ideal`] recordings of it.
//! - [`uses`]: how much of stroke, speed and acceleration a movement uses.
//! - [`conditioning`]: how well the jacks hold the platform along it.
//! - [`hinges`]: how far the jacks swing in their hinges.
//! - [`limits`]: the refusal of a movement that uses too much.
//! - [`margins`]: a figure of it.
//! - [`programs`]: the six jack programs that a motion controller loads.

pub mod campaign;
pub mod conditioning;
pub mod entries;
mod fitted;
pub mod forecast;
pub mod hinges;
pub mod ideal;
pub mod limits;
pub mod margins;
pub mod multisine;
pub mod needs;
pub mod programs;
pub mod run;
pub mod uses;

use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::files::{self, FileError, SETTINGS};
use crate::geometry_file::GeometryFile;
pub use entries::{Freedom, Purpose, RampsEntry, Shape, SineEntry};
pub use multisine::{LinesEntry, MultisineEntry};
pub use run::Run;

/// What a campaign will do, in order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Name of the geometry that it was made for.
    pub geometry: String,
    /// SHA-256 of that geometry's file, in hexadecimal digits.
    pub geometry_sha256: String,
    /// Period of the rows of the jack programs, s.
    pub period_s: f64,
    /// The runs, in order.
    #[serde(rename = "run")]
    pub runs: Vec<Run>,
}

impl Plan {
    /// Reads a plan and checks that its numbers make movements; whether the base can make them is for
    /// [`limits::check`] to say.
    ///
    /// # Errors
    /// [`FileError`] with file, key, value and limit.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        Self::parse(&path.display().to_string(), &files::read(path, SETTINGS)?)
    }

    /// Reads `text`, which came from `file`.
    ///
    /// # Errors
    /// [`FileError::Syntax`] and [`FileError::Value`].
    pub fn parse(file: &str, text: &str) -> Result<Self, FileError> {
        let plan: Self = files::from_toml(file, text)?;
        files::within(file, "period_s", plan.period_s, 1e-3..=0.1)?;
        for (index, run) in plan.runs.iter().enumerate() {
            run.check(file)?;
            if plan.runs[..index]
                .iter()
                .any(|earlier| earlier.name == run.name)
            {
                let limit = "each run needs a name of its own";
                return Err(FileError::value(
                    file,
                    "run.name",
                    format!("{:?} twice", run.name),
                    limit,
                ));
            }
            fitted::check(file, run, &plan.runs[..index])?;
        }
        Ok(plan)
    }

    /// The plan as a file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a plan is made of tables, lists, strings and numbers")
    }

    /// Whether the plan was made for exactly this geometry file, whatever git has made of its line ends since.
    #[must_use]
    pub fn is_for(&self, geometry: &GeometryFile) -> bool {
        let unix = geometry.text.replace("\r\n", "\n");
        let dos = unix.replace('\n', "\r\n");
        let is_its = |text: &str| self.geometry_sha256 == files::hex(&Sha256::digest(text));
        [&geometry.text, &unix, &dos]
            .into_iter()
            .any(|text| is_its(text))
    }

    /// The run of this name.
    #[must_use]
    pub fn run(&self, name: &str) -> Option<&Run> {
        self.runs.iter().find(|run| run.name == name)
    }

    /// The runs with this purpose, in order.
    pub fn runs_to(&self, purpose: Purpose) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(move |run| run.purpose == purpose)
    }
}
