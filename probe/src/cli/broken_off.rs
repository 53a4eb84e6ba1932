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
    let complete = match complete_to {
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

fn quoted(argument: &str) -> String {
    if argument.contains(|c: char| c.is_whitespace() || c == '\'' || c == '"') {
        format!("'{}'", argument.replace('\'', r"'\''"))
    } else {
        argument.to_owned()
    }
}
