//! Whole campaigns on the twin, without a chip: the results hold, and so do their uncertainties.

use hexsense_probe::analysis::belief::Belief;
use hexsense_probe::analysis::lever_arm::second_harmonics;
use hexsense_probe::geometry_file::{GeometryFile, preset_names};
use hexsense_probe::sensor_file::SensorFile;
use host_tests::coverage::{Coefficient, Site, coverage};

/// Enough to see a wrong sign, a forgotten term or a doubled one; `cargo xtask coverage` is the whole statistic.
const CAMPAIGNS: u64 = 20;

/// By chance alone, one coefficient in 20 campaigns is inside less than 15 times once in 400; the mean of its kind is
/// known much better.
#[test]
fn the_truth_of_every_coefficient_lies_inside_its_interval_as_often_as_it_should() {
    let figures = coverage(CAMPAIGNS, 1, || ());
    assert_eq!(figures.coefficients.len(), 9 * 4 + 3);
    for coefficient in &figures.coefficients {
        assert!(coefficient.coverage >= 0.75, "{coefficient:?}");
    }
    for kind in [".gain", ".offset", ".x", ".y", ".z", ".delay"] {
        let all = figures.coefficients.iter();
        let of_kind: Vec<&Coefficient> = all.filter(|c| c.name.ends_with(kind)).collect();
        let mean = |of: fn(&Coefficient) -> f64| {
            of_kind.iter().map(|c| of(c)).sum::<f64>() / of_kind.len() as f64
        };
        let (inside, median) = (mean(|c| c.coverage), mean(|c| c.median_error_over_u));
        assert!((0.88..=0.995).contains(&inside), "{kind}: {inside}");
        assert!((0.2..=0.5).contains(&median), "{kind}: {median}");
    }
}

#[test]
fn right_lever_arms_pass_and_one_that_is_wrong_by_a_tenth_of_a_metre_is_told() {
    let sites: Vec<Site> = preset_names().into_iter().map(Site::new).collect();
    for seed in 1..=CAMPAIGNS {
        let site = &sites[seed as usize % sites.len()];
        let analysis = site
            .campaign(seed, &twin::papers::sensor_file(seed))
            .unwrap();
        let results = &analysis.results;
        assert!(
            results.warnings.is_empty(),
            "{seed}: {:?}",
            results.warnings
        );
        let largest = results
            .second_harmonics
            .iter()
            .map(|harmonic| harmonic.measured);
        assert!(largest.fold(0.0, f64::max) > 0.01, "the block moves");
    }
    let axes = twin::truth::lever_arm_m(3).0;
    let papers = twin::papers::sensor_file(3);
    for axis in 0..3 {
        let mut wrong = axes;
        wrong[axis] += 0.1;
        let wrong = papers
            .lines()
            .map(|line| match line.starts_with("lever_arm_m ") {
                true => format!("lever_arm_m = {wrong:?}\n"),
                false => format!("{line}\n"),
            });
        let analysis = sites[0].campaign(3, &wrong.collect::<String>()).unwrap();
        let warnings = analysis.results.warnings;
        assert!(
            warnings
                .iter()
                .any(|warning| warning.contains("measure the place of the block")),
            "{warnings:?}"
        );
    }
}

#[test]
fn the_second_harmonic_tells_an_estimated_arm_that_is_wrong_by_a_tenth_of_a_metre() {
    let site = Site::new("an-74tk-200");
    let papers = twin::papers::sensor_file(4);
    let analysis = site.campaign(4, &papers).unwrap();
    let sensors = SensorFile::parse("papers", &papers).unwrap();
    let belief = Belief::new(&GeometryFile::load("an-74tk-200").unwrap(), &sensors);
    for axis in 0..3 {
        let mut estimate = analysis.estimate.clone();
        estimate.lever_arm_m[axis] += 0.1;
        let harmonics = second_harmonics(&analysis.condensed, &estimate, &belief).unwrap();
        assert!(
            harmonics.iter().any(|harmonic| !harmonic.agrees()),
            "{harmonics:?}"
        );
    }
}
