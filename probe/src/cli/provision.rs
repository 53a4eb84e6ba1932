//! `hexsense provision`: a key for the board, which then takes changes only with this key.

use std::path::PathBuf;

use anyhow::ensure;
use clap::Args;

use super::arguments::{Key, Port};
use super::confirm::confirm;
use crate::{files, key_file};

/// Give the board a key; from then on it takes changes (upload, rollback, factory-reset, another key) only with it.
///
/// Provision a board once, before its first upload, and at a place where the line is safe: the key crosses it unencrypted.
/// When the key file does not exist, hexsense makes it, with a random key; otherwise it uses the key in it. Keep the file
/// safe, and keep a copy: the board never gives the key back, and without the key nothing on the board can be changed.
#[derive(Args)]
pub struct Provision {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    key: Key,
    /// File with the key that the board has now; the key of --key replaces it
    #[arg(long, value_name = "FILE")]
    old_key: Option<PathBuf>,
    /// Take a flash that holds something else for the board without asking
    #[arg(long)]
    yes: bool,
}

impl Provision {
    /// Runs the command.
    ///
    /// # Errors
    /// A board that has a key when no old key is named, files that hold no key, and what the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        let old = self.old_key.as_deref().map(key_file::load).transpose()?;
        let mut client = self.port.open()?;
        let board = files::hex(&client.identity()?.board);
        match (client.status()?.provisioned, &old) {
            (true, None) => anyhow::bail!(
                "board {board} has a key already, and nothing has changed. To replace it, name its file with \
                 --old-key FILE, and a new one with --key FILE"
            ),
            (false, Some(_)) => anyhow::bail!(
                "board {board} has no key that could be replaced; leave --old-key out"
            ),
            _ => {}
        }
        if client.status()?.log_used.is_none() && !self.yes {
            eprintln!(
                "the flash of board {board} for coefficients holds something else, and no record of this firmware"
            );
            confirm(
                "Erase it page by page, as the board needs it?",
                "nothing has changed",
            )?;
        }
        let file = self.key.file.display();
        let new = if self.key.file.exists() {
            self.key.load()?
        } else {
            key_file::create(&self.key.file)?
        };
        ensure!(
            old.as_ref() != Some(&new),
            "{file}: holds the key that the board has; name a file for the new one with --key FILE"
        );
        let sent = client.provision(old.as_ref().unwrap_or(&new), &new);
        sent.map_err(|error| {
            anyhow::anyhow!("{error}\n{file} stays as it is: the same command uses its key again")
        })?;
        println!("board {board} takes changes only with the key in {file} from now on");
        println!("keep this file and a copy of it: the board never gives the key back");
        Ok(())
    }
}
