//! The line of the promise `key`: changes that are held back on it, and boards that say they have no key or have another.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::ensure;
use hexsense_core::records::MAX_ENCODED;
use hexsense_core::wire::{Refusal, Request, Response};
use hexsense_probe::files;

use super::{NEW_KEY, STRANGER, Trial};
use crate::bench::Bench;
use crate::key_holder::{Account, pieces};
use crate::line::Line;
use crate::power::Power;
use crate::programs::Program;

impl Trial {
    /// Changes that arrive after the board has proven itself.
    pub(super) fn held_back(&mut self) -> anyhow::Result<()> {
        self.bench.restore("before")?;
        let mut board = self.bench.on(&[])?;
        let line = &mut board.line;
        for act in self.acts(&NEW_KEY)? {
            let held = self.key_holder.tagged(line, act)?;
            prove(line)?;
            let is_right = |refusal| refusal == Refusal::NoChallenge;
            self.outcome.refused(line, &held, is_right)?;
        }
        let mut room = [0; MAX_ENCODED];
        let set = self.random.set(self.key_holder.board);
        let encoded = set.encode(&mut room)?;
        self.key_holder.begin(line, encoded)?;
        for piece in pieces(encoded) {
            line.order(&piece)?;
        }
        prove(line)?;
        let is_right = |refusal| refusal == Refusal::NoUpload;
        self.outcome
            .refused(line, &Request::UploadCommit, is_right)?;
        let found = Account::read(line)?;
        self.outcome.check(found == self.account, || {
            format!("the account has become {found:?}")
        });
        Ok(())
    }

    /// An erased chip with the id of the board says that it has no key, and a board with another key answers.
    pub(super) fn lying_board(&mut self) -> anyhow::Result<()> {
        let file = self.bench.folder().join("board.key");
        let digits = files::hex(&self.key_holder.key.0);
        for (case, command) in [
            ("erased", "provision"),
            ("erased", "info"),
            ("rekeyed", "info"),
        ] {
            let elsewhere = Bench::new("faults/key-elsewhere", 7)?;
            if case == "rekeyed" {
                let mut board = elsewhere.on(&[])?;
                let mut stranger = self.somebody(&STRANGER);
                stranger.provision(&mut board.line)?;
            }
            key_file(&file, &digits)?;
            let board = elsewhere.start(&Power::default())?;
            let mut tool = Command::new(Program::HostTool.path()?);
            tool.args([command, "--port", board.address("link")?])
                .arg("--key")
                .arg(&file);
            let output = tool.output()?;
            drop(board);
            self.outcome.inject();
            let provisioned = elsewhere.on(&[])?.line.status()?.provisioned;
            let held = !output.status.success() && provisioned == (case == "rekeyed");
            self.outcome.check(held, || {
                format!("`hexsense {command}` trusts a board that was {case}")
            });
            let same = fs::read_to_string(&file)?.trim() == digits;
            self.outcome
                .check(same, || "the key file has changed".to_owned());
        }
        Ok(())
    }
}

fn prove(line: &mut Line) -> anyhow::Result<()> {
    let proof = line.ask(&Request::Prove { challenge: [9; 32] })?;
    ensure!(
        matches!(proof, Response::Proof { .. }),
        "no proof but {proof:?}"
    );
    Ok(())
}

/// A key file as hexsense writes it.
fn key_file(path: &Path, digits: &str) -> anyhow::Result<()> {
    fs::write(path, format!("{digits}\n"))?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(path, fs::Permissions::from_mode(0o600))?;
    }
    Ok(())
}
