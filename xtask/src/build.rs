//! The parts of the product, built and found.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Context;

use crate::process::checked;
use crate::setup::{self, BOARD_TARGET};

/// Where the built programs are.
#[derive(Debug, Clone)]
pub struct Parts {
    /// The firmware's ELF.
    pub firmware: PathBuf,
    /// The emulated board.
    pub virtual_board: PathBuf,
    /// The motion base.
    pub twin: PathBuf,
    /// The host tool.
    pub hexsense: PathBuf,
}

/// Builds everything that the virtual bench needs, installing what is missing.
pub fn everything() -> anyhow::Result<Parts> {
    setup::board_target()?;
    setup::emulator_packages()?;
    checked(&mut firmware("build"))?;
    let packages = [
        "--package",
        "virtual-board",
        "--package",
        "twin",
        "--package",
        "hexsense-probe",
    ];
    checked(cargo("build").args(packages))?;
    Parts::find()
}

/// `cargo COMMAND` in the workspace.
pub fn cargo(command: &str) -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.arg(command).current_dir(workspace());
    cargo
}

/// `cargo COMMAND` for the firmware.
pub fn firmware(command: &str) -> Command {
    let mut cargo = cargo(command);
    // Only this package: features of host packages would be unified with its own, and bring in `std`.
    cargo.args([
        "--package",
        "hexsense",
        "--profile",
        "firmware",
        "--target",
        BOARD_TARGET,
    ]);
    cargo.args(["--features", "firmware", "--bin", "firmware"]);
    cargo
}

/// Makes a folder, or empties it where it is.
pub fn empty_folder(folder: &Path) -> anyhow::Result<()> {
    let what = || format!("cannot make room in {}", folder.display());
    if folder.exists() {
        std::fs::remove_dir_all(folder).with_context(what)?;
    }
    std::fs::create_dir_all(folder).with_context(what)
}

/// Root of the workspace.
pub fn workspace() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

impl Parts {
    /// The programs beside this one in the target folder.
    pub fn find() -> anyhow::Result<Self> {
        let own = std::env::current_exe().context("this program has no place")?;
        let host = own.parent().context("this program is in a folder")?;
        let target = host
            .parent()
            .context("the folder of this program is in the target folder")?;
        Ok(Self {
            firmware: target.join(BOARD_TARGET).join("firmware/firmware"),
            virtual_board: host.join("virtual-board"),
            twin: host.join("twin"),
            hexsense: host.join("hexsense"),
        })
    }

    /// The ELF of the sample path beside others.
    pub fn sample_path_bench(&self) -> PathBuf {
        self.firmware.with_file_name("sample-path-bench")
    }
}
