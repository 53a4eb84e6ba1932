//! Terms add in squares.

use approx::assert_relative_eq;
use hexsense_core::calibration::budget::{Budget, Cause, Distribution, uniform};

#[test]
fn independent_contributions_add_in_squares_and_causes_stay_apart() {
    let mut budget = Budget::default();
    assert_eq!((budget.combined(), budget.expanded()), (0.0, 0.0));
    budget.add(Cause::SensorNoise, Distribution::Normal, 3.0);
    budget.add(Cause::SensorNoise, Distribution::Normal, -4.0);
    assert_relative_eq!(budget.term(Cause::SensorNoise), 5.0);
    budget.add(Cause::Bandwidth, Distribution::Uniform, 12.0);
    assert_relative_eq!(budget.combined(), 13.0);
    assert_relative_eq!(budget.expanded(), 26.0);
    assert_relative_eq!(budget.term(Cause::SensorNoise), 5.0);
}

#[test]
fn every_cause_has_a_term_of_its_own() {
    let mut budget = Budget::default();
    for (index, cause) in Cause::ALL.into_iter().enumerate() {
        budget.add(cause, Distribution::Normal, (index + 1) as f64);
    }
    for (index, cause) in Cause::ALL.into_iter().enumerate() {
        assert_relative_eq!(budget.term(cause), (index + 1) as f64);
    }
    // 1² + … + n²
    let n = Cause::ALL.len() as f64;
    assert_relative_eq!(
        budget.combined(),
        (n * (n + 1.0) * (2.0 * n + 1.0) / 6.0).sqrt()
    );
    let mut names = Cause::ALL.map(Cause::name).to_vec();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), Cause::ALL.len(), "two causes of one name");
}

#[test]
fn a_uniform_distribution_has_the_variance_of_its_samples() {
    let (count, half_width) = (10_000, 0.3);
    let samples = (0..count)
        .map(|index| half_width * (2.0 * (f64::from(index) + 0.5) / f64::from(count) - 1.0));
    let variance = samples.map(|sample| sample * sample).sum::<f64>() / f64::from(count);
    assert_relative_eq!(uniform(half_width), variance.sqrt(), max_relative = 1e-6);
}

/// Normal distribution function, to 1.5e-7 (Abramowitz and Stegun 7.1.26).
fn normal_below(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs() / 2_f64.sqrt());
    let series = [
        1.061_405_429,
        -1.453_152_027,
        1.421_413_741,
        -0.284_496_736,
        0.254_829_592,
    ];
    let tail =
        series.iter().fold(0.0, |sum, factor| (sum + factor) * t) * (-x * x / 2.0).exp() / 2.0;
    if x < 0.0 { tail } else { 1.0 - tail }
}

/// Half width that holds 95 % of the sum of a uniform term within ± `width` and a normal one of deviation `normal`.
fn half_width_95(width: f64, normal: f64) -> f64 {
    const POINTS: u32 = 2_000;
    let held = |half: f64| {
        let at = |point| width * (2.0 * (f64::from(point) + 0.5) / f64::from(POINTS) - 1.0);
        let within =
            |t: f64| normal_below((half - t) / normal) - normal_below((-half - t) / normal);
        (0..POINTS).map(|point| within(at(point))).sum::<f64>() / f64::from(POINTS)
    };
    let (mut low, mut high) = (0.0, 3.0 * (width + normal));
    for _ in 0..50 {
        let middle = (low + high) / 2.0;
        if held(middle) < 0.95 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[test]
fn the_interval_holds_95_per_cent_of_a_uniform_and_a_normal_term() {
    for width in [0.01, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 30.0] {
        let mut budget = Budget::default();
        budget.add(Cause::SensorNoise, Distribution::Normal, 1.0);
        budget.add(Cause::Hinges, Distribution::Uniform, uniform(width));
        let (stated, expected) = (budget.interval_95(), half_width_95(width, 1.0));
        assert_relative_eq!(stated, expected, max_relative = 3e-3);
    }
}

#[test]
fn the_interval_of_a_single_term_is_that_of_its_shape() {
    let alone = |shape, standard| {
        let mut budget = Budget::default();
        budget.add(Cause::Hinges, shape, standard);
        budget.interval_95()
    };
    assert_relative_eq!(
        alone(Distribution::Normal, 2.0),
        2.0 * 1.959_964,
        max_relative = 1e-4
    );
    // 95 % of a tolerance is 0.95 of its half width.
    assert_relative_eq!(
        alone(Distribution::Uniform, uniform(0.7)),
        0.95 * 0.7,
        max_relative = 3e-3
    );
    assert_eq!(Budget::default().interval_95(), 0.0);
}
