//! Programs: run to their end, or beside this one until their owner ends.

use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStdout, Command, Stdio};

use anyhow::{Context, ensure};
use serde_json::Value;

/// Runs a command to its end with its output on standard error; fails when it fails.
pub fn checked(command: &mut Command) -> anyhow::Result<()> {
    command.stdin(Stdio::null()).stdout(std::io::stderr());
    let status = command.status();
    let status = status.with_context(|| format!("cannot start {command:?}"))?;
    ensure!(status.success(), "{command:?} failed ({status})");
    Ok(())
}

/// Runs a command to its end and returns what it printed; fails when it fails.
pub fn output(command: &mut Command) -> anyhow::Result<String> {
    command.stdin(Stdio::null()).stderr(Stdio::inherit());
    let output = command.output();
    let output = output.with_context(|| format!("cannot start {command:?}"))?;
    ensure!(
        output.status.success(),
        "{command:?} failed ({})",
        output.status
    );
    String::from_utf8(output.stdout)
        .with_context(|| format!("{command:?} printed something that is no text"))
}

/// A program beside this one; it is killed when this value is dropped.
pub struct Beside {
    child: Child,
    stdout: BufReader<ChildStdout>,
    /// The line of JSON that it printed when it was ready.
    pub ready: Value,
}

impl Beside {
    /// Starts a program that prints one line of JSON when it is ready.
    pub fn start(command: &mut Command) -> anyhow::Result<Self> {
        command.stdin(Stdio::null()).stdout(Stdio::piped());
        let child = command.spawn();
        let mut child = child.with_context(|| format!("cannot start {command:?}"))?;
        let stdout = child.stdout.take().context("its output was asked for")?;
        let mut this = Self {
            child,
            stdout: BufReader::new(stdout),
            ready: Value::Null,
        };
        this.ready = this
            .said()
            .with_context(|| format!("{command:?} did not start"))?;
        Ok(this)
    }

    /// The next line of JSON that it prints.
    pub fn said(&mut self) -> anyhow::Result<Value> {
        let mut line = String::new();
        self.stdout.read_line(&mut line)?;
        serde_json::from_str(&line).with_context(|| format!("it said {line:?}"))
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
