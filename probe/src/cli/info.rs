//! `hexsense info`: the identity of the board.

use clap::Args;
use hexsense_core::wire::VERSION;

use super::arguments::Port;
use super::status::key;
use crate::terminal::{self, one_line};
use crate::{board_events, files};
use hexsense_client::Client;

/// Print the identity of the board, its firmware, why it last started and whether it has a key; `hexsense status` prints
/// its state.
#[derive(Args)]
pub struct Info {
    #[command(flatten)]
    port: Port,
}

impl Info {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        Ok(terminal::print(&text(&mut self.port.open()?)?)?)
    }
}

/// What the command prints of a board.
///
/// # Errors
/// What the link reports.
pub fn text(client: &mut Client) -> anyhow::Result<String> {
    let identity = client.identity()?;
    let [major, minor, patch] = client.firmware();
    let board = files::hex(&identity.board);
    let hardware = one_line(&identity.hardware);
    let start = board_events::cause(identity.reset);
    let key = key(client.status()?.provisioned);
    Ok(format!(
        "board          {board} ({hardware})\n\
         firmware       {major}.{minor}.{patch}, wire version {VERSION}\n\
         last start     {start}\n\
         key            {key}\n"
    ))
}
