//! `hexsense info`: the identity of the board.

use clap::Args;
use hexsense_core::wire::VERSION;

use super::arguments::Port;
use super::status::key;
use crate::{board_events, files};

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
        let mut client = self.port.open()?;
        let identity = client.identity()?;
        let [major, minor, patch] = client.firmware();
        println!(
            "board          {} ({})",
            files::hex(&identity.board),
            identity.hardware
        );
        println!(
            "firmware       {major}.{minor}.{patch}, wire version {}",
            VERSION
        );
        println!("last start     {}", board_events::cause(identity.reset));
        println!("key            {}", key(client.status()?.provisioned));
        Ok(())
    }
}
