//! The parts of the product, built, and named in the environment of the programs that use them.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Context;

use crate::command::{cargo, checked};
use crate::setup::{self, BOARD_TARGET};

/// A part that is built by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The firmware's ELF.
    Firmware,
    /// The ELF that has the sample path beside others.
    SamplePathBench,
    /// The emulated board.
    VirtualBoard,
    /// The motion base.
    Twin,
    /// `hexsense`.
    HostTool,
}

impl Part {
    /// Everything that can be built.
    pub const ALL: [Self; 5] = [
        Self::Firmware,
        Self::SamplePathBench,
        Self::VirtualBoard,
        Self::Twin,
        Self::HostTool,
    ];
    /// The virtual bench.
    pub const BENCH: [Self; 4] = [
        Self::Firmware,
        Self::VirtualBoard,
        Self::Twin,
        Self::HostTool,
    ];
    /// The board, and the host tool that records from it.
    pub const FAULTS: [Self; 3] = [Self::Firmware, Self::VirtualBoard, Self::HostTool];
    /// The two ELFs whose instructions are counted, and the board that they run on.
    pub const COUNTED: [Self; 3] = [Self::Firmware, Self::SamplePathBench, Self::VirtualBoard];

    /// The variable that names its file to `board-tests`.
    const fn variable(self) -> &'static str {
        match self {
            Self::Firmware => "HEXSENSE_FIRMWARE",
            Self::SamplePathBench => "HEXSENSE_SAMPLE_PATH_BENCH",
            Self::VirtualBoard => "HEXSENSE_VIRTUAL_BOARD",
            Self::Twin => "HEXSENSE_TWIN",
            Self::HostTool => "HEXSENSE_HOST_TOOL",
        }
    }

    /// Its package and its binary.
    const fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Firmware => ("hexsense", "firmware"),
            Self::SamplePathBench => ("sample-path-bench", "sample-path-bench"),
            Self::VirtualBoard => ("virtual-board", "virtual-board"),
            Self::Twin => ("twin", "twin"),
            Self::HostTool => ("hexsense-probe", "hexsense"),
        }
    }

    const fn is_for_the_board(self) -> bool {
        matches!(self, Self::Firmware | Self::SamplePathBench)
    }

    /// Builds it, and installs what the machine lacks for that.
    fn build(self) -> anyhow::Result<()> {
        if self.is_for_the_board() {
            setup::board_target()?;
        }
        if self == Self::VirtualBoard {
            setup::emulator_packages()?;
        }
        checked(&mut self.cargo("build"))
    }

    /// `cargo COMMAND` for this part alone: with other packages beside it, their features would be unified with its own
    /// and bring `std` into the firmware.
    pub fn cargo(self, command: &str) -> Command {
        let (package, binary) = self.names();
        let mut cargo = cargo(command);
        cargo.args(["--package", package, "--bin", binary]);
        if self.is_for_the_board() {
            cargo.args(["--profile", "firmware", "--target", BOARD_TARGET]);
        }
        if self == Self::Firmware {
            cargo.args(["--features", "firmware"]);
        }
        cargo
    }

    /// Where it lies, in the target folder of this program.
    fn file(self) -> anyhow::Result<PathBuf> {
        let own = std::env::current_exe().context("this program has no place")?;
        let host = own.parent().context("this program is in a folder")?;
        let target = host
            .parent()
            .context("the folder of this program is in the target folder")?;
        let folder = if self.is_for_the_board() {
            target.join(BOARD_TARGET).join("firmware")
        } else {
            host.to_owned()
        };
        Ok(folder.join(self.names().1))
    }
}

/// Builds these parts.
pub fn build(parts: &[Part]) -> anyhow::Result<()> {
    parts.iter().try_for_each(|part| part.build())
}

/// Names the files of these parts in the environment of `command`.
pub fn name(parts: &[Part], command: &mut Command) -> anyhow::Result<()> {
    for part in parts {
        command.env(part.variable(), part.file()?);
    }
    Ok(())
}
