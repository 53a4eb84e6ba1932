//! Whole campaigns on the twin, without a chip: the results hold, and so do their uncertainties.

use hexsense_probe::analysis::assumptions::Assumptions;
use hexsense_probe::analysis::lever_arm::second_harmonics;
use hexsense_probe::geometry_file::{GeometryFile, preset_names};
use hexsense_probe::sensor_file::SensorFile;
use host_tests::coverage::{Coefficient, Site, coverage};

/// Enough seeds to see a wrong sign, a forgotten term or a doubled one; `cargo xtask coverage` is the whole statistic.
const CAMPAIGNS: u64 = 20;

/// Coefficients of one kind, and the number of them that err independently in a campaign: the offset of the converter
/// is in all nine offsets.
const KINDS: [(&[&str], u64); 4] = [
    (&[".offset"], 1),
    (&[".gain"], 9),
    (&[".x", ".y", ".z"], 18),
    (&[".delay"], 3),
];

/// By chance alone one coefficient is inside fewer than 14 times of 20 in one of 30,000 cases, and the share of a kind
/// is 3.3 deviations √(0.95·0.05/n) off in one of a thousand.
#[test]
fn the_truth_of_every_coefficient_lies_inside_its_interval_as_often_as_it_should() {
    let figures = coverage(CAMPAIGNS, 1, || ());
    assert_eq!(figures.coefficients.len(), 9 * 4 + 3);
    assert_eq!(figures.refused, 0, "{:?}", figures.failed_checks);
    for coefficient in &figures.coefficients {
        assert!(coefficient.coverage >= 0.7, "{coefficient:?}");
    }
    for (names, independent) in KINDS {
        let is_of_kind = |c: &&Coefficient| names.iter().any(|name| c.name.ends_with(name));
        let of_kind: Vec<&Coefficient> = figures.coefficients.iter().filter(is_of_kind).collect();
        let mean = |of: fn(&Coefficient) -> f64| {
            of_kind.iter().map(|c| of(c)).sum::<f64>() / of_kind.len() as f64
        };
        let (inside, median) = (mean(|c| c.coverage), mean(|c| c.median_error_over_u));
        let deviation = (0.95 * 0.05 / (CAMPAIGNS * independent) as f64).sqrt();
        let off = (inside - 0.95).abs();
        assert!(off <= 3.3 * deviation, "{names:?}: {inside}");
        assert!((0.2..=0.5).contains(&median), "{names:?}: {median}");
    }
}

#[test]
fn right_lever_arms_pass_and_one_that_is_wrong_by_a_tenth_of_a_metre_is_told() {
    let sites: Vec<Site> = preset_names().into_iter().map(Site::new).collect();
    for seed in 1..=8 {
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
    let assumptions = Assumptions::new(&GeometryFile::load("an-74tk-200").unwrap(), &sensors);
    let right = second_harmonics(&analysis.condensed, &analysis.estimate, &assumptions).unwrap();
    assert!(right.iter().all(|harmonic| harmonic.agrees()), "{right:?}");
    for axis in 0..3 {
        let mut estimate = analysis.estimate.clone();
        estimate.lever_arm_m[axis] += 0.1;
        let harmonics = second_harmonics(&analysis.condensed, &estimate, &assumptions).unwrap();
        assert!(
            harmonics.iter().any(|harmonic| !harmonic.agrees()),
            "{harmonics:?}"
        );
    }
}

/// The holds determine the gains of ax and az against gravity and nothing else.
#[test]
fn an_uncertain_gravity_makes_the_gains_of_ax_and_az_as_uncertain() {
    let papers = twin::papers::sensor_file(4);
    let results = Site::new("an-74tk-200")
        .campaign(4, &papers)
        .unwrap()
        .results;
    let gravity = &results.gravity_m_s2;
    let relative = gravity.expanded_uncertainty / 2.0 / gravity.estimate;
    for channel in [0, 2] {
        let terms = &results.channels[channel].budget;
        let term = terms.iter().find(|term| term.cause == "local gravity");
        let stated = term.unwrap().gain_relative;
        assert!((stated / relative - 1.0).abs() < 0.01, "{stated}");
    }
}
