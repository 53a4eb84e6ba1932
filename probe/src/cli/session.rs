//! What recording commands share: the board made ready.

use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::{Identity, StreamContent, VERSION, telemetry};

use crate::campaign::BoardRecord;
use crate::files;
use hexsense_client::Client;

/// Makes sure that the board is fit to record, and says who it is.
///
/// # Errors
/// What the link reports, a board without its crystal, and a rate that it does not offer.
pub fn ready(client: &mut Client, rate_hz: u32) -> anyhow::Result<Identity> {
    let identity = client.identity()?;
    if !client.status()?.crystal {
        return Err(hexsense_core::wire::Refusal::NoCrystal.into());
    }
    client.rate(rate_hz)?;
    Ok(identity)
}

/// Share of what the link carries of telemetry that a stream takes at most.
#[must_use]
pub fn link_load(content: StreamContent, rate_hz: u32, block: BlockSize) -> f64 {
    let bits_per_s = telemetry::bits_per_second(content, rate_hz, block);
    f64::from(bits_per_s) / f64::from(telemetry::MAX_BITS_PER_S)
}

/// What the folder notes of the board.
#[must_use]
pub fn board_record(client: &Client, identity: &Identity) -> BoardRecord {
    let [major, minor, patch] = client.firmware();
    BoardRecord {
        board: files::hex(&identity.board),
        hardware: identity.hardware.to_string(),
        firmware: format!("{major}.{minor}.{patch}"),
        wire: VERSION,
    }
}
