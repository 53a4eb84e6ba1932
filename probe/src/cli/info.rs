//! `hexsense info`: who the board is.

use clap::Args;
use hexsense_core::wire::VERSION;

use super::arguments::Port;
use super::losses;
use super::status::key;
use crate::files;

/// Print who the board is: its identity, its firmware, why it last started and whether it has a key; `hexsense status`
/// prints how it is.
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
        println!("last start     {}", losses::cause(identity.reset));
        println!("key            {}", key(client.status()?.provisioned));
        Ok(())
    }
}
