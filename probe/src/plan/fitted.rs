//! Which runs coefficients can be fitted to.
//!
//! The fit takes a rest at home, ramps and holds in pitch and in roll, a heave sine, and sines in roll, yaw and pitch,
//! one degree of freedom in a run. A run of any other kind would be recorded and then left out, so a plan may
//! have it to verify or to characterise only.

use super::entries::{Freedom, Purpose};
use super::run::Run;
use crate::files::FileError;

/// Refuses a run that calibrates without a use, and a run that an `earlier` run makes superfluous.
pub(super) fn check(file: &str, run: &Run, earlier: &[Run]) -> Result<(), FileError> {
    if run.purpose != Purpose::Calibrate {
        return Ok(());
    }
    let key = format!("run {}: purpose", run.name);
    let refused = |value: String, limit: &str| Err(FileError::value(file, key, value, limit));
    let Some(kind) = Kind::of(run) else {
        let limit = "coefficients are fitted to a rest, to ramps in pitch or roll, and to a sine in heave, roll, yaw \
                     or pitch, one degree of freedom in a run; make its purpose \"verify\" or \"characterise\", or split it \
                     into such runs";
        return refused("\"calibrate\"".to_owned(), limit);
    };
    let calibrates = |other: &&Run| other.purpose == Purpose::Calibrate;
    let same = |other: &&Run| Kind::of(other) == Some(kind);
    match earlier.iter().filter(calibrates).find(same) {
        Some(other) if !kind.may_repeat() => {
            let value = format!("\"calibrate\" with the same movement as run {}", other.name);
            refused(value, "the fit takes one of them; remove the other")
        }
        _ => Ok(()),
    }
}

/// What the fit takes a run for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Rest,
    Holds(Freedom),
    Sine(Freedom),
}

impl Kind {
    /// `None` for a run that is of no use.
    fn of(run: &Run) -> Option<Self> {
        let signals = (run.ramps.as_slice(), run.sine.as_slice(), &run.multisine);
        match signals {
            ([], [], None) => Some(Self::Rest),
            ([ramps], [], None) => match ramps.freedom {
                Freedom::Pitch | Freedom::Roll => Some(Self::Holds(ramps.freedom)),
                _ => None,
            },
            ([], [sine], None) => match sine.freedom {
                Freedom::Surge | Freedom::Sway => None,
                _ => Some(Self::Sine(sine.freedom)),
            },
            _ => None,
        }
    }

    /// Whether the fit takes several of them: turns.
    fn may_repeat(self) -> bool {
        matches!(self, Self::Sine(freedom) if freedom != Freedom::Heave)
    }
}

#[cfg(test)]
mod tests;
