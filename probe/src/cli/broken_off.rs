//! A recording that broke off: what happened, what is safe, what to do next.

use std::path::Path;

/// A recording that broke off.
#[derive(Debug, thiserror::Error)]
#[error("{what} broke off: {reason}\nsafe:    {safe}\ndo next: {next}")]
pub struct BrokenOff {
    /// What was recorded.
    pub what: String,
    /// What happened.
    #[source]
    pub reason: anyhow::Error,
    /// What is not lost.
    pub safe: String,
    /// What to do.
    pub next: String,
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
