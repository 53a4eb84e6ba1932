//! One way to switch the virtual board on.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Context;
use serde_json::Value;

use crate::process::Beside;
use crate::programs::Program;

/// The file that is the flash memory, in the folder of a board.
pub const FLASH: &str = "flash.bin";
const FAULTS: &str = "faults.jsonl";
const LOG: &str = "board.log";
/// A link on any free port.
const ANY_LINK: &str = "lockstep:127.0.0.1:0";

/// What a board is connected to, and what happens to it while it is on. [`Power::default`] connects nothing.
#[derive(Debug, Default)]
pub struct Power<'a> {
    /// Where the host connects; on any free port when it is not given.
    pub link: Option<&'a str>,
    /// Where the voltages of the pins come from; every pin is at half the supply when it is not given.
    pub pins: Option<&'a str>,
    /// The faults to come; see `docs/virtual-bench.md`.
    pub faults: &'a [Value],
    /// Seed of noise and random numbers.
    pub seed: Option<u64>,
    /// Functions, and interrupts as `irq:N`, whose instructions are counted.
    pub count: &'a [&'a str],
    /// Option registers of the chip, as `NAME=0xVALUE`; those that are not given are as the chip leaves its factory.
    pub options: &'a [&'a str],
}

impl Power<'_> {
    /// Switches the board on. Its flash memory and its log are files in `folder`; it says its address `link`, and its time
    /// stands still until a host connects. Dropping the value pulls the plug.
    pub fn on(&self, elf: Program, folder: &Path) -> anyhow::Result<Beside> {
        fs::create_dir_all(folder)?;
        let mut board = Command::new(Program::VirtualBoard.path()?);
        board.arg("--elf").arg(elf.path()?);
        board.arg("--flash").arg(folder.join(FLASH));
        board.args(["--link", self.link.unwrap_or(ANY_LINK)]);
        if let Some(pins) = self.pins {
            board.args(["--pins", pins]);
        }
        if !self.faults.is_empty() {
            let file = folder.join(FAULTS);
            let lines = self.faults.iter().map(|fault| format!("{fault}\n"));
            fs::write(&file, lines.collect::<String>())?;
            board.arg("--faults").arg(file);
        }
        if let Some(seed) = self.seed {
            board.args(["--seed", &seed.to_string()]);
        }
        for name in self.count {
            board.args(["--count", name]);
        }
        for option in self.options {
            board.args(["--option", option]);
        }
        let file = fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(log_of(folder));
        board.stderr(file.context("cannot write the board's log")?);
        Beside::start(&mut board).with_context(|| log(folder))
    }
}

/// What the boards of a folder have logged since they were first switched on.
#[must_use]
pub fn log(folder: &Path) -> String {
    fs::read_to_string(log_of(folder)).unwrap_or_default()
}

/// Removes the log of a folder.
pub fn forget_log(folder: &Path) {
    // Where there is none, nothing needs to be removed.
    let _ = fs::remove_file(log_of(folder));
}

fn log_of(folder: &Path) -> PathBuf {
    folder.join(LOG)
}
