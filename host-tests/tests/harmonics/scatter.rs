//! White noise scatters the amplitude as theory predicts, and the stated uncertainty is that scatter.
//!
//! The bound is var Â ≥ 2σ²/N. The drift column is not orthogonal to the sines: its correlation with sine k over P
//! periods is √6/(πkP), so that a sine's variance grows by 1 + r₁²/(1 − Σ rₖ²), which is 1.075 for three periods and
//! 6.5 for one; a cosine's does not.

use std::f64::consts::{PI, TAU};

use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::{Analyser, Harmonics, Series, solve};
use hexsense_core::sampling::{BLOCK, BlockSums};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::board::drive;

/// Growth of the variance along the sine by the drift column, from the correlations.
fn growth(periods: f64) -> f64 {
    let squared = |k: f64| 6.0 / (PI * k * periods).powi(2);
    let all: f64 = (1..=5).map(|k| squared(f64::from(k))).sum();
    1.0 + squared(1.0) / (1.0 - all)
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// Observed variance of the amplitude, and mean of the squared stated uncertainty.
fn variances(fits: &[Harmonics]) -> (f64, f64) {
    let mean =
        |value: &dyn Fn(&Harmonics) -> f64| fits.iter().map(value).sum::<f64>() / fits.len() as f64;
    let amplitude = mean(&|fit| fit.first().amplitude());
    let observed = mean(&|fit| (fit.first().amplitude() - amplitude).powi(2));
    (observed, mean(&|fit| fit.uncertainty.amplitude[0].powi(2)))
}

/// 4000 trials determine a variance to 2.2 %; 5 % beyond theory is more than two of that.
#[test]
fn a_series_scatters_by_the_bound_and_says_so() {
    const TRIALS: usize = 4_000;
    let (length, noise) = (120, 0.02);
    for periods in [1.0, 3.0] {
        let omega = TAU * periods / length as f64;
        for (phase, growth) in [(0.0, 1.0), (PI / 2.0, growth(periods))] {
            let mut random = ChaCha8Rng::seed_from_u64(7);
            let fits: Vec<_> = (0..TRIALS)
                .map(|_| {
                    let values: Vec<f64> = (0..length)
                        .map(|n| (omega * n as f64 - phase).cos() + noise * normal(&mut random))
                        .collect();
                    Series::fit(omega, &values).unwrap()
                })
                .collect();
            let (observed, stated) = variances(&fits);
            let bound = 2.0 * noise * noise / length as f64 * growth;
            let case = format!("{periods} periods, phase {phase}");
            assert!(
                (observed / bound - 1.0).abs() < 0.05,
                "{case}: {}",
                observed / bound
            );
            assert!(
                (stated / bound - 1.0).abs() < 0.01,
                "{case}: {}",
                stated / bound
            );
        }
    }
}

/// Fifteen channels with noise of their own are fifteen trials at once: 6000 determine a variance to 1.8 %.
#[test]
fn the_board_scatters_by_the_bound_and_says_so() {
    const RUNS: usize = 400;
    let (rate_hz, noise, amplitude) = (1_000.0, 25.0, 9_000.0);
    let frequency_hz = rate_hz / 320.0;
    let blocks = 60;
    let drive = drive(frequency_hz, rate_hz, blocks);
    for (phase, growth) in [(0.0, 1.0), (PI / 2.0, growth(3.0))] {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let mut fits = Vec::new();
        for _ in 0..RUNS {
            let mut analyser = Analyser::new();
            analyser.start(drive);
            for block in 0..blocks as usize {
                let scans: [_; BLOCK] = std::array::from_fn(|scan| {
                    let theta = TAU * frequency_hz / rate_hz * (block * BLOCK + scan) as f64;
                    let clean = 32_768.0 + amplitude * (theta - phase).cos();
                    [(); CHANNELS].map(|()| (clean + noise * normal(&mut random)).round() as u16)
                });
                analyser.take(&BlockSums::of_scans(&scans, (block * BLOCK) as u64));
            }
            fits.extend((0..CHANNELS).map(|channel| {
                let (drive, _, sums) = analyser.report(channel).unwrap();
                solve(&drive, &sums).unwrap()
            }));
        }
        let (observed, stated) = variances(&fits);
        // A block's sum attenuates the sine by this factor, and leaves the noise.
        let seen = (PI * 16.0 / 320.0).sin() / (16.0 * (PI / 320.0).sin());
        let bound =
            2.0 * noise * noise / (f64::from(blocks) * BLOCK as f64) * growth / seen.powi(2);
        let rms = fits.iter().map(|fit| fit.residual_rms).sum::<f64>() / fits.len() as f64;
        assert!(
            (observed / bound - 1.0).abs() < 0.05,
            "{}",
            observed / bound
        );
        assert!((stated / bound - 1.0).abs() < 0.01, "{}", stated / bound);
        // Means of sixteen scatter by a quarter, and the fit takes twelve of sixty degrees of freedom.
        let expected = noise / 4.0 * (48.0_f64 / 60.0).sqrt();
        assert!((rms / expected - 1.0).abs() < 0.02, "{rms} for {expected}");
    }
}
