//! What recording commands share: the board made ready, and the runs recorded one after another.

use hexsense::wire::{Identity, VERSION};

use crate::analysis;
use crate::analysis::results::{self, Analysis};
use crate::campaign::{BoardRecord, Campaign};
use crate::files;
use crate::link::Client;
use crate::motion::Motion;
use crate::plan::{Purpose, Run};
use crate::record::{self, RATE_HZ};

/// Makes sure that the board is fit to record, and says who it is.
///
/// # Errors
/// What the link reports, and a board without its crystal.
pub fn ready(client: &mut Client) -> anyhow::Result<Identity> {
    let identity = client.identity()?;
    if !client.status()?.crystal {
        return Err(hexsense::wire::Refusal::NoCrystal.into());
    }
    client.rate(RATE_HZ)?;
    Ok(identity)
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

/// Records those of `runs` that are not recorded yet.
///
/// # Errors
/// What the first run that fails reports, with what is safe and how to go on.
pub fn record_all(
    client: &mut Client,
    motion: &mut dyn Motion,
    campaign: &Campaign,
    runs: &[&Run],
    values: bool,
) -> anyhow::Result<()> {
    for (index, run) in runs.iter().enumerate() {
        let place = format!("run {} of {}: {}", index + 1, runs.len(), run.name);
        if campaign.is_recorded(&run.name) {
            campaign.record(&run.name)?;
            eprintln!("{place} is recorded already");
            continue;
        }
        eprintln!("{place}, {:.0} s", run.duration_s());
        let record = record::record(client, motion, campaign, run, values)
            .map_err(|error| broken_off(&error.to_string(), campaign, runs, index))?;
        if record.scans_lost > 0 {
            eprintln!(
                "run {}: {} of {} scans were lost on the way",
                run.name, record.scans_lost, record.scans
            );
        }
    }
    Ok(())
}

/// The calibration runs of a campaign and what their analysis brings forth.
///
/// # Errors
/// A run that is not recorded, and what the analysis refuses.
pub fn analyse(campaign: &Campaign) -> anyhow::Result<(Vec<analysis::Run>, Analysis)> {
    let runs = campaign.plan.runs_to(Purpose::Calibrate);
    let runs = runs
        .map(|run| campaign.recorded(run))
        .collect::<Result<Vec<_>, _>>()?;
    let analysis = results::analyse(&campaign.geometry, &campaign.sensors, &runs)?;
    Ok((runs, analysis))
}

/// What happened, what is safe, what to do.
fn broken_off(error: &str, campaign: &Campaign, runs: &[&Run], failed: usize) -> anyhow::Error {
    let folder = campaign.folder.display();
    let complete = match failed.checked_sub(1) {
        Some(last) => format!("{folder} is complete up to run {}", runs[last].name),
        None => format!("{folder} holds no complete run yet"),
    };
    let command: Vec<String> = std::env::args()
        .skip(1)
        .map(|argument| quoted(&argument))
        .collect();
    anyhow::anyhow!(
        "run {name} broke off: {error}\n\
         safe:    nothing on the board has changed, its coefficients are still active; {complete}\n\
         do next: bring the base home, then start again with\n         \
         hexsense {command}\n         \
         which goes on with run {name}",
        name = runs[failed].name,
        command = command.join(" "),
    )
}

fn quoted(argument: &str) -> String {
    if argument.contains(|c: char| c.is_whitespace() || c == '\'' || c == '"') {
        format!("'{}'", argument.replace('\'', r"'\''"))
    } else {
        argument.to_owned()
    }
}
