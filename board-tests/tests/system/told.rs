//! A command of the host tool that gets into trouble: its messages, which must come in time.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};

/// Within this time the host tool must say what happened.
pub const WITHIN: Duration = Duration::from_secs(5);

/// A running command, and the lines of its standard error.
pub struct Told {
    child: Child,
    lines: Receiver<String>,
    said: String,
}

impl Told {
    /// Starts the command.
    pub fn start(command: &mut Command) -> anyhow::Result<Self> {
        command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut child = command.spawn()?;
        let stderr = child.stderr.take().context("its messages were asked for")?;
        let (say, lines) = mpsc::channel();
        std::thread::spawn(move || {
            let mut lines = BufReader::new(stderr).lines();
            while let Some(Ok(line)) = lines.next()
                && say.send(line).is_ok()
            {}
        });
        Ok(Self {
            child,
            lines,
            said: String::new(),
        })
    }

    /// It must say this in time.
    pub fn says(&mut self, what: &str) -> anyhow::Result<()> {
        let start = Instant::now();
        loop {
            let left = WITHIN.saturating_sub(start.elapsed());
            let line = self.lines.recv_timeout(left).with_context(|| {
                format!(
                    "hexsense did not say {what:?} within {} s: {}",
                    WITHIN.as_secs(),
                    self.said
                )
            })?;
            self.said += &line;
            self.said.push('\n');
            if line.contains(what) {
                return Ok(());
            }
        }
    }

    /// Waits for its end, which must come in time, and returns whether it succeeded and what it said.
    pub fn ended(mut self, within: Duration) -> anyhow::Result<(bool, String)> {
        let start = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait()? {
                break status;
            }
            if start.elapsed() > within {
                self.child.kill()?;
                anyhow::bail!("hexsense did not end within {} s", within.as_secs());
            }
            std::thread::sleep(Duration::from_millis(10));
        };
        // The channel ends with the messages.
        for line in &self.lines {
            self.said += &line;
            self.said.push('\n');
        }
        Ok((status.success(), self.said))
    }

    /// It must fail, say what is safe and what to do next.
    pub fn must_explain(self, what: &str) -> anyhow::Result<()> {
        let (success, said) = self.ended(WITHIN)?;
        ensure!(!success, "hexsense succeeded without a board");
        ensure!(
            said.contains("safe:") && said.contains("do next:"),
            "hexsense does not say that {what}: {said}"
        );
        Ok(())
    }

    /// It must succeed.
    pub fn must_succeed(self, within: Duration) -> anyhow::Result<()> {
        let (success, said) = self.ended(within)?;
        ensure!(success, "hexsense failed: {said}");
        Ok(())
    }
}
