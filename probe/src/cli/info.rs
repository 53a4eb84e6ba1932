//! `hexsense info`: the identity of the board.

use clap::Args;
use serde_json::json;

use super::arguments::Port;
use super::status::key;
use crate::board_events;
use crate::campaign::BoardRecord;
use crate::record::board::board_record;
use crate::terminal::{self, one_line};
use hexsense_client::Client;

/// Print the identity of the board, its firmware, why it last started and whether it has a key; `hexsense status` prints
/// its state.
///
/// The build is a hash that the board computes of the code in its flash and its version: two boards with one build run the
/// same firmware. Coefficient sets and the entries of the log name it.
#[derive(Args)]
pub struct Info {
    #[command(flatten)]
    port: Port,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Info {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        Ok(terminal::print(&text(&mut self.port.open()?, self.json)?)?)
    }
}

/// What the command prints of a board.
///
/// # Errors
/// What the link reports.
pub fn text(client: &mut Client, json: bool) -> anyhow::Result<String> {
    let identity = client.identity()?;
    let BoardRecord {
        board,
        hardware,
        firmware,
        wire,
        build,
        ..
    } = board_record(client, &identity);
    let last_start = board_events::cause(identity.reset);
    let provisioned = client.status()?.provisioned;
    if json {
        let document = json!({
            "board": board,
            "hardware": hardware,
            "firmware": firmware,
            "build": build,
            "wire": wire,
            "last_start": last_start,
            "provisioned": provisioned,
        });
        return Ok(format!("{document}\n"));
    }
    let build = build.as_deref().unwrap_or("not known");
    let (hardware, key) = (one_line(&hardware), key(provisioned));
    Ok(format!(
        "board          {board} ({hardware})\n\
         firmware       {firmware}, build {build}, wire version {wire}\n\
         last start     {last_start}\n\
         key            {key}\n"
    ))
}
