//! What recording commands share: the board made ready, and what is recorded checked and analysed.

use hexsense_core::facts::BoardFacts;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::{Identity, StreamContent, VERSION, telemetry};

use crate::analysis;
use crate::analysis::results::{self, Analysis};
use crate::campaign::{BoardRecord, Campaign};
use crate::files;
use crate::plan::Purpose;
use crate::replay::{self, replay};
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
pub fn link_load(
    facts: &BoardFacts,
    content: StreamContent,
    rate_hz: u32,
    block: BlockSize,
) -> f64 {
    let limit = facts.max_telemetry_bits_per_s();
    let bits_per_s = telemetry::bits_per_second(content, rate_hz, block, limit);
    f64::from(bits_per_s) / f64::from(limit)
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
        facts: identity.facts,
    }
}

/// Whether the board's sums of a run are, integer for integer, those that its capture gives; how many sums there are.
///
/// # Errors
/// The first sum that differs, and scans that are missing.
pub fn check_sums(campaign: &Campaign, run: &analysis::Run) -> anyhow::Result<usize> {
    let sums = campaign.record(&run.name)?.board_sums;
    for (analyser, sums) in sums.iter().enumerate() {
        replay(sums, &run.capture)
            .map_err(|error| anyhow::anyhow!("run {}, analyser {analyser}, {error}", run.name))?;
    }
    Ok(sums.len() * replay::INTEGERS)
}

/// The calibration runs of a campaign and what their analysis brings forth.
///
/// # Errors
/// A run that is not recorded, what the analysis refuses, and sums of the board that its captures do not give.
pub fn analyse(campaign: &Campaign) -> anyhow::Result<(Vec<analysis::Run>, Analysis)> {
    let runs = campaign.plan.runs_to(Purpose::Calibrate);
    let runs = runs
        .map(|run| campaign.recorded(run))
        .collect::<Result<Vec<_>, _>>()?;
    let analysis = results::analyse(&campaign.geometry, &campaign.sensors, &runs)?;
    let mut sums = 0;
    for run in &runs {
        sums += check_sums(campaign, run)?;
    }
    eprintln!("{sums} harmonic sums of the board: each is the integer that the capture gives");
    Ok((runs, analysis))
}
