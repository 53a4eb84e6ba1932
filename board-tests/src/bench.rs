//! A board whose power, clock, memory and line can be made to fail, with its flash memory in a folder of its own.

use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use serde_json::Value;

use crate::counts::Counts;
use crate::folders;
use crate::line::Line;
use crate::power::{self, Power};
use crate::process::Beside;
use crate::programs::Program;

/// The files that are the flash memory: its content, and which of its words are torn.
const FLASH: [&str; 2] = [power::FLASH, "flash.bin.ecc"];

/// Within this time of its start a board samples and answers.
pub const STARTED: Duration = Duration::from_millis(100);

/// Where a board's flash memory and log are kept while it is off. Every pin is at half the supply.
pub struct Bench {
    folder: PathBuf,
    /// Seed of noise and random numbers at the next power-on: never twice the same, as on a chip.
    seed: Cell<u64>,
}

impl Bench {
    /// An erased chip, in an emptied folder of this name.
    pub fn new(name: &str, seed: u64) -> anyhow::Result<Self> {
        Ok(Self {
            folder: folders::emptied(name)?,
            seed: Cell::new(seed << 32),
        })
    }

    /// Another board with what this one has in flash, in an emptied folder of this name.
    pub fn copy(&self, name: &str) -> anyhow::Result<Self> {
        let copy = Self::new(name, 0)?;
        copy.seed.set(self.seed.get() + (1 << 20));
        copy_flash(&self.folder, &copy.folder)?;
        Ok(copy)
    }

    /// Switches the board on, with these faults to come, and lets it start.
    pub fn on(&self, faults: &[Value]) -> anyhow::Result<Board> {
        Board::connect(self.start(&Power {
            faults,
            ..Power::default()
        })?)
    }

    /// The same for a chip with these option registers, see [`Power::options`].
    pub fn on_with_options(&self, options: &[&str], faults: &[Value]) -> anyhow::Result<Board> {
        Board::connect(self.start(&Power {
            options,
            faults,
            ..Power::default()
        })?)
    }

    /// Switches the board on, lets it start, and counts the calls of these functions.
    pub fn on_counting(&self, count: &[&str]) -> anyhow::Result<Board> {
        Board::connect(self.start(&Power {
            count,
            ..Power::default()
        })?)
    }

    /// Switches the board on, with the next seed; its time stands still until a host connects.
    pub fn start(&self, power: &Power) -> anyhow::Result<Beside> {
        power::forget_log(&self.folder);
        let seed = self.seed.get();
        self.seed.set(seed + 1);
        let power = Power {
            seed: Some(seed),
            ..*power
        };
        power.on(Program::Firmware, &self.folder)
    }

    /// Where the board's files are.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// What the board and the virtual board have logged since it was last switched on.
    #[must_use]
    pub fn log(&self) -> String {
        power::log(&self.folder)
    }

    /// Keeps a copy of the flash memory under this name.
    pub fn keep(&self, name: &str) -> anyhow::Result<()> {
        let copy = self.folder.join(name);
        folders::empty(&copy)?;
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
            fs::copy(&from, &to).with_context(|| format!("cannot copy {}", from.display()))?;
        } else if to.exists() {
            fs::remove_file(&to)?;
        }
    }
    Ok(())
}

/// A board that is on. Dropping it pulls the plug.
pub struct Board {
    /// The serial line to it; it is let go first.
    pub line: Line,
    process: Beside,
}

impl Board {
    /// Connects to a board that is on, and lets it start.
    pub fn connect(process: Beside) -> anyhow::Result<Self> {
        let mut line = Line::open(process.address("link")?)?;
        line.run(STARTED)?;
        Ok(Self { line, process })
    }

    /// Lets the host go away and returns what was counted until now.
    pub fn leave(self) -> anyhow::Result<Counts> {
        let Self { line, mut process } = self;
        drop(line);
        Counts::read(&mut process)
    }
}
