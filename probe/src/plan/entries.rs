//! One degree of freedom of a run, as a plan writes it: degrees and metres, with the unit in the key.

use hexsense_core::excitation::ramps::MAX_LEVELS;
use hexsense_core::excitation::{DegreeOfFreedom, RampShape, Ramps, Sine};
use serde::{Deserialize, Serialize};

use crate::files::{self, FileError};

/// Longest run, s.
pub(super) const MAX_S: f64 = 1800.0;

/// Shortest estimate of a sine, periods: one, as people round it.
const SHORTEST_PERIODS: f64 = 0.99;

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

/// Ramps and holds of one degree of freedom; see [`Ramps`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RampsEntry {
    /// What moves.
    pub freedom: Freedom,
    /// Level at the end of each subinterval, degrees; for angles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels_deg: Option<Vec<f64>>,
    /// The same in metres; for surge, heave and sway.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels_m: Option<Vec<f64>>,
    /// Subinterval Δt, s.
    pub step_s: f64,
    /// How ramps go.
    pub shape: Shape,
}

/// A sine of one degree of freedom; see [`Sine`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SineEntry {
    /// What moves.
    pub freedom: Freedom,
    /// Amplitude, degrees; for angles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_deg: Option<f64>,
    /// Amplitude, m; for surge, heave and sway.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_m: Option<f64>,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Time to fade in, and again to fade out, s.
    pub fade_s: f64,
    /// Time in which transients die away, s.
    pub settle_s: f64,
    /// Time that is estimated over, s.
    pub estimate_s: f64,
}

/// A degree of freedom as a plan names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[expect(
    missing_docs,
    reason = "the names of the six degrees of freedom say it all"
)]
pub enum Freedom {
    Surge,
    Heave,
    Sway,
    Roll,
    Yaw,
    Pitch,
}

impl From<Freedom> for DegreeOfFreedom {
    fn from(freedom: Freedom) -> Self {
        Self::ALL[freedom as usize]
    }
}

/// How ramps go, as a plan names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// At constant speed.
    Linear,
    /// With zero speed and acceleration at both ends.
    JerkLimited,
}

impl RampsEntry {
    /// The ramps that it means.
    #[must_use]
    pub fn ramps(&self) -> Ramps {
        let degrees = self
            .levels_deg
            .iter()
            .flatten()
            .map(|level| level.to_radians());
        let metres = self.levels_m.iter().flatten().copied();
        Ramps {
            step_s: self.step_s,
            levels: degrees.chain(metres).take(MAX_LEVELS).collect(),
            shape: match self.shape {
                Shape::Linear => RampShape::Linear,
                Shape::JerkLimited => RampShape::JerkLimited,
            },
        }
    }

    pub(super) fn check(&self, file: &str, run: &str) -> Result<(), FileError> {
        let key = |name: &str| format!("run {run}: ramps.{name}");
        files::within(file, &key("step_s"), self.step_s, 0.1..=MAX_S)?;
        let (levels, limit) = in_unit(
            file,
            &key("levels"),
            self.freedom,
            self.levels_deg.as_ref(),
            self.levels_m.as_ref(),
        )?;
        if levels.is_empty() || levels.len() > MAX_LEVELS {
            let value = format!("a list of {}", levels.len());
            let limit = format!("it must have 1 to {MAX_LEVELS} levels");
            return Err(FileError::value(file, key("levels"), value, limit));
        }
        for level in levels {
            files::within(file, &key("levels"), *level, -limit..=limit)?;
        }
        match levels.last() {
            Some(last) if *last != 0.0 => {
                let limit = "its last level must be 0, home";
                Err(FileError::value(file, key("levels"), last, limit))
            }
            _ => Ok(()),
        }
    }
}

impl SineEntry {
    /// The sine that it means.
    #[must_use]
    pub fn sine(&self) -> Sine {
        let degrees = self.amplitude_deg.map(f64::to_radians);
        Sine {
            amplitude: degrees.or(self.amplitude_m).unwrap_or_default(),
            frequency_hz: self.frequency_hz,
            phase_rad: 0.0,
            fade_s: self.fade_s,
            settle_s: self.settle_s,
            estimate_s: self.estimate_s,
        }
    }

    pub(super) fn check(&self, file: &str, run: &str) -> Result<(), FileError> {
        let key = |name: &str| format!("run {run}: sine.{name}");
        let (degrees, metres) = (self.amplitude_deg.as_ref(), self.amplitude_m.as_ref());
        let (amplitude, limit) = in_unit(file, &key("amplitude"), self.freedom, degrees, metres)?;
        files::within(file, &key("amplitude"), *amplitude, 0.0..=limit)?;
        files::within(file, &key("frequency_hz"), self.frequency_hz, 0.01..=50.0)?;
        files::within(file, &key("fade_s"), self.fade_s, 0.1..=MAX_S)?;
        files::within(file, &key("settle_s"), self.settle_s, 0.0..=MAX_S)?;
        files::within(file, &key("estimate_s"), self.estimate_s, 0.1..=MAX_S).map(drop)
    }

    /// Refuses a sine that cannot be told from an offset and a drift while it is estimated.
    pub(super) fn check_period(&self, file: &str, run: &str) -> Result<(), FileError> {
        let period_s = 1.0 / self.frequency_hz;
        if self.estimate_s >= SHORTEST_PERIODS * period_s {
            return Ok(());
        }
        let key = format!("run {run}: sine.estimate_s");
        let limit = format!(
            "at {} Hz it must be at least one period, {period_s:.4} s; three periods, and two to settle, are usual",
            self.frequency_hz
        );
        Err(FileError::value(file, key, self.estimate_s, limit))
    }
}

/// The one of two keys that fits the degree of freedom, and the largest number that makes sense in its unit.
pub(super) fn in_unit<'a, T>(
    file: &str,
    key: &str,
    freedom: Freedom,
    degrees: Option<&'a T>,
    metres: Option<&'a T>,
) -> Result<(&'a T, f64), FileError> {
    let rotation = DegreeOfFreedom::from(freedom).is_rotation();
    match (rotation, degrees, metres) {
        (true, Some(degrees), None) => Ok((degrees, 90.0)),
        (false, None, Some(metres)) => Ok((metres, 10.0)),
        _ => {
            let unit = if rotation { "deg" } else { "m" };
            let limit = format!(
                "a movement in {} needs {key}_{unit} and no other unit",
                DegreeOfFreedom::from(freedom).name()
            );
            Err(FileError::value(
                file,
                key,
                "missing or in another unit",
                limit,
            ))
        }
    }
}
