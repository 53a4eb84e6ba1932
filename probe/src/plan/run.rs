//! One run of a plan: a movement from home and back, or a rest.

use hexsense_core::excitation::{DegreeOfFreedom, Program, Signal, Sine};
use serde::{Deserialize, Serialize};

use super::entries::{MAX_S, Purpose, RampsEntry, SineEntry};
use super::multisine::MultisineEntry;
use crate::files::{self, FileError};

/// Most signals of one run: one for each degree of freedom.
const MAX_SIGNALS: usize = 6;

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

    pub(super) fn check(&self, file: &str) -> Result<(), FileError> {
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
        if self.purpose == Purpose::Calibrate {
            self.sine
                .iter()
                .try_for_each(|entry| entry.check_period(file, &self.name))?;
        }
        if let Some(entry) = &self.multisine {
            entry.check(file, &self.name)?;
        }
        let key = format!("run {}: length in seconds", self.name);
        files::within(file, &key, self.duration_s(), 0.1..=MAX_S).map(drop)
    }
}
