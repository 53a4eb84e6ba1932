//! Whether the stated uncertainties are honest: many campaigns, and how often the truth lies inside.
//!
//! Each campaign has a twin of its own seed, the motion bases in turn. For each coefficient the share of campaigns
//! is counted in which the truth lies inside the stated 95 % interval; by chance alone that share scatters by
//! √(0.95·0.05/n), 0.7 % for a thousand campaigns.

use std::sync::atomic::{AtomicU64, Ordering};

use hexsense::channel::Triad;
use hexsense_probe::analysis::results::{Analysis, Measured, analyse};
use hexsense_probe::analysis::{AnalysisError, Run};
use hexsense_probe::geometry_file::{GeometryFile, preset_names};
use hexsense_probe::plan::Purpose;
use hexsense_probe::plan::campaign::plan;
use hexsense_probe::sensor_file::SensorFile;
use serde::{Deserialize, Serialize};
use twin::sheet::TRIADS;
use twin::truth::{Document, mean_delay_s};

use crate::bench::{Laboratory, Movement};

/// One coefficient over all campaigns.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Coefficient {
    /// Channel or triad and what of it: `ax.gain`, `ax.offset`, `ax.y` (counts of ay in the value of ax), `linear.delay`.
    pub name: String,
    /// Share of campaigns in which the truth lies inside the 95 % interval.
    pub coverage: f64,
    /// Median of |error| over the expanded uncertainty, k = 2.
    pub median_error_over_u: f64,
    /// Largest |error| over the expanded uncertainty.
    pub worst_error_over_u: f64,
}

/// The figures of many campaigns.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Coverage {
    /// Campaigns simulated.
    pub campaigns: u64,
    /// Offset and row of the matrix of each channel, then the delay of each triad: 39.
    pub coefficients: Vec<Coefficient>,
}

/// What one campaign says of one coefficient.
struct Outcome {
    inside: bool,
    error_over_u: f64,
}

/// A motion base and its campaign, made once for all seeds.
pub struct Site {
    base: GeometryFile,
    movements: Vec<Movement>,
}

impl Site {
    /// The preset of this name with its default campaign.
    ///
    /// # Panics
    /// When there is no such preset: these are tests.
    #[must_use]
    pub fn new(geometry: &str) -> Self {
        let base = GeometryFile::load(geometry).expect("a preset");
        let plan = plan(&base).expect("room to move");
        let movements = plan
            .runs_to(Purpose::Calibrate)
            .map(|run| Movement::new(&run.name, run.program(), run.rest_s, &base))
            .collect();
        Self { base, movements }
    }

    /// Plays, records and evaluates the campaign of a seed; `papers` is the sensor file.
    ///
    /// # Errors
    /// [`AnalysisError`] when the campaign does not come out.
    ///
    /// # Panics
    /// When the twin does not do as it is told or the papers are not usable: these are tests.
    pub fn campaign(&self, seed: u64, papers: &str) -> Result<Analysis, AnalysisError> {
        let sensors = SensorFile::parse("papers", papers).expect("usable papers");
        let mut laboratory = Laboratory::new(seed, &self.base);
        let movements = self.movements.iter();
        let runs: Vec<Run> = movements
            .map(|movement| laboratory.record(movement))
            .collect();
        analyse(&self.base, &sensors, &runs)
    }
}

/// Simulates `campaigns` campaigns with seeds from `first_seed` on all cores; `done` is told of each that is finished.
#[must_use]
pub fn coverage(campaigns: u64, first_seed: u64, done: impl Fn() + Sync) -> Coverage {
    let sites: Vec<Site> = preset_names().into_iter().map(Site::new).collect();
    let next = AtomicU64::new(0);
    let work = || {
        let mut outcomes = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= campaigns {
                return outcomes;
            }
            let site = &sites[index as usize % sites.len()];
            outcomes.push((index, outcomes_of(first_seed + index, site)));
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

/// Offsets, matrix elements and delays: name and outcome of each.
fn outcomes_of(seed: u64, site: &Site) -> Vec<(String, Outcome)> {
    let results = site
        .campaign(seed, &twin::papers::sensor_file(seed))
        .expect("a campaign that comes out")
        .results;
    let truth = Document::new(seed, &site.base.name);
    let mut outcomes = Vec::new();
    for (index, (result, truth)) in results.channels.iter().zip(&truth.channels).enumerate() {
        let name = &result.name;
        let offset = outcome(&result.offset, truth.offset.truth);
        outcomes.push((format!("{name}.offset"), offset));
        for (column, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let what = if column == index % 3 { "gain" } else { axis };
            let element = outcome(&result.cross[column], truth.cross.truth[column]);
            outcomes.push((format!("{name}.{what}"), element));
        }
    }
    for (triad, delay) in Triad::ALL.into_iter().zip(&results.delays_s) {
        let truth = mean_delay_s(seed, &TRIADS[triad.index()]);
        let name = match triad {
            Triad::LinearAcceleration => "linear",
            Triad::AngularAcceleration => "angular",
            Triad::AngularRate => "rate",
        };
        outcomes.push((format!("{name}.delay"), outcome(delay, truth)));
    }
    outcomes
}

fn outcome(measured: &Measured, truth: f64) -> Outcome {
    let error = (measured.estimate - truth).abs();
    Outcome {
        inside: error <= measured.interval_95,
        error_over_u: error / measured.expanded_uncertainty,
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
            worst_error_over_u: ratios.last().copied().unwrap_or(0.0),
        }
    };
    first.iter().enumerate().map(summary).collect()
}
