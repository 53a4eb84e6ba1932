//! The virtual bench: twin, board and host tool, started and used as a user does it.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Context;
use serde_json::Value;

use crate::power::Power;
use crate::process::{Beside, checked, output};
use crate::programs::Program;

/// The file with the board's key, in the folder of a bench.
pub const KEY_FILE: &str = "board.key";
/// Name of the run that the twin keeps the truth of.
const HELD_OUT: &str = "held-out";
/// Date of a campaign, s since 1970: fixed, so that a seed gives the same bytes every time.
pub const DATE: u64 = 1_790_000_000;

/// A bench for one seed, base and folder.
pub struct VirtualBench<'a> {
    /// Seed of everything drawn.
    pub seed: u64,
    /// Geometry preset or file.
    pub geometry: &'a str,
    /// Where everything is written.
    pub folder: &'a Path,
}

impl VirtualBench<'_> {
    /// The coefficients of the campaign.
    pub fn coefficients(&self) -> PathBuf {
        self.campaign().join("coefficients.toml")
    }

    /// The campaign's folder.
    pub fn campaign(&self) -> PathBuf {
        self.folder.join("campaign")
    }

    /// The file with the true movement of the held-out run.
    pub fn truth_log(&self) -> PathBuf {
        self.folder.join("truth.csv")
    }

    /// The laboratory's sensor file; [`VirtualBench::papers`] writes it.
    fn sensors(&self) -> PathBuf {
        self.folder.join("sensors.toml")
    }

    fn twin_command(&self, command: &str) -> anyhow::Result<Command> {
        let mut twin = Command::new(Program::Twin.path()?);
        twin.args([
            command,
            "--seed",
            &self.seed.to_string(),
            "--geometry",
            self.geometry,
        ]);
        Ok(twin)
    }

    /// Starts the twin; it says its addresses `pins` and `control`.
    pub fn twin(&self) -> anyhow::Result<Beside> {
        let mut twin = self.twin_command("serve")?;
        twin.args([
            "--pins",
            "127.0.0.1:0",
            "--control",
            "127.0.0.1:0",
            "--truth-run",
            HELD_OUT,
        ]);
        Beside::start(twin.arg("--truth-log").arg(self.truth_log()))
    }

    /// Writes the sensor file.
    pub fn papers(&self) -> anyhow::Result<()> {
        checked(
            self.twin_command("papers")?
                .arg("--out")
                .arg(self.sensors()),
        )
    }

    /// The twin's truth about the sensors, as it prints it.
    pub fn truth(&self) -> anyhow::Result<Value> {
        let text = output(self.twin_command("truth")?.arg("--json"))?;
        serde_json::from_str(&text).context("the twin's truth is not JSON")
    }

    /// Switches the board on; it says its address `link`. Dropping it pulls the plug.
    pub fn board(&self, twin: &Beside) -> anyhow::Result<Beside> {
        self.board_on(twin, None)
    }

    /// The same on a link of this address.
    pub fn board_on(&self, twin: &Beside, link: Option<&str>) -> anyhow::Result<Beside> {
        let pins = format!("tcp:{}", twin.address("pins")?);
        let power = Power {
            link,
            pins: Some(&pins),
            ..Power::default()
        };
        power.on(Program::Firmware, self.folder)
    }

    /// `hexsense calibrate` or `hexsense verify`, `later_s` after the start of the campaign.
    pub fn drive(
        &self,
        command: &str,
        board: &Beside,
        twin: &Beside,
        later_s: u64,
    ) -> anyhow::Result<Command> {
        let mut hexsense = self.hexsense(command, board)?;
        hexsense.args([
            "--geometry",
            self.geometry,
            "--twin",
            twin.address("control")?,
        ]);
        hexsense.args(["--date", &(DATE + later_s).to_string()]);
        hexsense
            .arg("--sensors")
            .arg(self.sensors())
            .arg("--out")
            .arg(self.campaign());
        Ok(hexsense)
    }

    /// The file with the board's key.
    fn key(&self) -> PathBuf {
        self.folder.join(KEY_FILE)
    }

    /// Gives a new board its key.
    pub fn provision(&self, board: &Beside) -> anyhow::Result<()> {
        let mut hexsense = self.hexsense("provision", board)?;
        checked(hexsense.arg("--key").arg(self.key()))
    }

    /// `hexsense calibrate` of the campaign that broke off, from its folder alone.
    pub fn resume(&self, board: &Beside, twin: &Beside) -> anyhow::Result<Command> {
        let mut hexsense = self.hexsense("calibrate", board)?;
        hexsense.arg("--resume").arg(self.campaign());
        hexsense.args(["--twin", twin.address("control")?]);
        Ok(hexsense)
    }

    /// `hexsense upload` of the campaign's coefficients.
    pub fn upload(&self, board: &Beside) -> anyhow::Result<Command> {
        let mut hexsense = self.hexsense("upload", board)?;
        hexsense.arg("--key").arg(self.key()).arg(self.campaign());
        Ok(hexsense)
    }

    /// Identity of the active set.
    pub fn active_id(&self, board: &Beside) -> anyhow::Result<String> {
        let text = output(self.hexsense("show", board)?.arg("--json"))?;
        let shown: Value =
            serde_json::from_str(&text).context("`hexsense show --json` printed no JSON")?;
        shown["id"]
            .as_str()
            .map(str::to_owned)
            .context("`hexsense show` names no set")
    }

    /// `hexsense COMMAND` on the board's port.
    pub fn hexsense(&self, command: &str, board: &Beside) -> anyhow::Result<Command> {
        let mut hexsense = Command::new(Program::HostTool.path()?);
        hexsense.args([command, "--port", board.address("link")?]);
        Ok(hexsense)
    }
}
