//! A multisine of a run, as a plan writes it: one timing, and for each degree of freedom its harmonics.
//!
//! ```toml
//! [run.multisine]
//! fundamental_hz = 0.1
//! fade_s = 5.0
//! settle_periods = 1
//! estimate_periods = 2
//! [[run.multisine.lines]]
//! freedom = "heave"
//! harmonics = [3, 9, 15]
//! amplitudes_m = [0.04, 0.01, 0.005]
//! [[run.multisine.lines]]
//! freedom = "roll"
//! harmonics = [4, 10, 16]
//! amplitudes_deg = [3.0, 1.0, 0.5]
//! ```
//!
//! Harmonic 3 of 0.1 Hz is 0.3 Hz. No harmonic may occur twice, so that degrees of freedom can be told apart; the time
//! that is estimated over is a number of periods of the fundamental, and so holds whole periods of every line. Phases
//! are not written: those with a low crest factor are found.

use hexsense_core::excitation::multisine::{MAX_LINES, Timing, shared};
use hexsense_core::excitation::{DegreeOfFreedom, Multisine, Signal};
use serde::{Deserialize, Serialize};

use super::entries::{Freedom, MAX_S, in_unit};
use crate::files::{self, FileError};

/// Highest frequency of a line, Hz, as that of a sine.
const MAX_HZ: f64 = 50.0;
/// Highest harmonic.
const MAX_HARMONIC: u16 = 1000;

/// A multisine of one or several degrees of freedom; see [`Multisine`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultisineEntry {
    /// Fundamental frequency, Hz.
    pub fundamental_hz: f64,
    /// Time to fade in, and again to fade out, s.
    pub fade_s: f64,
    /// Periods of the fundamental in which transients die away.
    pub settle_periods: u16,
    /// Periods of the fundamental that are estimated over.
    pub estimate_periods: u16,
    /// What moves, and how.
    pub lines: Vec<LinesEntry>,
}

/// The lines of one degree of freedom.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinesEntry {
    /// What moves.
    pub freedom: Freedom,
    /// Multiples of the fundamental frequency.
    pub harmonics: Vec<u16>,
    /// Amplitude of each harmonic, degrees; for angles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitudes_deg: Option<Vec<f64>>,
    /// The same in metres; for surge, heave and sway.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitudes_m: Option<Vec<f64>>,
}

impl MultisineEntry {
    /// When it fades in, stays and fades out.
    #[must_use]
    pub fn timing(&self) -> Timing {
        Timing {
            fundamental_hz: self.fundamental_hz,
            fade_s: self.fade_s,
            settle_periods: self.settle_periods,
            estimate_periods: self.estimate_periods,
        }
    }

    /// The signals that it means, one for each degree of freedom.
    pub fn signals(&self) -> impl Iterator<Item = (DegreeOfFreedom, Signal)> + '_ {
        self.lines.iter().map(|lines| {
            let signal = Multisine::new(self.timing(), lines.tones());
            (lines.freedom.into(), Signal::Multisine(signal))
        })
    }

    /// Frequency of the highest line, Hz.
    #[must_use]
    pub fn highest_hz(&self) -> f64 {
        let harmonics = self.lines.iter().flat_map(|lines| &lines.harmonics);
        harmonics.fold(0.0, |highest, harmonic| {
            f64::max(highest, f64::from(*harmonic) * self.fundamental_hz)
        })
    }

    pub(super) fn check(&self, file: &str, run: &str) -> Result<(), FileError> {
        let key = |name: &str| format!("run {run}: multisine.{name}");
        let within = |name: &str, value: f64, low: f64, high: f64| {
            files::within(file, &key(name), value, low..=high).map(drop)
        };
        within("fundamental_hz", self.fundamental_hz, 0.001, MAX_HZ)?;
        within("fade_s", self.fade_s, 0.1, MAX_S)?;
        let estimate = f64::from(self.estimate_periods);
        within("estimate_periods", estimate, 1.0, f64::from(u16::MAX))?;
        for lines in &self.lines {
            lines.check(file, &key("lines"), self.fundamental_hz)?;
        }
        for (index, lines) in self.lines.iter().enumerate() {
            let mut earlier = self.lines.iter().take(index);
            if earlier.any(|earlier| earlier.freedom == lines.freedom) {
                let value = format!("{} twice", DegreeOfFreedom::from(lines.freedom).name());
                let limit = "each degree of freedom has one list of harmonics";
                return Err(FileError::value(file, key("lines.freedom"), value, limit));
            }
        }
        let harmonics: Vec<u16> = self
            .lines
            .iter()
            .flat_map(|lines| lines.harmonics.iter().copied())
            .collect();
        match shared(&harmonics) {
            None => Ok(()),
            Some(twice) => {
                let value = format!("{twice} twice");
                let limit = "each harmonic may occur once in a run, or its degrees of freedom cannot be told apart";
                Err(FileError::value(file, key("lines.harmonics"), value, limit))
            }
        }
    }
}

impl LinesEntry {
    /// Harmonic and amplitude, m or rad, of each line.
    fn tones(&self) -> impl Iterator<Item = (u16, f64)> + '_ {
        let degrees = self.amplitudes_deg.iter().flatten();
        let metres = self.amplitudes_m.iter().flatten();
        let amplitudes = degrees
            .map(|amplitude| amplitude.to_radians())
            .chain(metres.copied());
        self.harmonics.iter().copied().zip(amplitudes)
    }

    fn check(&self, file: &str, key: &str, fundamental_hz: f64) -> Result<(), FileError> {
        let list = |name: &str, length: usize, limit: String| {
            let value = format!("a list of {length}");
            Err(FileError::value(
                file,
                format!("{key}.{name}"),
                value,
                limit,
            ))
        };
        let count = self.harmonics.len();
        if count == 0 || count > MAX_LINES {
            let limit = format!("it must have 1 to {MAX_LINES} harmonics");
            return list("harmonics", count, limit);
        }
        let highest = f64::min(f64::from(MAX_HARMONIC), (MAX_HZ / fundamental_hz).floor());
        for harmonic in &self.harmonics {
            let key = format!("{key}.harmonics");
            files::within(file, &key, f64::from(*harmonic), 1.0..=highest)?;
        }
        let (degrees, metres) = (self.amplitudes_deg.as_ref(), self.amplitudes_m.as_ref());
        let key_amplitudes = format!("{key}.amplitudes");
        let (amplitudes, limit) = in_unit(file, &key_amplitudes, self.freedom, degrees, metres)?;
        if amplitudes.len() != count {
            let limit = format!("it must have {count}, one for each harmonic");
            return list("amplitudes", amplitudes.len(), limit);
        }
        for amplitude in amplitudes {
            files::within(file, &key_amplitudes, *amplitude, 0.0..=limit)?;
        }
        Ok(())
    }
}
