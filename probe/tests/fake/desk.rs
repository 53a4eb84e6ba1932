//! A desk for the command line: a board at a port, and a folder with its key.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use hexsense_core::records::CoefficientSet;
use hexsense_probe::coefficient_file;
use serde_json::Value;
use tempfile::TempDir;

use super::FakeBoard;
use super::line::lockstep;
use super::source::{Source, Still};

/// The file with the key of the board of a [`Desk`].
pub const KEY_FILE: &str = "hexsense-66616b6520626f6172642031.key";

/// A folder, and a board at a port.
pub struct Desk {
    pub folder: TempDir,
    pub port: String,
}

impl Desk {
    /// A board with a key, whose file is in the folder.
    pub fn new() -> Self {
        let desk = Self::with(FakeBoard::new(Box::new(Still)));
        super::key::save(desk.folder.path(), &Still.uid());
        desk
    }

    pub fn with(board: FakeBoard) -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
            port: lockstep(board),
        }
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        Command::cargo_bin("hexsense")
            .unwrap()
            .current_dir(self.path())
            .args(arguments)
            .args(["--port", &self.port])
            .output()
            .unwrap()
    }

    /// What a command that must succeed prints.
    pub fn says(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{arguments:?}: {error}");
        String::from_utf8(output.stdout).unwrap()
    }

    pub fn json(&self, command: &str) -> Value {
        serde_json::from_str(&self.says(&[command, "--json"])).unwrap()
    }

    /// The log, whether the board is proven or not.
    fn log(&self) -> Value {
        let output = self.run(&["log", "--json"]);
        serde_json::from_slice(&output.stdout).unwrap()
    }

    /// What a command that must fail says; nothing is printed, and the log stays as it was.
    pub fn refuses(&self, arguments: &[&str], parts: &[&str]) {
        let before = self.log();
        let output = self.run(arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success(), "{arguments:?} succeeded");
        assert!(output.stdout.is_empty() && !error.contains("panicked"));
        for part in parts {
            assert!(error.contains(part), "{part:?} is not in: {error}");
        }
        assert_eq!(self.log(), before, "{arguments:?}");
    }

    /// Uploads the set that was made at `unix_s`; its identity.
    pub fn upload(&self, unix_s: u64) -> String {
        let set = super::set::set(unix_s);
        coefficient_file::save(
            &self.path().join("coefficients.toml"),
            &set,
            &super::set::sources(),
        )
        .unwrap();
        self.says(&["upload", "coefficients.toml"]);
        CoefficientSet::id_of(&super::set::encoded(&set)).to_string()
    }

    pub fn active_id(&self) -> Value {
        self.json("show")["id"].clone()
    }
}
