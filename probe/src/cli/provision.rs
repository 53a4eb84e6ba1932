//! `hexsense provision`: a key for the board, which then takes changes only with this key.

use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::Args;
use hexsense_client::ChangeError;
use hexsense_core::wire::Refusal;

use super::arguments::{Key, Port};
use super::confirm::confirm;
use crate::fresh_key::FreshKey;
use crate::terminal::{say, tell};
use crate::{files, key_file};

/// Give the board a key; from then on it takes changes (upload, rollback, factory-reset, another key) only with it.
///
/// Provision a board once, before its first upload, and at a place where the line is safe: the key crosses it unencrypted.
/// hexsense makes a random key for each provisioning and its file, by default hexsense-UNIQUEID.key with the board's unique
/// id. Keep the file safe, and keep a copy: the board never gives the key back, and without the key nothing on the board can
/// be changed. A key that exists is never sent: where the file is there already, this command says what that can mean.
#[derive(Args)]
pub struct Provision {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    key: Key,
    /// File with the key that the board has now; the new key replaces it
    #[arg(long, value_name = "FILE")]
    old_key: Option<PathBuf>,
    /// Go on where the key file is there already: it stays beside the new one under another name
    #[arg(long)]
    new_key: bool,
    /// Take a flash that holds something else for the board without asking
    #[arg(long)]
    yes: bool,
}

impl Provision {
    /// Runs the command.
    ///
    /// # Errors
    /// A board that has a key when no old key is named, a key file that is there already, and what the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        let old = self.old_key.as_deref().map(key_file::load).transpose()?;
        let mut client = self.port.open()?;
        let board = client.identity()?.board;
        let id = files::hex(&board);
        let status = client.status()?;
        match (status.provisioned, &old) {
            _ if status.key_damaged => return Err(Refusal::KeyDamaged.into()),
            (true, None) => bail!(
                "board {id} has a key already, and nothing has changed. To replace it, name its file with --old-key FILE, \
                 and a new one with --key FILE; `hexsense info --key FILE` says whether a file has its key"
            ),
            (false, Some(_)) => {
                bail!("board {id} has no key that could be replaced; leave --old-key out")
            }
            _ => {}
        }
        let file = self.key.file(&board);
        if file.symlink_metadata().is_ok() && !self.new_key {
            bail!(self.is_there(&file, &id, old.is_some()));
        }
        if status.log_used.is_none() && !self.yes {
            tell!(
                "the flash of board {id} for coefficients holds something else, and no record of this firmware"
            );
            confirm(
                "Erase it page by page, as the board needs it?",
                "nothing has changed",
            )?;
        }
        let fresh = FreshKey::make(&file)?;
        let sent = client.provision(old.as_ref().unwrap_or(&fresh.key), &fresh.key);
        if let Err(error) = sent {
            return Err(told(error, fresh)?);
        }
        let file = file.display();
        client.prove(&fresh.key).map_err(|error| {
            anyhow!("the board says that it has the key in {file}, but does not prove it: {error}")
        })?;
        say!(
            "board {id} takes changes only with the key in {file} from now on, and proves that it has it"
        )?;
        say!("keep this file and a copy of it: the board never gives the key back")?;
        if let Some(before) = fresh.before {
            say!("the key file from before is {}", before.display())?;
        }
        Ok(())
    }

    /// What it means that there is a key already.
    fn is_there(&self, file: &Path, id: &str, replaces: bool) -> String {
        let (file, port) = (file.display(), &self.port.port);
        let never = format!("{file}: is there already, and a key that exists is never sent");
        if replaces {
            return format!(
                "{never}; name another file for the new key with --key FILE, or let this one stay beside it under another \
                 name with --new-key"
            );
        }
        format!(
            "{never}. If it is the key of board {id}, this board had a key, but what answers on {port} says that it has \
             none. Then another board or program answers, or the line changes what the board says, or the board's flash \
             was erased, with its sets and its log. Find out which, on a line that you trust: `hexsense log --port {port}` \
             shows whether the log is there. Give the board a fresh key with --new-key; the file then stays beside the new \
             one under another name"
        )
    }
}

/// What became of the key, and of its file.
fn told(error: ChangeError, fresh: FreshKey) -> anyhow::Result<anyhow::Error> {
    if let ChangeError::During { port, .. } = &error {
        let file = fresh.file.display();
        let mut text = format!(
            "{error}\n{file} holds the new key: `hexsense info --key {file} --port {port}` says whether the board has it"
        );
        if let Some(before) = &fresh.before {
            text += &format!(". The key file from before is {}", before.display());
        }
        return Ok(anyhow!(text));
    }
    let unused = fresh.withdraw()?;
    Ok(anyhow!(
        "{error}\nthe new key is not in use, and stays in {}; the same command makes another",
        unused.display()
    ))
}
