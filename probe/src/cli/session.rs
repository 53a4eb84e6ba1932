//! What recording commands share: the board made ready, and the runs recorded one after another.

use hexsense::sampling::BlockSize;
use hexsense::wire::{Identity, StreamContent, VERSION, telemetry};

use crate::analysis;
use crate::analysis::results::{self, Analysis};
use crate::campaign::{BoardRecord, Campaign};
use crate::files;
use crate::link::Client;
use crate::motion::Motion;
use crate::plan::{Purpose, Run};
use crate::record::drives::Choice;
use crate::record::{self, Settings};
use crate::replay::{self, replay};

/// Makes sure that the board is fit to record, and says who it is.
///
/// # Errors
/// What the link reports, a board without its crystal, and a rate that it does not offer.
pub fn ready(client: &mut Client, rate_hz: u32) -> anyhow::Result<Identity> {
    let identity = client.identity()?;
    if !client.status()?.crystal {
        return Err(hexsense::wire::Refusal::NoCrystal.into());
    }
    client.rate(rate_hz)?;
    Ok(identity)
}

/// Share of what the link carries of telemetry that a stream takes at most.
#[must_use]
pub fn link_load(content: StreamContent, rate_hz: u32, block: BlockSize) -> f64 {
    let bits_per_s = telemetry::bits_per_second(content, rate_hz, block);
    f64::from(bits_per_s) / f64::from(telemetry::LIMIT_BITS_PER_S)
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
/// Before anything moves, a run that the board or the link cannot do at this rate, and one that is recorded at another;
/// then what the first run that fails reports, with what is safe and how to go on.
pub fn record_all(
    client: &mut Client,
    motion: &mut dyn Motion,
    campaign: &Campaign,
    runs: &[&Run],
    settings: Settings,
) -> anyhow::Result<()> {
    let choices = choices(campaign, runs, settings)?;
    for (index, run) in runs.iter().enumerate() {
        let place = format!("run {} of {}: {}", index + 1, runs.len(), run.name);
        if campaign.is_recorded(&run.name) {
            eprintln!("{place} is recorded already");
            continue;
        }
        let choice = &choices[index];
        eprintln!(
            "{place}, {:.0} s, in blocks of {} scans",
            run.duration_s(),
            choice.block.scans()
        );
        let record = record::record(client, motion, campaign, (run, choice), settings)
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

/// What the board will be asked for in each run.
fn choices(campaign: &Campaign, runs: &[&Run], settings: Settings) -> anyhow::Result<Vec<Choice>> {
    let rate_hz = settings.rate_hz;
    for run in runs.iter().filter(|run| campaign.is_recorded(&run.name)) {
        let recorded = campaign.record(&run.name)?.rate_hz;
        anyhow::ensure!(
            recorded == rate_hz,
            "run {} is recorded at {recorded} Hz, and the runs of a campaign are analysed together: go on with \
             --rate {recorded}, or choose another folder",
            run.name
        );
    }
    let choices = runs
        .iter()
        .map(|run| Choice::new(run, &campaign.sensors, rate_hz, settings.content()));
    Ok(choices.collect::<Result<_, _>>()?)
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
