//! What is printed of a recording that broke off: what happened, what is safe, what to do next.

use std::path::Path;

use crate::campaign::Campaign;
use crate::record::RecordError;
use crate::record::sequence::SequenceError;

/// A recording that broke off.
#[derive(Debug, thiserror::Error)]
#[error("{what} broke off: {reason}\nsafe:    {safe}\ndo next: {next}")]
pub struct BrokenOff {
    /// What was recorded.
    pub what: String,
    /// What happened.
    #[source]
    pub reason: Box<RecordError>,
    /// What is safe.
    pub safe: String,
    /// What to do.
    pub next: String,
}

/// The error of a sequence of runs as it is printed; `again` is the command that goes on.
#[must_use]
pub fn of_sequence(error: SequenceError, campaign: &Campaign, again: &str) -> anyhow::Error {
    let (name, complete_to, reason) = match error {
        SequenceError::BrokenOff {
            run,
            complete_to,
            reason,
        } => (run, complete_to, reason),
        error => return error.into(),
    };
    let folder = campaign.folder.display();
    // Runs that were complete before, as those of the calibration are for `verify`.
    let earlier = campaign.plan.runs.iter().map(|run| &run.name);
    let mut earlier = earlier.filter(|run| campaign.is_recorded(run));
    let complete = match complete_to.as_ref().or(earlier.next_back()) {
        Some(last) => format!("{folder} is complete up to run {last}"),
        None => format!("{folder} holds no complete run yet"),
    };
    let broken_off = BrokenOff {
        what: format!("run {name}"),
        reason,
        safe: format!(
            "nothing on the board has changed, it keeps sampling and its coefficients are still active; {complete}"
        ),
        next: format!("bring the base home, then go on with run {name} by\n         {again}"),
    };
    broken_off.into()
}

/// A path as it is typed into a shell.
#[must_use]
pub fn typed(path: &Path) -> String {
    quoted(&path.display().to_string())
}

/// This command line, as it is typed into a shell.
#[must_use]
pub fn same_again() -> String {
    let words = std::env::args().skip(1).map(|argument| quoted(&argument));
    let words: Vec<String> = std::iter::once("hexsense".to_owned())
        .chain(words)
        .collect();
    words.join(" ")
}

/// An argument that a shell takes as it is: in quotes, unless no character of it means anything to a shell.
fn quoted(argument: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-+=:,./@%".contains(c);
    if !argument.is_empty() && argument.chars().all(is_plain) {
        argument.to_owned()
    } else {
        format!("'{}'", argument.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::campaign::CampaignError;
    use crate::geometry_file::GeometryFile;
    use crate::plan::campaign;
    use crate::sensor_file::SensorFile;

    #[test]
    fn what_a_shell_would_change_stands_in_quotes() {
        let plain = "--out=/tmp/spring_2-a.1:x";
        assert_eq!(quoted(plain), plain);
        for word in ["a b", "a\tb", "a\"b", "a&b", "a$b", "a;b", "a*b", "~", ""] {
            assert_eq!(quoted(word), format!("'{word}'"));
        }
        assert_eq!(quoted("it's"), r"'it'\''s'");
    }

    #[test]
    fn a_verification_that_breaks_off_says_that_the_calibration_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let plan = campaign::plan(&geometry).unwrap();
        let sensors = SensorFile::parse("sensors.toml", &twin::papers::sensor_file(1)).unwrap();
        let prepared: Result<_, CampaignError> =
            Campaign::prepare(folder.path(), geometry, sensors, |_| Ok(plan));
        let prepared = prepared.unwrap();
        let said = || {
            let error = SequenceError::BrokenOff {
                run: "held-out".to_owned(),
                complete_to: None,
                reason: Box::new(RecordError::Restarted {
                    scan: 5,
                    expected: 9,
                }),
            };
            of_sequence(error, &prepared, "hexsense verify").to_string()
        };
        assert!(said().contains("holds no complete run yet"), "{}", said());
        fs::create_dir(folder.path().join("captures")).unwrap();
        for run in prepared.plan.runs_to(crate::plan::Purpose::Calibrate) {
            for end in ["csv", "json"] {
                let name = format!("captures/{}.{end}", run.name);
                fs::write(folder.path().join(name), "").unwrap();
            }
        }
        assert!(
            said().contains("is complete up to run pitch-sine"),
            "{}",
            said()
        );
    }
}
