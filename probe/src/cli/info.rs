//! `hexsense info`: the identity of the board.

use clap::Args;
use serde_json::json;

use super::arguments::{Key, Port};
use super::proven::Proven;
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
///
/// With its key at hand the board proves that it is the board: `board proven`. The proof covers its unique id, its build,
/// its active set and the number of its changes.
#[derive(Args)]
pub struct Info {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    key: Key,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Info {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports, and a board that does not have the key at hand.
    pub fn run(self) -> anyhow::Result<()> {
        let mut client = self.port.open()?;
        let proven = Proven::of(&mut client, &self.key)?;
        terminal::print(&text(&mut client, self.json, &proven)?)?;
        proven.check()
    }
}

/// What the command prints of a board.
///
/// # Errors
/// What the link reports.
pub fn text(client: &mut Client, json: bool, proven: &Proven) -> anyhow::Result<String> {
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
    let status = client.status()?;
    if json {
        let document = json!({
            "board": board,
            "hardware": hardware,
            "firmware": firmware,
            "build": build,
            "wire": wire,
            "last_start": last_start,
            "provisioned": status.provisioned,
            "key_damaged": status.key_damaged,
            "proven": proven.is_proven(),
        });
        return Ok(format!("{document}\n"));
    }
    let build = build.as_deref().unwrap_or("not known");
    let (hardware, key, proof) = (one_line(&hardware), key(&status), proven.line());
    Ok(format!(
        "board          {board} ({hardware})\n\
         firmware       {firmware}, build {build}, wire version {wire}\n\
         last start     {last_start}\n\
         key            {key}\n\
         proof          {proof}\n"
    ))
}
