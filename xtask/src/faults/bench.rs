//! A board whose power, clock, memory and line can be made to fail, with its flash memory in a folder of its own.

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::Context;
use serde_json::Value;

use super::line::Line;
use crate::build::{self, Parts};
use crate::process::Beside;

/// The files that are the flash memory: its content, and which of its words are torn.
const FLASH: [&str; 2] = ["flash.bin", "flash.bin.ecc"];

/// Within this time of its start a board samples and answers.
pub const STARTED: Duration = Duration::from_millis(100);

/// Where a board's flash memory and log are kept while it is off.
pub struct Bench<'a> {
    parts: &'a Parts,
    folder: PathBuf,
    /// Seed of noise and random numbers at the next power-on: never twice the same, as on a chip.
    seed: Cell<u64>,
}

impl<'a> Bench<'a> {
    /// An erased chip, in an emptied folder of this name.
    pub fn new(parts: &'a Parts, name: &str, seed: u64) -> anyhow::Result<Self> {
        let folder = build::workspace().join("target/faults").join(name);
        build::empty_folder(&folder)?;
        Ok(Self {
            parts,
            folder,
            seed: Cell::new(seed << 32),
        })
    }

    /// Another board with what this one has in flash, in an emptied folder of this name.
    pub fn copy(&self, name: &str) -> anyhow::Result<Self> {
        let copy = Self::new(self.parts, name, 0)?;
        copy.seed.set(self.seed.get() + (1 << 20));
        copy_flash(&self.folder, &copy.folder)?;
        Ok(copy)
    }

    /// Switches the board on, with these faults to come, and lets it start.
    pub fn on(&self, faults: &[Value]) -> anyhow::Result<Board> {
        let process = self.start(faults)?;
        let mut line = Line::open(process.address("link")?)?;
        line.run(STARTED)?;
        Ok(Board { line, process })
    }

    /// Switches the board on, with these faults to come (see docs/virtual-bench.md); its time stands still until somebody
    /// connects.
    pub fn start(&self, faults: &[Value]) -> anyhow::Result<Beside> {
        let timeline = self.folder.join("faults.jsonl");
        let lines: Vec<String> = faults.iter().map(|fault| format!("{fault}\n")).collect();
        std::fs::write(&timeline, lines.concat())?;
        let log = std::fs::File::create(self.folder.join("board.log"))?;
        let mut board = Command::new(&self.parts.virtual_board);
        board
            .arg("--elf")
            .arg(&self.parts.firmware)
            .arg("--flash")
            .arg(self.folder.join(FLASH[0]))
            .arg("--faults")
            .arg(&timeline);
        board.args(["--link", "lockstep:127.0.0.1:0"]);
        board.args(["--seed", &self.seed.get().to_string()]);
        self.seed.set(self.seed.get() + 1);
        Beside::start(board.stderr(log))
    }

    /// Where the board's files are.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// What the board and the virtual board said since it was last switched on.
    pub fn log(&self) -> String {
        std::fs::read_to_string(self.folder.join("board.log")).unwrap_or_default()
    }

    /// Keeps a copy of the flash memory under this name.
    pub fn keep(&self, name: &str) -> anyhow::Result<()> {
        let copy = self.folder.join(name);
        build::empty_folder(&copy)?;
        copy_flash(&self.folder, &copy)
    }

    /// Makes the flash memory what it was when it was kept under this name.
    pub fn restore(&self, name: &str) -> anyhow::Result<()> {
        copy_flash(&self.folder.join(name), &self.folder)
    }
}

fn copy_flash(from: &Path, to: &Path) -> anyhow::Result<()> {
    for name in FLASH {
        let (from, to) = (from.join(name), to.join(name));
        if from.exists() {
            std::fs::copy(&from, &to).with_context(|| format!("cannot copy {}", from.display()))?;
        } else if to.exists() {
            std::fs::remove_file(&to)?;
        }
    }
    Ok(())
}

/// A board that is on. Dropping it pulls the plug.
pub struct Board {
    /// The serial line to it.
    pub line: Line,
    /// The line is let go first.
    #[expect(dead_code, reason = "it runs for as long as it is held")]
    process: Beside,
}
