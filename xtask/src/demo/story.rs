//! The programs of the demo and their order.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Context;
use serde_json::Value;

use super::Arguments;
use crate::build::Parts;
use crate::process::{Beside, checked, output};

/// Name of the run that the twin keeps the truth of.
const HELD_OUT: &str = "held-out";
/// Date of the campaign, s since 1970: fixed, so that a seed gives the same bytes every time.
const DATE: u64 = 1_790_000_000;
/// From the start of the campaign to the start of the s: longer than a campaign takes.
pub const VERIFY_AFTER: u64 = 600;

/// What is there when the story is over.
pub struct Told {
    /// The campaign's folder.
    pub campaign: PathBuf,
    /// The true movement of the held-out run, from the twin.
    pub truth_log: PathBuf,
    /// The twin's truth about the sensors, as it prints it.
    pub truth: Value,
    /// Identity of the set before the power cut.
    pub uploaded_id: String,
    /// Identity of the set after it.
    pub read_back_id: String,
}

/// Drives everything; progress goes to standard error.
pub fn tell(parts: &Parts, arguments: &Arguments, folder: &Path) -> anyhow::Result<Told> {
    let bench = Bench {
        parts,
        arguments,
        folder,
    };
    let twin = bench.twin()?;
    let (pins, control) = (twin.address("pins")?, twin.address("control")?);
    let campaign = folder.join("campaign");
    let sensors = folder.join("sensors.toml");
    bench.papers(&sensors)?;

    let board = bench.board(pins)?;
    let port = board.address("link")?;
    step("the firmware runs; calibrating");
    let place = [campaign.as_os_str(), sensors.as_os_str()];
    bench.hexsense(
        "calibrate",
        port,
        &["--twin", control, "--date", &DATE.to_string()],
        place,
    )?;
    step("uploading");
    checked(
        Command::new(&parts.hexsense)
            .args(["upload", "--port", port])
            .arg(&campaign),
    )?;
    let uploaded_id = bench.active_id(port)?;
    drop(board);

    step("power off, power on");
    let board = bench.board(pins)?;
    let port = board.address("link")?;
    let read_back_id = bench.active_id(port)?;
    step("verifying on a movement that nothing was fitted to");
    let date = (DATE + VERIFY_AFTER).to_string();
    bench.hexsense("verify", port, &["--twin", control, "--date", &date], place)?;
    let truth_log = bench.truth_log();
    let truth = bench.truth()?;
    Ok(Told {
        campaign,
        truth_log,
        truth,
        uploaded_id,
        read_back_id,
    })
}

fn step(what: &str) {
    eprintln!("— {what}");
}

struct Bench<'a> {
    parts: &'a Parts,
    arguments: &'a Arguments,
    folder: &'a Path,
}

impl Bench<'_> {
    fn seeded(&self, command: &str) -> Command {
        let mut twin = Command::new(&self.parts.twin);
        twin.args([
            command,
            "--seed",
            &self.arguments.seed.to_string(),
            "--geometry",
            &self.arguments.geometry,
        ]);
        twin
    }

    fn twin(&self) -> anyhow::Result<Beside> {
        let mut twin = self.seeded("serve");
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

    fn truth_log(&self) -> PathBuf {
        self.folder.join("truth.csv")
    }

    fn papers(&self, sensors: &Path) -> anyhow::Result<()> {
        checked(self.seeded("papers").arg("--out").arg(sensors))
    }

    fn truth(&self) -> anyhow::Result<Value> {
        let text = output(self.seeded("truth").arg("--json"))?;
        serde_json::from_str(&text).context("the twin's truth is not JSON")
    }

    fn board(&self, pins: &str) -> anyhow::Result<Beside> {
        let mut board = Command::new(&self.parts.virtual_board);
        board
            .arg("--elf")
            .arg(&self.parts.firmware)
            .arg("--flash")
            .arg(self.folder.join("flash.bin"));
        board.args([
            "--link",
            "lockstep:127.0.0.1:0",
            "--pins",
            &format!("tcp:{pins}"),
        ]);
        let log = self.folder.join("board.log");
        let log = std::fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(&log);
        Beside::start(board.stderr(log.context("cannot write the board's log")?))
    }

    /// `hexsense COMMAND` with the base, the sensor file and a folder.
    fn hexsense(
        &self,
        command: &str,
        port: &str,
        options: &[&str],
        [out, sensors]: [&std::ffi::OsStr; 2],
    ) -> anyhow::Result<()> {
        let mut hexsense = Command::new(&self.parts.hexsense);
        hexsense
            .args([
                command,
                "--port",
                port,
                "--geometry",
                &self.arguments.geometry,
            ])
            .args(options);
        checked(hexsense.arg("--sensors").arg(sensors).arg("--out").arg(out))
    }

    fn active_id(&self, port: &str) -> anyhow::Result<String> {
        let text =
            output(Command::new(&self.parts.hexsense).args(["show", "--json", "--port", port]))?;
        let shown: Value =
            serde_json::from_str(&text).context("`hexsense show --json` printed no JSON")?;
        shown["id"]
            .as_str()
            .map(str::to_owned)
            .context("`hexsense show` names no set")
    }
}
