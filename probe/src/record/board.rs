//! The board as a recording needs it.

use hexsense_client::{Client, LinkError};
use hexsense_core::facts::BoardFacts;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::{Identity, Refusal, StreamContent, VERSION, telemetry};

use crate::campaign::BoardRecord;
use crate::files;

/// How the board is to stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Streaming {
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Scans that the board takes at a time.
    pub block: BlockSize,
    /// What it streams.
    pub content: StreamContent,
}

impl Streaming {
    /// Share of what the link of the board carries of telemetry that this stream takes at most.
    #[must_use]
    pub fn link_load(&self, board: &BoardFacts) -> f64 {
        let limit = board.max_telemetry_bits_per_s();
        let bits_per_s = telemetry::bits_per_second(self.content, self.rate_hz, self.block, limit);
        f64::from(bits_per_s) / f64::from(limit)
    }
}

/// Makes sure that the board is fit to record a campaign, stops its stream, sets its rate, and returns its identity.
///
/// # Errors
/// What the link reports, a board without its crystal, and a rate that it does not offer.
pub fn ready(client: &mut Client, rate_hz: u32) -> Result<Identity, LinkError> {
    // A recording that was killed leaves its stream on.
    client.stream(StreamContent::default())?;
    let identity = client.identity()?;
    if !client.status()?.crystal {
        return Err(Refusal::NoCrystal.into());
    }
    client.rate(rate_hz)?;
    Ok(identity)
}

/// What is noted of the board.
#[must_use]
pub fn board_record(client: &Client, identity: &Identity) -> BoardRecord {
    let [major, minor, patch] = client.firmware();
    BoardRecord {
        board: files::hex(&identity.board),
        hardware: identity.hardware.to_string(),
        firmware: format!("{major}.{minor}.{patch}"),
        wire: VERSION,
        facts: identity.facts,
        build: identity.build.map(|build| build.to_string()),
    }
}
