//! `hexsense info`: the identity of the board.

use clap::Args;
use serde_json::json;

use super::arguments::Port;
use super::status::key;
use crate::board_events;
use crate::campaign::BoardRecord;
use crate::record::board::board_record;

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
        let mut client = self.port.open()?;
        let identity = client.identity()?;
        let BoardRecord {
            board,
            hardware,
            firmware,
            wire,
            build,
            ..
        } = board_record(&client, &identity);
        let last_start = board_events::cause(identity.reset);
        let provisioned = client.status()?.provisioned;
        if self.json {
            let document = json!({
                "board": board,
                "hardware": hardware,
                "firmware": firmware,
                "build": build,
                "wire": wire,
                "last_start": last_start,
                "provisioned": provisioned,
            });
            println!("{document}");
            return Ok(());
        }
        let build = build.as_deref().unwrap_or("not known");
        println!("board          {board} ({hardware})");
        println!("firmware       {firmware}, build {build}, wire version {wire}");
        println!("last start     {last_start}");
        println!("key            {}", key(provisioned));
        Ok(())
    }
}
