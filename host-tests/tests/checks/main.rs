//! The checks of a campaign on the twin: good benches pass, and a fault is named.

mod faults;

use hexsense_probe::analysis::RecordedRun;
use hexsense_probe::analysis::check::{Check, Verdict};
use hexsense_probe::analysis::results::analyse;
use hexsense_probe::checks::{of_analysis, of_recordings};
use hexsense_probe::geometry_file::{GeometryFile, preset_names};
use hexsense_probe::plan::Purpose;
use hexsense_probe::plan::campaign::plan;
use hexsense_probe::sensor_file::SensorFile;
use host_tests::bench::{Laboratory, Movement};

/// A recorded campaign with its papers.
#[derive(Clone)]
struct Bench {
    base: GeometryFile,
    sensors: SensorFile,
    runs: Vec<RecordedRun>,
}

impl Bench {
    /// The campaign of a seed; the motion bases take turns.
    fn new(seed: u64) -> Self {
        let names = preset_names();
        let base = GeometryFile::load(names[seed as usize % names.len()]).unwrap();
        Self::with_file(seed, &base.clone(), base)
    }

    /// A campaign on the base `truth` that is planned and judged with the geometry file `base`.
    fn with_file(seed: u64, truth: &GeometryFile, base: GeometryFile) -> Self {
        let mut laboratory = Laboratory::new(seed, truth);
        let plan = plan(&base).unwrap();
        let runs = plan.runs_to(Purpose::Calibrate);
        let movements = runs.map(|run| Movement::new(&run.name, run.program(), run.rest_s, &base));
        let papers = twin::papers::sensor_file(seed);
        Self {
            sensors: SensorFile::parse("papers", &papers).unwrap(),
            runs: movements
                .map(|movement| laboratory.record(&movement))
                .collect(),
            base,
        }
    }

    /// All checks that can be made; the analysis comes when the recordings pass.
    fn checks(&self) -> Vec<Check> {
        let mut checks = of_recordings(&self.base, &self.sensors, &self.runs).unwrap();
        if failures(&checks).is_empty() {
            let analysis = analyse(&self.base, &self.sensors, &self.runs).unwrap();
            checks.extend(of_analysis(&self.base, &self.sensors, &analysis).unwrap());
        }
        checks
    }
}

fn failures(checks: &[Check]) -> Vec<&Check> {
    let failed = checks.iter().filter(|check| check.verdict == Verdict::Fail);
    failed.collect()
}

/// `cargo xtask coverage` counts more of them.
#[test]
fn good_benches_pass_every_check() {
    for seed in 1..=10 {
        let checks = Bench::new(seed).checks();
        let names: Vec<&str> = checks.iter().map(|check| check.name.as_str()).collect();
        assert_eq!(names, NAMES);
        for check in &checks {
            assert_eq!(check.verdict, Verdict::Pass, "seed {seed}: {check:?}");
            assert!(check.statistic <= check.limit && check.names.len() == 1);
        }
    }
}

/// All checks, in their order.
const NAMES: [&str; 12] = [
    "movement",
    "jacks follow",
    "jack gain",
    "jack residual",
    "home",
    "sensors answer",
    "sensor noise",
    "zero of the sensors",
    "sensor direction",
    "signal shape",
    "sensor gain",
    "sensor bias",
];
