//! A whole bench for the command line: the twin moves and feels, the fake board measures.

use std::process::Output;

use assert_cmd::Command;
use hexsense_probe::campaign::Campaign;
use hexsense_probe::plan::Plan;

use super::FakeBoard;
use super::line::lockstep;
use super::source::{self, Pins, Source};

pub const GEOMETRY: &str = "an-74tk-200";
pub const SEED: u64 = 7;

/// A folder with a sensor file, a board and a twin.
pub struct Bench {
    pub folder: tempfile::TempDir,
    pub port: String,
    pub control: String,
}

impl Bench {
    /// A bench whose board is changed before it starts.
    pub fn new(change: impl FnOnce(&mut FakeBoard)) -> Self {
        Self::made(|pins| Box::new(pins), change)
    }

    /// A bench whose board measures what `source` makes of the twin's pins.
    pub fn measuring(source: impl FnOnce(Pins) -> Box<dyn Source>) -> Self {
        Self::made(source, |_| {})
    }

    fn made(
        source: impl FnOnce(Pins) -> Box<dyn Source>,
        change: impl FnOnce(&mut FakeBoard),
    ) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(
            folder.path().join("sensors.toml"),
            twin::papers::sensor_file(SEED),
        )
        .unwrap();
        let (pins, control) = source::twin(SEED, GEOMETRY);
        let mut board = FakeBoard::new(source(Pins::connect(&pins)));
        super::key::save(folder.path(), &board.uid);
        change(&mut board);
        Self {
            folder,
            port: lockstep(board),
            control,
        }
    }

    /// `hexsense` in the folder, on the board's port.
    pub fn hexsense(&self, arguments: &[&str]) -> Output {
        self.without_board(&[arguments, &["--port", &self.port]].concat())
    }

    /// `hexsense` in the folder.
    pub fn without_board(&self, arguments: &[&str]) -> Output {
        let output = Command::cargo_bin("hexsense")
            .unwrap()
            .current_dir(self.folder.path())
            .args(arguments)
            .output()
            .unwrap();
        eprintln!(
            "{}{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
        output
    }

    /// `hexsense calibrate` or `verify` with everything it needs.
    pub fn record(&self, command: &str) -> Output {
        self.record_at(command, &[])
    }

    /// The same with more arguments.
    pub fn record_at(&self, command: &str, more: &[&str]) -> Output {
        let base = [
            command,
            "--geometry",
            GEOMETRY,
            "--sensors",
            "sensors.toml",
            "--out",
            "campaign",
        ];
        let rest = ["--twin", self.control.as_str(), "--date", "1780000000"];
        self.hexsense(&[base.as_slice(), rest.as_slice(), more].concat())
    }

    /// Plans the default campaign, with a change.
    pub fn plan(&self, change: impl FnOnce(&mut Plan)) {
        let mut command = Command::cargo_bin("hexsense").unwrap();
        command.current_dir(self.folder.path());
        command
            .args(["plan", "--geometry", GEOMETRY, "--out", "campaign"])
            .assert()
            .success();
        let path = self.folder.path().join("campaign/plan.toml");
        let mut plan = Plan::load(&path).unwrap();
        change(&mut plan);
        std::fs::write(&path, plan.to_toml()).unwrap();
    }

    /// The campaign in its folder.
    pub fn campaign(&self) -> Campaign {
        Campaign::open(&self.folder.path().join("campaign")).unwrap()
    }
}
