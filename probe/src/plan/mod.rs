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
pub mod uses;

use std::path::Path;

use hexsense_core::excitation::{DegreeOfFreedom, Program, Signal, Sine};
use serde::{Deserialize, Serialize};

use crate::files::{self, FileError};
use crate::geometry_file::GeometryFile;
pub use entries::{Freedom, RampsEntry, Shape, SineEntry};
pub use multisine::{LinesEntry, MultisineEntry};

/// Most signals of one run: one for each degree of freedom.
const MAX_SIGNALS: usize = 6;
/// Longest run, s.
const MAX_S: f64 = 1800.0;

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

/// What a run is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Purpose {
    /// Coefficients are fitted to it: a rest, or one degree of freedom.
    Calibrate,
    /// Coefficients are judged by it; nothing is fitted to it.
    Verify,
    /// The motion system is measured by it, see [`crate::characteristics`]; nothing is fitted to it.
    Characterise,
}

impl Purpose {
    /// As a plan writes it, which is also the command that records such a run.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Calibrate => "calibrate",
            Self::Verify => "verify",
            Self::Characterise => "characterise",
        }
    }
}

/// One movement from home and back, or a rest at home.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Name, also of its files.
    pub name: String,
    /// What it is for.
    pub purpose: Purpose,
    /// Length of a rest at home, s; a run that rests moves nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest_s: Option<f64>,
    /// Degrees of freedom moved by ramps and holds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ramps: Vec<RampsEntry>,
    /// Degrees of freedom moved by sines.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sine: Vec<SineEntry>,
    /// Degrees of freedom moved by many sines each, all on one grid of frequencies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub multisine: Option<MultisineEntry>,
}

impl Plan {
    /// Reads a plan and checks that its numbers make movements; whether the base can make them is for
    /// [`limits::check`] to say.
    ///
    /// # Errors
    /// [`FileError`] with file, key, value and limit.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        Self::parse(&path.display().to_string(), &files::read(path)?)
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

    /// Whether the plan was made for exactly this geometry file.
    #[must_use]
    pub fn is_for(&self, geometry: &GeometryFile) -> bool {
        self.geometry_sha256 == files::hex(&geometry.hash)
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

impl Run {
    /// The movement; a rest has no signals.
    #[must_use]
    pub fn program(&self) -> Program {
        let ramps = self
            .ramps
            .iter()
            .map(|entry| (entry.freedom.into(), Signal::Ramps(entry.ramps())));
        let sines = self
            .sine
            .iter()
            .map(|entry| (entry.freedom.into(), Signal::Sine(entry.sine())));
        let multisines = self.multisine.iter().flat_map(MultisineEntry::signals);
        Program {
            signals: ramps
                .chain(sines)
                .chain(multisines)
                .take(MAX_SIGNALS)
                .collect(),
        }
    }

    /// Length, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.rest_s.unwrap_or_else(|| self.program().duration_s())
    }

    /// The sine of a run that moves one degree of freedom by one sine.
    #[must_use]
    pub fn single_sine(&self) -> Option<(DegreeOfFreedom, Sine)> {
        match (self.sine.as_slice(), self.ramps.as_slice(), &self.multisine) {
            ([entry], [], None) => Some((entry.freedom.into(), entry.sine())),
            _ => None,
        }
    }

    fn check(&self, file: &str) -> Result<(), FileError> {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if self.name.is_empty() || !self.name.chars().all(plain) {
            let limit = "it names files: letters, digits, - and _ only";
            return Err(FileError::value(
                file,
                "run.name",
                format!("{:?}", self.name),
                limit,
            ));
        }
        let lines = self.multisine.as_ref().map_or(0, |entry| entry.lines.len());
        let signals = self.ramps.len() + self.sine.len() + lines;
        if (self.rest_s.is_some() && signals > 0)
            || (self.rest_s.is_none() && signals == 0)
            || signals > MAX_SIGNALS
        {
            let limit = format!(
                "it needs either rest_s or 1 to {MAX_SIGNALS} of ramps, sine and multisine.lines"
            );
            let value = format!("a run with {signals} signals");
            return Err(FileError::value(
                file,
                format!("run {}", self.name),
                value,
                limit,
            ));
        }
        if let Some(rest_s) = self.rest_s {
            files::within(
                file,
                &format!("run {}: rest_s", self.name),
                rest_s,
                1.0..=MAX_S,
            )?;
        }
        self.ramps
            .iter()
            .try_for_each(|entry| entry.check(file, &self.name))?;
        self.sine
            .iter()
            .try_for_each(|entry| entry.check(file, &self.name))?;
        if let Some(entry) = &self.multisine {
            entry.check(file, &self.name)?;
        }
        let key = format!("run {}: length in seconds", self.name);
        files::within(file, &key, self.duration_s(), 0.1..=MAX_S).map(drop)
    }
}
