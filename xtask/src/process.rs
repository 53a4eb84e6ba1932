//! Programs: run to their end, or beside this one until their owner ends.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use anyhow::{Context, bail};

/// Runs a command to its end with its output on standard error; fails when it fails.
pub fn checked(command: &mut Command) -> anyhow::Result<()> {
    let shown = shown(command);
    command.stdin(Stdio::null()).stdout(std::io::stderr());
    let status = command
        .status()
        .with_context(|| format!("cannot start `{shown}`"))?;
    if !status.success() {
        bail!("`{shown}` failed ({status})");
    }
    Ok(())
}

/// Runs a command to its end and returns what it printed; fails when it fails.
pub fn output(command: &mut Command) -> anyhow::Result<String> {
    let shown = shown(command);
    command.stdin(Stdio::null()).stderr(Stdio::inherit());
    let output = command
        .output()
        .with_context(|| format!("cannot start `{shown}`"))?;
    if !output.status.success() {
        bail!("`{shown}` failed ({})", output.status);
    }
    String::from_utf8(output.stdout)
        .with_context(|| format!("`{shown}` printed something that is no text"))
}

fn shown(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words
        .map(|word| word.to_string_lossy())
        .collect::<Vec<_>>()
        .join(" ")
}

/// A program beside this one; it is killed when this value is dropped.
pub struct Beside {
    child: Child,
    /// The line of JSON that it printed when it was ready.
    pub ready: serde_json::Value,
}

impl Beside {
    /// Starts a program that prints one line of JSON when it is ready.
    pub fn start(command: &mut Command) -> anyhow::Result<Self> {
        let shown = shown(command);
        command.stdin(Stdio::null()).stdout(Stdio::piped());
        let mut child = command
            .spawn()
            .with_context(|| format!("cannot start `{shown}`"))?;
        let stdout = child.stdout.take().context("its output was asked for")?;
        let mut this = Self {
            child,
            ready: serde_json::Value::Null,
        };
        let mut line = String::new();
        BufReader::new(stdout)
            .read_line(&mut line)
            .with_context(|| format!("`{shown}` said nothing"))?;
        this.ready = serde_json::from_str(&line)
            .with_context(|| format!("`{shown}` did not start: {line:?}"))?;
        Ok(this)
    }

    /// A text out of the line that it printed.
    pub fn address(&self, key: &str) -> anyhow::Result<&str> {
        self.ready[key]
            .as_str()
            .with_context(|| format!("a program did not say its {key}: {}", self.ready))
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        // It may have ended by itself; then there is nothing to kill.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
