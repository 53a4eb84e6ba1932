//! Whether the stated uncertainties are honest: many campaigns, and how often the truth lies inside.
//!
//! Each campaign has a twin of its own seed, the motion bases in turn. For each coefficient the share of campaigns
//! is counted in which the truth lies inside the stated 95 % interval; by chance alone that share scatters by
//! √(0.95·0.05/n), 0.7 % for a thousand campaigns.

use std::sync::atomic::{AtomicU64, Ordering};

use hexsense_probe::analysis::Run;
use hexsense_probe::analysis::results::{Analysis, Measured, analyse};
use hexsense_probe::geometry_file::{GeometryFile, preset_names};
use hexsense_probe::plan::Purpose;
use hexsense_probe::plan::campaign::plan;
use hexsense_probe::sensor_file::SensorFile;
use serde::Serialize;
use twin::truth::Document;

use crate::bench::Laboratory;

/// One coefficient over all campaigns.
#[derive(Debug, Clone, Serialize)]
pub struct Coefficient {
    /// Channel and what of it, as in `ax.gain`.
    pub name: String,
    /// Share of campaigns in which the truth lies inside the 95 % interval.
    pub coverage: f64,
    /// Median of |error| over the expanded uncertainty, k = 2.
    pub median_error_over_u: f64,
    /// Largest error, relative to the truth for gains, in counts for offsets.
    pub worst_error: f64,
}

/// The figures of many campaigns.
#[derive(Debug, Clone, Serialize)]
pub struct Coverage {
    /// Campaigns simulated.
    pub campaigns: u64,
    /// Eighteen coefficients: gain and offset of each channel.
    pub coefficients: Vec<Coefficient>,
}

/// What one campaign says of one coefficient.
struct Outcome {
    inside: bool,
    error_over_u: f64,
    error: f64,
}

/// Plays, records and evaluates the campaign of a seed on a base.
///
/// # Panics
/// When a campaign fails: these are tests.
#[must_use]
pub fn campaign(seed: u64, geometry: &str) -> Analysis {
    let base = GeometryFile::load(geometry).expect("a preset");
    let sensors =
        SensorFile::parse("papers", &twin::papers::sensor_file(seed)).expect("usable papers");
    let mut laboratory = Laboratory::new(seed, &base);
    let plan = plan(&base).expect("room to move");
    let runs = plan
        .runs
        .iter()
        .filter(|run| run.purpose == Purpose::Calibrate);
    let record = |run: &hexsense_probe::plan::Run| {
        laboratory.record(&run.name, &run.program(), run.rest_s.unwrap_or(0.0))
    };
    let runs: Vec<Run> = runs.map(record).collect();
    analyse(&base, &sensors, &runs).expect("a campaign that comes out")
}

/// Simulates `campaigns` campaigns with seeds from `first_seed` on all cores; `done` is told of each that is finished.
#[must_use]
pub fn coverage(campaigns: u64, first_seed: u64, done: impl Fn() + Sync) -> Coverage {
    let next = AtomicU64::new(0);
    let work = || {
        let mut outcomes = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= campaigns {
                return outcomes;
            }
            let names = preset_names();
            let geometry = names[index as usize % names.len()];
            outcomes.push((index, outcomes_of(first_seed + index, geometry)));
            done();
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut all = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let results = workers
            .into_iter()
            .map(|worker| worker.join().expect("a campaign that comes out"));
        results.flatten().collect::<Vec<_>>()
    });
    all.sort_by_key(|(index, _)| *index);
    Coverage {
        campaigns,
        coefficients: summarise(&all),
    }
}

/// Gain and offset of each channel: name and outcome.
fn outcomes_of(seed: u64, geometry: &str) -> Vec<(String, Outcome)> {
    let analysis = campaign(seed, geometry);
    let truth = Document::new(seed, geometry);
    let pairs = analysis.results.channels.iter().zip(&truth.channels);
    pairs
        .flat_map(|(result, truth)| {
            let gain = outcome(&result.gain, truth.gain.truth, truth.gain.truth.abs());
            let offset = outcome(&result.offset, truth.offset.truth, 1.0);
            [
                (format!("{}.gain", result.name), gain),
                (format!("{}.offset", result.name), offset),
            ]
        })
        .collect()
}

fn outcome(measured: &Measured, truth: f64, unit: f64) -> Outcome {
    let error = (measured.estimate - truth).abs();
    Outcome {
        inside: error <= measured.interval_95,
        error_over_u: error / measured.expanded_uncertainty,
        error: error / unit,
    }
}

fn summarise(all: &[(u64, Vec<(String, Outcome)>)]) -> Vec<Coefficient> {
    let Some((_, first)) = all.first() else {
        return Vec::new();
    };
    let column = |index: usize| all.iter().map(move |(_, outcomes)| &outcomes[index].1);
    let summary = |(index, (name, _)): (usize, &(String, Outcome))| {
        let mut ratios: Vec<f64> = column(index).map(|outcome| outcome.error_over_u).collect();
        ratios.sort_by(f64::total_cmp);
        Coefficient {
            name: name.clone(),
            coverage: column(index).filter(|outcome| outcome.inside).count() as f64
                / all.len() as f64,
            median_error_over_u: ratios[ratios.len() / 2],
            worst_error: column(index)
                .map(|outcome| outcome.error)
                .fold(0.0, f64::max),
        }
    };
    first.iter().enumerate().map(summary).collect()
}
