//! The only place where estimate and truth meet.

use anyhow::{Context, ensure};
use hexsense_core::channel::{INERTIAL, JACKS, NAMES};
use hexsense_probe::analysis::RecordedRun;
use hexsense_probe::analysis::held_out::{ChannelVerdict, HeldOut, Signals, compare, held_out};
use hexsense_probe::analysis::results::Results;
use hexsense_probe::campaign::Campaign;
use hexsense_probe::coefficient_file;
use hexsense_probe::plan::Purpose;
use hexsense_probe::replay::{INTEGERS, first_wrong_values, replay};
use serde::Serialize;
use serde_json::Value;

use super::alignment::{Alignment, TruthLog, align};
use super::story::{Told, VERIFY_AFTER_S};

/// Everything that was compared.
pub struct Judged {
    /// The results of the campaign, nine channels.
    pub results: Results,
    /// The nine channels of the held-out movement against the truth.
    pub held_out: Vec<ChannelVerdict>,
    /// Scans taken and lost in all runs.
    pub samples: Samples,
    /// What the host computed again from the captures.
    pub replay: Replay,
}

/// What the host computed again from the captures, bit for bit.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Replay {
    /// Harmonic sums that the board reported in all runs.
    pub sums: usize,
    /// Whether the captures give every one of them.
    pub sums_equal: bool,
    /// Calibrated values that the board streamed on the held-out movement.
    pub values: usize,
    /// Whether its counts and its set give every one of them.
    pub values_equal: bool,
}

/// Scans of all runs.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Samples {
    /// Scans in the captures.
    pub taken: u64,
    /// Scans that the board or the link lost.
    pub lost: u64,
}

impl Replay {
    /// Whether there was something to compare, and all of it is equal.
    pub fn holds(&self) -> bool {
        self.sums > 0 && self.sums_equal && self.values > 0 && self.values_equal
    }
}

/// Compares what the host tool found with what the twin knows.
pub fn judge(told: &Told) -> anyhow::Result<Judged> {
    let campaign = Campaign::open(&told.campaign)?;
    let results: Results = read(&told.campaign.join("results.json"))?;
    let run = campaign
        .plan
        .runs
        .iter()
        .find(|run| run.purpose == Purpose::Verify)
        .context("the plan has no held-out run")?;
    let run = campaign.recorded(run)?;
    let seen = held_out(&campaign.geometry, &campaign.sensors, &run, &results)?;
    let log = TruthLog::parse(&std::fs::read_to_string(&told.truth_log)?)?;
    let alignment = place(&campaign, &run, &seen, &log)?;
    let held_out = against_truth(&seen, &log, alignment, &results);
    Ok(Judged {
        results,
        held_out,
        samples: samples(&campaign)?,
        replay: replay_all(&campaign, &run)?,
    })
}

/// Sums the captures again, and calibrates the counts of the held-out run again.
fn replay_all(campaign: &Campaign, held_out: &RecordedRun) -> anyhow::Result<Replay> {
    let (mut sums, mut sums_equal) = (0, true);
    for run in &campaign.plan.runs {
        let capture = campaign.capture(&run.name)?;
        for board in &campaign.record(&run.name)?.board_sums {
            sums += INTEGERS;
            sums_equal &= replay(board, &capture).is_ok();
        }
    }
    let (set, _) = coefficient_file::load(&campaign.folder.join("coefficients.toml"))?;
    let values = held_out.capture.values.as_deref().unwrap_or_default();
    Ok(Replay {
        sums,
        sums_equal,
        values: values.len() * INERTIAL,
        values_equal: first_wrong_values(&held_out.capture, &set).is_none(),
    })
}

/// Reads a JSON file of the campaign.
fn read<T: serde::de::DeserializeOwned>(path: &std::path::Path) -> anyhow::Result<T> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    serde_json::from_str(&text)
        .with_context(|| format!("{} is not what it should be", path.display()))
}

/// Where the values of the held-out run lie in the twin's time.
fn place(
    campaign: &Campaign,
    run: &RecordedRun,
    seen: &HeldOut,
    log: &TruthLog,
) -> anyhow::Result<Alignment> {
    let transducers = campaign.sensors.transducers(&campaign.geometry.geometry);
    let displacements_m = |counts: &[f64; JACKS]| {
        std::array::from_fn(|jack| transducers.displacement_m(jack, counts[jack]))
    };
    let rows: Vec<[f64; JACKS]> = seen.jacks.iter().map(displacements_m).collect();
    align(&rows, seen.group as f64 / f64::from(run.rate_hz), log)
}

/// The verdict of [`compare`] with the twin's truth as reference.
fn against_truth(
    seen: &HeldOut,
    log: &TruthLog,
    alignment: Alignment,
    results: &Results,
) -> Vec<ChannelVerdict> {
    let time_s = |index: usize| alignment.start_s + index as f64 * alignment.period_s;
    let known = |index: &usize| log.at(time_s(*index), 0).is_some();
    let indices: Vec<usize> = (0..seen.after[0].len()).filter(known).collect();
    let pick = |signals: &Signals| -> Signals {
        signals
            .each_ref()
            .map(|values| indices.iter().map(|index| values[*index]).collect())
    };
    let truth: Signals = core::array::from_fn(|channel| {
        indices
            .iter()
            .filter_map(|index| log.at(time_s(*index), channel))
            .collect()
    });
    compare(
        &truth,
        &pick(&seen.after),
        &pick(&seen.before),
        results,
        VERIFY_AFTER_S as f64,
    )
}

fn samples(campaign: &Campaign) -> anyhow::Result<Samples> {
    let mut samples = Samples { taken: 0, lost: 0 };
    for run in &campaign.plan.runs {
        let record = campaign.record(&run.name)?;
        samples.taken += record.scans;
        samples.lost += record.scans_lost;
    }
    Ok(samples)
}

/// The truth of the nine channels: offset in counts and gain in unit per count.
pub fn truths(told: &Told) -> anyhow::Result<[(f64, f64); INERTIAL]> {
    let channels = told.truth["channels"]
        .as_array()
        .context("the twin's truth has no channels")?;
    ensure!(
        channels.len() == INERTIAL,
        "the twin's truth has {} channels, not {INERTIAL}",
        channels.len()
    );
    let mut truths = [(0.0, 0.0); INERTIAL];
    for ((truth, channel), name) in truths.iter_mut().zip(channels).zip(NAMES) {
        ensure!(
            channel["name"] == name,
            "the twin's truth has {} where {name} should be",
            channel["name"]
        );
        let number = |value: &Value| value["truth"].as_f64().context("a truth that is no number");
        *truth = (number(&channel["offset"])?, number(&channel["gain"])?);
    }
    Ok(truths)
}
