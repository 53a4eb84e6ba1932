//! Instruction counts on the virtual board: runs an ELF there and reads what it counted.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};

use anyhow::{Context, bail, ensure};
use serde::Deserialize;

/// Fewest and most instructions of a call.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Range {
    /// Fewest.
    pub min: u64,
    /// Most.
    pub max: u64,
}

/// The calls of one function.
#[derive(Debug, Clone, Deserialize)]
pub struct Count {
    /// As it was asked for.
    pub name: String,
    /// The symbol that was found.
    pub symbol: String,
    /// Calls that returned.
    pub calls: u64,
    /// Instructions of a call, interrupts left out.
    pub instructions: Range,
    /// Sum over all calls.
    pub total: u64,
}

/// Everything that was counted while one host was there.
#[derive(Debug, Deserialize)]
pub struct Counts {
    /// All instructions that ran.
    pub executed: u64,
    counts: Vec<Count>,
}

impl Counts {
    /// All functions that `name` stands for.
    pub fn of<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Count> {
        self.counts.iter().filter(move |count| count.name == name)
    }

    /// Instructions of every call of the only function called `name`; fails when they differ.
    pub fn fixed(&self, name: &str) -> anyhow::Result<u64> {
        let mut found = self.of(name);
        let count = found
            .next()
            .with_context(|| format!("{name} was not counted"))?;
        ensure!(
            found.next().is_none(),
            "{name} stands for several functions"
        );
        count.fixed()
    }
}

impl Count {
    /// Instructions of every call; fails when they differ.
    pub fn fixed(&self) -> anyhow::Result<u64> {
        let Range { min, max } = self.instructions;
        ensure!(self.calls > 0, "{} was never called", self.name);
        ensure!(
            min == max,
            "{} takes {min} to {max} instructions: its time depends on data",
            self.symbol
        );
        Ok(min)
    }
}

/// A virtual board that counts.
pub struct CountingBoard {
    child: Child,
    stdout: BufReader<ChildStdout>,
    log: PathBuf,
    address: String,
}

impl CountingBoard {
    /// Switches a board on with an erased flash memory; that and its log are files in `folder`. `pins` is where the
    /// voltages come from.
    pub fn start(
        virtual_board: &Path,
        elf: &Path,
        folder: &Path,
        pins: Option<&str>,
        count: &[String],
    ) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let (flash, log) = (folder.join("flash.bin"), folder.join("board.log"));
        let _ = std::fs::remove_file(&flash);
        let mut command = Command::new(virtual_board);
        command.arg("--elf").arg(elf).arg("--flash").arg(flash);
        command.args(["--link", "lockstep:127.0.0.1:0"]);
        if let Some(pins) = pins {
            command.args(["--pins", pins]);
        }
        for name in count {
            command.arg("--count").arg(name);
        }
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(std::fs::File::create(&log)?)
            .spawn()
            .with_context(|| format!("cannot start {}", virtual_board.display()))?;
        let stdout = child.stdout.take().context("its output was asked for")?;
        let mut this = Self {
            child,
            stdout: BufReader::new(stdout),
            log,
            address: String::new(),
        };
        let ready = this.said()?;
        let Ok(ready) = serde_json::from_str::<serde_json::Value>(&ready) else {
            bail!(
                "the virtual board did not start: {}",
                std::fs::read_to_string(&this.log)?
            );
        };
        this.address = ready["link"]
            .as_str()
            .context("the virtual board did not say its link")?
            .to_owned();
        Ok(this)
    }

    /// Where the board's link is, as `hexsense --port` takes it.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Runs until a line of the log begins with `last`, for at most `limit_s` of virtual time, and returns all that it
    /// said.
    pub fn run_until(&self, last: &str, limit_s: u32) -> anyhow::Result<Vec<String>> {
        let address = self.address.trim_start_matches("lockstep:");
        let mut link = TcpStream::connect(address).context("the virtual board does not answer")?;
        for _ in 0..limit_s {
            run_a_second(&mut link)?;
            let log = std::fs::read_to_string(&self.log)?;
            // Time in brackets, what was said, and where in parentheses.
            let said = log.lines().filter_map(|line| {
                let (_, said) = line.split_once(']')?;
                let said = said.rsplit_once("  (").map_or(said, |(said, _)| said);
                Some(said.trim().to_owned())
            });
            let lines: Vec<_> = said.collect();
            if let Some(panic) = lines.iter().find(|said| said.starts_with("panic")) {
                bail!("{panic}");
            }
            if lines.iter().any(|said| said.starts_with(last)) {
                return Ok(lines);
            }
        }
        bail!("the program was not done after {limit_s} s of virtual time")
    }

    /// What was counted while the host was there that has just gone away.
    pub fn counts(&mut self) -> anyhow::Result<Counts> {
        serde_json::from_str(&self.said()?).context("the virtual board's counts cannot be read")
    }

    fn said(&mut self) -> anyhow::Result<String> {
        let mut line = String::new();
        self.stdout.read_line(&mut line)?;
        Ok(line)
    }
}

fn run_a_second(link: &mut TcpStream) -> anyhow::Result<()> {
    link.write_all(&1_000_000_u32.to_le_bytes())?;
    link.write_all(&0_u32.to_le_bytes())?;
    let mut head = [0; 12];
    link.read_exact(&mut head)?;
    let [.., a, b, c, d] = head;
    let mut sent = vec![0; u32::from_le_bytes([a, b, c, d]) as usize];
    link.read_exact(&mut sent)?;
    Ok(())
}

impl Drop for CountingBoard {
    fn drop(&mut self) {
        // It may have ended by itself; then there is nothing to kill.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
