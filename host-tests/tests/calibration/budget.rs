//! Terms add in squares.

use approx::assert_relative_eq;
use hexsense::calibration::budget::{Budget, Cause, uniform};

#[test]
fn independent_contributions_add_in_squares_and_causes_stay_apart() {
    let mut budget = Budget::default();
    assert_eq!((budget.combined(), budget.expanded()), (0.0, 0.0));
    budget.add(Cause::SensorNoise, 3.0);
    budget.add(Cause::SensorNoise, -4.0);
    assert_relative_eq!(budget.term(Cause::SensorNoise), 5.0);
    budget.add(Cause::Bandwidth, 12.0);
    assert_relative_eq!(budget.combined(), 13.0);
    assert_relative_eq!(budget.expanded(), 26.0);
    assert_relative_eq!(budget.term(Cause::SensorNoise), 5.0);
}

#[test]
fn every_cause_has_a_term_of_its_own() {
    let mut budget = Budget::default();
    for (index, cause) in Cause::ALL.into_iter().enumerate() {
        budget.add(cause, (index + 1) as f64);
    }
    for (index, cause) in Cause::ALL.into_iter().enumerate() {
        assert_relative_eq!(budget.term(cause), (index + 1) as f64);
    }
    // 1² + … + 10²
    assert_relative_eq!(budget.combined(), 385_f64.sqrt());
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
