//! The fit of a recorded series.

use std::f64::consts::TAU;

use hexsense_core::harmonics::Series;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::reference;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    // At least 64 values for six periods keep the fifth harmonic below half the sample rate; beyond it harmonics
    // alias onto each other and the fit has no answer.
    #[test]
    fn any_series_is_fitted_as_independent_least_squares_do(
        values in vec(-1.0_f64..1.0, 64..400), periods in 1.0_f64..6.0, offset in -20.0_f64..20.0,
    ) {
        let values: Vec<f64> = values.iter().map(|value| value + offset).collect();
        let cycles = periods / values.len() as f64;
        let found = Series::fit(TAU * cycles, &values).unwrap();
        let expected = reference::harmonics(cycles, &values);
        let harmonics = found.harmonics.iter().flat_map(|harmonic| [harmonic.cosine, harmonic.sine]);
        let all: Vec<f64> = [found.offset, found.drift].into_iter().chain(harmonics).collect();
        for (found, expected) in all.iter().zip(&expected) {
            prop_assert!((found - expected).abs() < 1e-9, "{:?} against {:?}", all, expected);
        }
    }
}

#[test]
fn what_is_put_in_comes_out() {
    let length = 3_000;
    let cycles = 3.1 / length as f64;
    let values: Vec<f64> = (0..length)
        .map(|n| {
            let theta = TAU * cycles * f64::from(n);
            let drift = 0.25 * ((f64::from(n) + 0.5) / f64::from(length) - 0.5);
            9.806_65 + drift + 2.0 * (theta - 0.7).cos() + 0.03 * (3.0 * theta + 1.0).cos()
        })
        .collect();
    let found = Series::fit(TAU * cycles, &values).unwrap();
    let near = |found: f64, expected: f64| {
        assert!((found - expected).abs() < 1e-10, "{found} for {expected}")
    };
    near(found.offset, 9.806_65);
    near(found.drift, 0.25);
    near(found.first().amplitude(), 2.0);
    near(found.first().phase(), 0.7);
    near(found.harmonics[2].amplitude(), 0.03);
    near(found.harmonics[2].phase(), -1.0);
    near(found.distortion(), 0.015);
    assert!(found.residual_rms < 1e-6 && found.uncertainty.amplitude[0] < 1e-7);
}

/// Worst relative error of the amplitude over sixteen phases, of single-precision samples of a sine of one.
fn worst_error(rate_hz: f64, frequency_hz: f64, length: usize, offset: f64) -> f64 {
    let cycles = frequency_hz / rate_hz;
    let error = |phase: f64| {
        let sample =
            |n: usize| f64::from((offset + (TAU * cycles * n as f64 + phase).cos()) as f32);
        let values: Vec<f64> = (0..length).map(sample).collect();
        let fit = Series::fit(TAU * cycles, &values).unwrap();
        (fit.first().amplitude() - 1.0).abs()
    };
    (0..16)
        .map(|phase| error(TAU * f64::from(phase) / 16.0))
        .fold(0.0, f64::max)
}

/// Published errors of seven estimators; the last column is a three-parameter least squares in double precision. Over
/// ten periods nine more parameters cost nothing, so the same numbers must come out. Over one period they cost the
/// growth of the scatter, and the rounding errors of two runs differ.
#[test]
fn errors_are_those_published_for_double_precision() {
    let published = include_str!("../data/estimator_f32_errors.csv");
    let mut rows = [0, 0];
    for line in published.lines().skip(1) {
        let cell: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [rate_hz, frequency_hz, periods, length, offset, .., double] = cell[..] else {
            panic!("{line}");
        };
        if length > 50_000.0 {
            continue;
        }
        let ratio = worst_error(rate_hz, frequency_hz, length as usize, offset) / double;
        let expected = if periods == 10.0 {
            0.96..1.04
        } else {
            0.5..12.0
        };
        assert!(expected.contains(&ratio), "{line}: {ratio}");
        rows[usize::from(periods == 10.0)] += 1;
    }
    assert_eq!(rows, [16, 10], "rows of one and of ten periods");
}

#[test]
fn too_few_samples_or_no_numbers_are_refused() {
    let omega = TAU / 20.0;
    let wave: Vec<f64> = (0..60).map(|n| (omega * f64::from(n)).cos()).collect();
    for length in 0..=12 {
        assert_eq!(
            Series::fit(omega, &wave[..length]),
            None,
            "{length} samples"
        );
    }
    assert!(Series::fit(omega, &wave).is_some());
    for bad in [f64::NAN, f64::INFINITY] {
        let mut wave = wave.clone();
        wave[30] = bad;
        assert_eq!(Series::fit(omega, &wave), None);
    }
    for omega in [0.0, f64::NAN, f64::INFINITY, TAU] {
        assert_eq!(Series::fit(omega, &wave), None, "{omega}");
    }
}
