//! The drive frequency from the series itself.

use std::f64::consts::TAU;

use hexsense_core::harmonics::fit_frequency;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A sine that is a little distorted and rides on gravity.
fn wave(omega: f64, phase: f64, length: usize) -> Vec<f64> {
    let at = |n: usize| {
        let theta = omega * n as f64;
        9.806_65 + (theta - phase).cos() + 0.01 * (2.0 * theta).sin() + 1e-5 * n as f64
    };
    (0..length).map(at).collect()
}

#[test]
fn the_frequency_is_found_from_one_per_cent_off() {
    for periods in [1.5, 3.0, 3.3, 10.0] {
        for phase in [0.0, 0.8, 1.6, 2.4, 3.1] {
            let omega = TAU * periods / 3_000.0;
            let values = wave(omega, phase, 3_000);
            for start in [0.99 * omega, 1.01 * omega] {
                let found = fit_frequency(&values, start).unwrap();
                assert!(
                    (found / omega - 1.0).abs() < 1e-7,
                    "{periods} periods, phase {phase}: {:e}",
                    found / omega - 1.0
                );
            }
        }
    }
}

/// Variance of the frequency of a sine of amplitude A in white noise σ: at least 24σ²/(A²N³) (rad per sample)². The
/// drift and the overtones raise it a little; 1000 trials determine a variance to 4.5 %.
#[test]
fn noise_scatters_the_frequency_no_more_than_theory_allows() {
    const TRIALS: usize = 1_000;
    let (length, noise) = (300, 0.05);
    let omega = TAU * 4.2 / length as f64;
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let clean = wave(omega, 0.4, length);
    let error = |_| {
        let noisy: Vec<f64> = clean
            .iter()
            .map(|value| {
                let deviate: f64 = StandardNormal.sample(&mut random);
                value + noise * deviate
            })
            .collect();
        fit_frequency(&noisy, 1.003 * omega).unwrap() - omega
    };
    let errors: Vec<f64> = (0..TRIALS).map(error).collect();
    let bound = 24.0 * noise * noise / (length as f64).powi(3);
    let variance = errors.iter().map(|error| error * error).sum::<f64>() / TRIALS as f64;
    let ratio = variance / bound;
    assert!((0.9..1.2).contains(&ratio), "{ratio}");
}

#[test]
fn a_series_without_that_sine_is_refused() {
    let omega = TAU / 100.0;
    assert_eq!(fit_frequency(&vec![0.0; 500], omega), None, "silence");
    assert_eq!(fit_frequency(&vec![9.806_65; 500], omega), None, "rest");
    assert_eq!(
        fit_frequency(&wave(2.0 * omega, 0.3, 500), omega),
        None,
        "another frequency"
    );
    assert_eq!(
        fit_frequency(&wave(omega, 0.3, 10), omega),
        None,
        "too short"
    );
    let short = wave(1.25 * omega, 0.3, 150);
    assert!(
        fit_frequency(&short, 1.15 * omega).is_some(),
        "within reach"
    );
    assert_eq!(
        fit_frequency(&short, omega),
        None,
        "a quarter off, though the search would find it"
    );
    let mut broken = wave(omega, 0.3, 500);
    broken[77] = f64::NAN;
    assert_eq!(fit_frequency(&broken, omega), None, "not a number");
    assert_eq!(
        fit_frequency(&wave(omega, 0.3, 500), f64::NAN),
        None,
        "no start"
    );
    assert_eq!(
        fit_frequency(&wave(omega, 0.3, 500), 0.0),
        None,
        "zero start"
    );
    assert_eq!(fit_frequency(&[], omega), None, "nothing");
}
