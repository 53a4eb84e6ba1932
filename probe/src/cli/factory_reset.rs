//! `hexsense factory-reset`: all coefficient sets are erased.

use anyhow::bail;
use clap::Args;

use super::arguments::{Key, Port};
use super::confirm::confirm;
use super::history::table;
use crate::files;
use crate::terminal::{self, say, tell};

/// Erase all coefficient sets that the board keeps. It keeps measuring without coefficients; its key and its log stay.
///
/// The sets are printed first, and then `yes` must be typed; scripts give --yes. The board cannot bring erased sets back;
/// they can be uploaded again from the folders of their campaigns. The board takes the reset only with its key.
#[derive(Args)]
pub struct FactoryReset {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    key: Key,
    /// Erase without asking
    #[arg(long)]
    yes: bool,
}

impl FactoryReset {
    /// Runs the command.
    ///
    /// # Errors
    /// An answer that is not yes, no terminal to ask at, a file that holds no key, and what the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        let mut client = self.port.open()?;
        let board = client.identity()?.board;
        let key = self.key.load(&board)?;
        let board = files::hex(&board);
        let history = client.history()?;
        tell!("board {board} keeps {}", sets(history.len()));
        if !history.is_empty() {
            terminal::tell_text(&table(&history, client.active_set()?));
        }
        if !self.yes {
            confirm("Erase them all?", "nothing was erased")?;
        }
        let erased = client.factory_reset(&key)?;
        if client.active_set()?.is_some() || !client.history()?.is_empty() {
            bail!(
                "the board still keeps sets after the reset; see `hexsense history` and try again"
            );
        }
        say!(
            "erased {}; the board has no coefficients now",
            sets(erased.len())
        )?;
        say!("its key stays, and so does its log, which has the reset as its last entry")?;
        Ok(())
    }
}

fn sets(count: usize) -> String {
    match count {
        0 => "no coefficient set".to_owned(),
        1 => "1 coefficient set".to_owned(),
        count => format!("{count} coefficient sets"),
    }
}
