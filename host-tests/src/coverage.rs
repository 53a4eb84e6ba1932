//! Whether the stated uncertainties are right: the share of many campaigns in which the truth lies inside.
//!
//! Each campaign has a twin of its own seed, on the motion bases in turn. For each coefficient the program counts the
//! share of campaigns with the truth inside the stated 95 % interval; by chance alone that share scatters by
//! √(0.95·0.05/n), 0.7 % for a thousand campaigns. It also counts the campaigns that the checks of the bench refuse,
//! although nothing is wrong with them.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};

use hexsense_probe::analysis::check::Check;
use hexsense_probe::analysis::results::{Analysis, Measured, Results, analyse};
use hexsense_probe::analysis::{AnalysisError, RecordedRun};
use hexsense_probe::checks;
use hexsense_probe::geometry_file::{GeometryFile, preset_names};
use hexsense_probe::plan::Purpose;
use hexsense_probe::plan::campaign::plan;
use hexsense_probe::sensor_file::SensorFile;
use serde::Serialize;
use twin::sheet::TRIADS;
use twin::truth::{Document, mean_delay_s};

use crate::bench::{Laboratory, Movement};

/// One coefficient over all campaigns.
#[derive(Debug, Clone, Serialize)]
pub struct Coefficient {
    /// Name of channel or triad and quantity: `ax.gain`, `ax.offset`, `ax.y` (counts of ay in the value of ax),
    /// `linear.delay`.
    pub name: String,
    /// Share of campaigns in which the truth lies inside the 95 % interval.
    pub coverage: f64,
    /// Median of |error| over the expanded uncertainty, k = 2.
    pub median_error_over_u: f64,
    /// Largest |error| over the expanded uncertainty.
    pub worst_error_over_u: f64,
}

/// The figures of many campaigns.
#[derive(Debug, Clone, Serialize)]
pub struct Coverage {
    /// Campaigns simulated.
    pub campaigns: u64,
    /// Campaigns that fail a check although their bench is as its files say.
    pub refused: u64,
    /// The checks that they fail.
    pub failed_checks: BTreeSet<String>,
    /// Offset and row of the matrix of each channel, then the delay of each triad: 39.
    pub coefficients: Vec<Coefficient>,
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

    /// Plays and records the campaign of a seed.
    ///
    /// # Panics
    /// When the twin refuses: these are tests.
    #[must_use]
    pub fn record(&self, seed: u64) -> Vec<RecordedRun> {
        let mut laboratory = Laboratory::new(seed, &self.base);
        let movements = self.movements.iter();
        movements
            .map(|movement| laboratory.record(movement))
            .collect()
    }

    /// Evaluates recorded runs; `papers` is the sensor file.
    ///
    /// # Errors
    /// [`AnalysisError`] when the campaign cannot be evaluated.
    ///
    /// # Panics
    /// When the papers are not usable: these are tests.
    pub fn analyse(&self, runs: &[RecordedRun], papers: &str) -> Result<Analysis, AnalysisError> {
        let sensors = SensorFile::parse("papers", papers).expect("usable papers");
        analyse(&self.base, &sensors, runs)
    }

    /// Plays, records and evaluates the campaign of a seed; `papers` is the sensor file.
    ///
    /// # Errors
    /// [`AnalysisError`] when the campaign cannot be evaluated.
    pub fn campaign(&self, seed: u64, papers: &str) -> Result<Analysis, AnalysisError> {
        self.analyse(&self.record(seed), papers)
    }

    /// The results for each coefficient of a campaign beside the truth of its seed.
    #[must_use]
    pub fn judged(&self, seed: u64, results: &Results) -> Vec<Judged> {
        let truth = Document::new(seed, &self.base.name);
        let mut all = Vec::new();
        for (index, (result, truth)) in results.channels.iter().zip(&truth.channels).enumerate() {
            let name = &result.name;
            let mut add = |what, measured, truth| {
                let name = format!("{name}.{what}");
                all.push(Judged {
                    name,
                    measured,
                    truth,
                });
            };
            add("offset", result.offset, truth.offset.truth);
            for (column, axis) in ["x", "y", "z"].into_iter().enumerate() {
                let what = if column == index % 3 { "gain" } else { axis };
                add(what, result.cross[column], truth.cross.truth[column]);
            }
        }
        let triads = ["linear", "angular", "rate"].iter().zip(&TRIADS);
        for ((name, sheet), measured) in triads.zip(results.delays_s) {
            all.push(Judged {
                name: format!("{name}.delay"),
                measured,
                truth: mean_delay_s(seed, sheet),
            });
        }
        all
    }
}

/// A coefficient of one campaign and its true value.
#[derive(Debug, Clone)]
pub struct Judged {
    /// As in [`Coefficient::name`].
    pub name: String,
    /// The estimate of the campaign.
    pub measured: Measured,
    /// The true value.
    pub truth: f64,
}

impl Judged {
    /// Whether the truth lies inside the 95 % interval.
    #[must_use]
    pub fn is_inside(&self) -> bool {
        self.error() <= self.measured.interval_95
    }

    /// |error|.
    #[must_use]
    pub fn error(&self) -> f64 {
        (self.measured.estimate - self.truth).abs()
    }
}

/// Simulates `campaigns` campaigns with seeds from `first_seed` on all cores; calls `done` after each.
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
            outcomes.push((index, outcome_of(first_seed + index, site)));
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
    let failed = |(_, outcome): &&(u64, Outcome)| !outcome.failed_checks.is_empty();
    let failed: Vec<_> = all.iter().filter(failed).collect();
    Coverage {
        campaigns,
        refused: failed.len() as u64,
        failed_checks: failed
            .iter()
            .flat_map(|(_, outcome)| outcome.failed_checks.iter().cloned())
            .collect(),
        coefficients: summarise(&all),
    }
}

/// What the campaign of a seed comes to.
struct Outcome {
    coefficients: Vec<Judged>,
    failed_checks: Vec<String>,
}

fn outcome_of(seed: u64, site: &Site) -> Outcome {
    let runs = site.record(seed);
    let papers = twin::papers::sensor_file(seed);
    let sensors = SensorFile::parse("papers", &papers).expect("usable papers");
    let base = &site.base;
    let mut checks = checks::of_recordings(base, &sensors, &runs).expect("whole runs");
    let analysis = analyse(base, &sensors, &runs).expect("a campaign that comes out");
    checks.extend(checks::of_analysis(base, &sensors, &analysis).expect("poses"));
    checks.retain(Check::is_open);
    Outcome {
        coefficients: site.judged(seed, &analysis.results),
        failed_checks: checks.into_iter().map(|check| check.name).collect(),
    }
}

fn summarise(all: &[(u64, Outcome)]) -> Vec<Coefficient> {
    let Some((_, first)) = all.first() else {
        return Vec::new();
    };
    let summary = |(index, judged): (usize, &Judged)| {
        let column = all.iter().map(|(_, outcome)| &outcome.coefficients[index]);
        let inside = column.clone().filter(|outcome| outcome.is_inside()).count();
        let over_u = |outcome: &Judged| outcome.error() / outcome.measured.expanded_uncertainty;
        let mut ratios: Vec<f64> = column.map(over_u).collect();
        ratios.sort_by(f64::total_cmp);
        Coefficient {
            name: judged.name.clone(),
            coverage: inside as f64 / all.len() as f64,
            median_error_over_u: ratios[ratios.len() / 2],
            worst_error_over_u: ratios.last().copied().unwrap_or(0.0),
        }
    };
    first.coefficients.iter().enumerate().map(summary).collect()
}
