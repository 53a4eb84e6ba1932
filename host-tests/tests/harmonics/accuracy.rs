//! Accuracy of the board's sums over the whole range, with the block that the host chooses.

use std::f64::consts::{PI, TAU};

use hexsense::FACTS;
use hexsense_core::channel::{INERTIAL, JACKS};
use hexsense_core::harmonics::{
    Analyser, ChannelSums, Drive, Harmonics, Series, increment, largest_block, solve, solve_channel,
};
use hexsense_core::sampling::{BlockSize, BlockSums};
use host_tests::accuracy::{cases, measure};
use nalgebra::{SMatrix, SVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::reference;

const RATES_HZ: [u32; 3] = [1_000, 2_000, 4_000];
/// Off the table's grid and not commensurate with the rates, so that rounding to counts differs from period to period.
const FREQUENCIES_HZ: [f64; 9] = [
    0.010_37, 0.033_1, 0.101_3, 0.500_3, 2.001_9, 7.013, 12.53, 31.07, 49.93,
];

/// The drive that a host would choose: the largest block, and about so many periods.
pub fn drive(frequency_hz: f64, rate_hz: u32, periods: f64) -> Drive {
    let block = largest_block(frequency_hz, rate_hz.into(), periods, &[], 0.0).unwrap();
    let scans = periods * f64::from(rate_hz) / frequency_hz;
    let drive = Drive {
        increment: increment(frequency_hz, rate_hz).unwrap(),
        block,
        settle_blocks: 0,
        blocks: (scans / block.scans() as f64).round() as u32,
    };
    assert!(drive.check().is_ok(), "{drive:?}");
    drive
}

/// Sums of the first channel for counts given by the number of the scan.
pub fn sums(drive: Drive, mut count: impl FnMut(usize) -> u16) -> ChannelSums {
    let mut analyser = Analyser::new();
    analyser.start(drive);
    let scans = drive.block.scans();
    for block in 0..drive.blocks as usize {
        let first = block * scans;
        let mut sums = BlockSums {
            first_scan: first as u64,
            inertial: [0; INERTIAL],
            jacks: [0; JACKS],
        };
        sums.inertial[0] = (first..first + scans).map(|n| u32::from(count(n))).sum();
        analyser.take(&sums);
    }
    analyser.report(0).unwrap().2
}

/// A sine of 3000 counts for 1 m/s² that rides on gravity.
fn on_gravity(turns: f64, phase: f64) -> f64 {
    32_768.0 + 3_000.0 * (9.806_65 + (TAU * turns.fract() - phase).cos())
}

fn off(found: &Harmonics, cosine: f64, sine: f64, amplitude: f64) -> f64 {
    let first = found.first();
    (first.cosine - cosine).hypot(first.sine - sine) / amplitude
}

#[test]
fn riding_on_gravity_the_first_harmonic_is_that_of_double_precision_from_a_hundredth_to_fifty_hertz()
 {
    const MAX_REFERENCE: usize = 60_000;
    let mut worst: f64 = 0.0;
    let mut cases = 0;
    for rate_hz in RATES_HZ {
        for frequency_hz in FREQUENCIES_HZ {
            for (periods, phase) in [(1.0, 0.4), (3.0, 2.1), (10.0, -1.3), (100.0, 2.9)] {
                let drive = drive(frequency_hz, rate_hz, periods);
                let length = drive.blocks as usize * drive.block.scans();
                let cycles = frequency_hz / f64::from(rate_hz);
                if drive.blocks < 13 || length > MAX_REFERENCE {
                    continue;
                }
                let counts: Vec<u16> = (0..length)
                    .map(|n| on_gravity(cycles * n as f64, phase).round() as u16)
                    .collect();
                let found = solve(&drive, &sums(drive, |n| counts[n])).unwrap();
                let expected = reference::harmonics_of_sums(cycles, &counts, drive.block.scans());
                let error = off(&found, expected[2], expected[3], 3_000.0);
                worst = worst.max(error);
                cases += 1;
                let case = format!("{frequency_hz} Hz at {rate_hz} Hz, {periods} periods");
                assert!(error < 5e-7, "{case}: {error:e}");
                // Single scans weigh the rounding to whole counts a little differently from blocks; the choice of the
                // block keeps the difference small.
                let single: Vec<f64> = counts.iter().map(|count| f64::from(*count)).collect();
                let expected = reference::harmonics(cycles, &single);
                let error = off(&found, expected[2], expected[3], 3_000.0);
                assert!(error < 5e-7, "{case}: {error:e} of single scans");
            }
        }
    }
    println!("{worst:e}");
    assert!(cases > 60 && worst < 1e-9, "{cases} cases, {worst:e}");
}

/// The whole table, a hundred periods at a hundredth of a hertz included: `cargo xtask accuracy`.
#[test]
fn blocks_as_the_host_chooses_them_give_the_fit_of_the_single_scans() {
    let errors = measure(&cases(10_000.0));
    assert!(errors.len() > 60, "{} cases", errors.len());
    for found in errors {
        assert!(found.of_arithmetic < 5e-9, "{found:?}");
        assert!(found.of_blocks < 5e-7, "{found:?}");
    }
}

#[test]
fn long_windows_lose_nothing() {
    let long = [
        (0.010_37, 1_000, 10.0),
        (0.010_37, 4_000, 3.0),
        (0.101_3, 2_000, 100.0),
    ];
    for (frequency_hz, rate_hz, periods) in long {
        let drive = drive(frequency_hz, rate_hz, periods);
        let cycles = frequency_hz / f64::from(rate_hz);
        let counts: Vec<f64> = (0..drive.blocks as usize * drive.block.scans())
            .map(|n| on_gravity(cycles * n as f64, 1.1).round())
            .collect();
        let found = solve(&drive, &sums(drive, |n| counts[n] as u16)).unwrap();
        let expected = Series::fit(TAU * cycles, &counts).unwrap().first();
        let error = off(&found, expected.cosine, expected.sine, 3_000.0);
        let case = format!("{frequency_hz} Hz at {rate_hz} Hz, {periods} periods");
        assert!(error < 5e-7, "{case}: {error:e}");
    }
}

/// The published table's frequencies, lengths and offsets, sixteen phases each; the signal fills the converter's range.
#[test]
fn the_published_cases_are_met_to_half_a_millionth_where_single_precision_fails() {
    let published = include_str!("../data/estimator_f32_errors.csv");
    let mut rows = 0;
    for line in published.lines().skip(1) {
        let cell: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [rate_hz, frequency_hz, periods, length, offset, ..] = cell[..] else {
            panic!("{line}");
        };
        if length > 20_000.0 {
            continue;
        }
        let drive = drive(frequency_hz, rate_hz as u32, periods);
        let (cycles, amplitude) = (
            frequency_hz / rate_hz,
            if offset == 0.0 { 32_000.0 } else { 3_000.0 },
        );
        for phase in (0..16).map(|phase| TAU * f64::from(phase) / 16.0 + 0.01) {
            let count = |n: usize| {
                let sine = (TAU * (cycles * n as f64).fract() + phase).cos();
                (32_768.0 + amplitude * (offset + sine)).round() as u16
            };
            let found = solve(&drive, &sums(drive, count)).unwrap();
            let taken = drive.blocks as usize * drive.block.scans();
            let counts: Vec<u16> = (0..taken).map(count).collect();
            let expected = reference::harmonics_of_sums(cycles, &counts, drive.block.scans());
            let error = off(&found, expected[2], expected[3], amplitude);
            assert!(error < 5e-7, "{line}: {error:e}");
        }
        rows += 1;
    }
    assert_eq!(rows, 24);
}

#[test]
fn ten_minutes_at_a_hundredth_of_a_hertz_end_within_a_microradian() {
    for rate_hz in RATES_HZ {
        let scans = 600 * u128::from(rate_hz);
        let advanced = u128::from(increment(0.01, rate_hz).unwrap()) * scans;
        let off = ((6_u128 << 64) - advanced) as f64;
        assert!(
            off.abs() / 2_f64.powi(64) * TAU < 1e-6,
            "{rate_hz} Hz: {off}"
        );
    }
    let drive = drive(0.01, 1_000, 6.0);
    let found = sums(drive, |n| on_gravity(1e-5 * n as f64, 0.7).round() as u16);
    let phase = solve(&drive, &found).unwrap().first().phase();
    assert!((phase - 0.7).abs() < 1e-6, "{phase}");
}

#[test]
fn increments_are_exact_and_absurd_frequencies_have_none() {
    assert_eq!(increment(250.0, 1_000), Some(1 << 62));
    assert_eq!(increment(1.0, 3), Some(u64::MAX / 3));
    // 0.1 Hz is not a binary fraction: the value of the f64, times 2⁶⁴, over 4000.
    assert_eq!(
        increment(0.1, 4_000),
        Some(((0.1_f64 * 2_f64.powi(55)) as u128 * 512 / 4_000) as u64)
    );
    for bad in [0.0, -1.0, 500.0, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE] {
        assert_eq!(increment(bad, 1_000), None, "{bad}");
    }
    assert_eq!(increment(1.0, 0), None);
}

#[test]
fn one_signal_on_two_ranks_has_one_phase() {
    let rate_hz = 4_000;
    let drive = drive(50.0, rate_hz, 100.0);
    let on = |channel: usize| {
        let sums = sums(drive, |n| {
            let at_s = n as f64 / f64::from(rate_hz) + FACTS.instant_s(channel);
            on_gravity(50.0 * at_s, 0.3).round() as u16
        });
        let late_scans = FACTS.instant_s(channel) * f64::from(rate_hz);
        let found = solve_channel(&drive, late_scans, &sums).unwrap();
        (
            found.first().phase(),
            solve(&drive, &sums).unwrap().first().phase(),
        )
    };
    let ((first, raw), (last, raw_last)) = (on(0), on(8));
    assert!(
        (first - last).abs() < 1e-5 && (first - 0.3).abs() < 1e-5,
        "{first} and {last}"
    );
    // Without the correction the delay of eight ranks of 25.6 µs is visible.
    assert!((raw - raw_last - TAU * 50.0 * 8.0 * 25.6e-6).abs() < 1e-5);
}

/// Cramér-Rao bound of the amplitude's variance at phase `phase`, for an unbiased estimator of the twelve unknowns and
/// white noise of variance one in every scan: the inverse of the Gram matrix of single scans.
fn cramer_rao(cycles: f64, length: usize, phase: f64) -> f64 {
    let mut gram = SMatrix::<f64, 12, 12>::zeros();
    for n in 0..length {
        let mut row = SVector::<f64, 12>::zeros();
        (row[0], row[1]) = (1.0, (n as f64 + 0.5) / length as f64 - 0.5);
        for k in 1..=5 {
            let angle = TAU * (cycles * n as f64 * k as f64).fract();
            (row[2 * k], row[2 * k + 1]) = (angle.cos(), angle.sin());
        }
        gram.ger(1.0, &row, &row, 1.0);
    }
    let along = SVector::<f64, 12>::from_fn(|row, _| match row {
        2 => phase.cos(),
        3 => phase.sin(),
        _ => 0.0,
    });
    along.dot(&(gram.try_inverse().unwrap() * along))
}

/// The stated uncertainty is the residual's standard deviation times the estimator's response to white noise; `scatter`
/// counts whether that statement is true. So a noisy signal shows the estimator's variance at once. Over three periods
/// the drift column alone costs 1.075 along the sine (and 2.55 over one without overtones, 6.5 with them), which the
/// bound of the twelve unknowns includes.
#[test]
fn white_noise_scatters_no_more_than_a_twentieth_above_the_bound_from_a_hundredth_to_fifty_hertz() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for rate_hz in RATES_HZ {
        for frequency_hz in [
            0.010_37, 0.101_3, 0.500_3, 1.249, 2.001_9, 7.013, 12.53, 31.07, 49.93,
        ] {
            for phase in [0.0, PI / 2.0] {
                let drive = drive(frequency_hz, rate_hz, 3.0);
                let cycles = frequency_hz / f64::from(rate_hz);
                let sums = sums(drive, |n| {
                    let noise: f64 = StandardNormal.sample(&mut random);
                    (on_gravity(cycles * n as f64, phase) + 25.0 * noise).round() as u16
                });
                let fit = solve(&drive, &sums).unwrap();
                let (blocks, scans) = (f64::from(drive.blocks), drive.block.scans() as f64);
                // Variance of a single scan's noise, from the residuals of the block means.
                let noise = fit.residual_rms.powi(2) * blocks / (blocks - 12.0) * scans;
                let achieved = fit.uncertainty.amplitude[0].powi(2) / noise;
                let bound = cramer_rao(cycles, (blocks * scans) as usize, phase);
                let ratio = achieved / bound;
                assert!(
                    (0.999..1.05).contains(&ratio),
                    "{frequency_hz} Hz at {rate_hz} Hz, phase {phase}: {ratio}"
                );
            }
        }
    }
}

#[test]
fn a_series_reaches_the_bound() {
    let mut random = ChaCha8Rng::seed_from_u64(6);
    for frequency_hz in [0.010_37, 0.500_3, 7.013, 49.93] {
        for phase in [0.0, PI / 2.0] {
            let cycles = frequency_hz / 1_000.0;
            let length = (3.0 / cycles) as usize;
            let values: Vec<f64> = (0..length)
                .map(|n| {
                    let noise: f64 = StandardNormal.sample(&mut random);
                    9.806_65 + (TAU * cycles * n as f64 - phase).cos() + 0.01 * noise
                })
                .collect();
            let fit = Series::fit(TAU * cycles, &values).unwrap();
            let noise = fit.residual_rms.powi(2) * length as f64 / (length as f64 - 12.0);
            let ratio =
                fit.uncertainty.amplitude[0].powi(2) / noise / cramer_rao(cycles, length, phase);
            assert!(
                (ratio - 1.0).abs() < 0.01,
                "{frequency_hz} Hz, phase {phase}: {ratio}"
            );
        }
    }
}

/// 2000 trials determine a standard deviation to 1.6 %.
#[test]
fn every_harmonic_scatters_as_it_says() {
    const TRIALS: usize = 2_000;
    let drive = Drive {
        increment: increment(5.0, 1_000).unwrap(),
        block: BlockSize::Four,
        settle_blocks: 0,
        blocks: 150,
    };
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let fits: Vec<Harmonics> = (0..TRIALS)
        .map(|_| {
            let found = sums(drive, |n| {
                let theta = TAU * 0.005 * n as f64;
                let clean: f64 = (1..=5)
                    .map(|k| 800.0 * (f64::from(k) * theta - 1.0).cos())
                    .sum();
                let noise: f64 = StandardNormal.sample(&mut random);
                (32_768.0 + clean + 20.0 * noise).round() as u16
            });
            solve(&drive, &found).unwrap()
        })
        .collect();
    let check =
        |what: &str, value: &dyn Fn(&Harmonics) -> f64, stated: &dyn Fn(&Harmonics) -> f64| {
            let mean =
                |of: &dyn Fn(&Harmonics) -> f64| fits.iter().map(of).sum::<f64>() / TRIALS as f64;
            let centre = mean(value);
            let scatter = mean(&|fit| (value(fit) - centre).powi(2)).sqrt();
            let ratio = scatter / mean(stated);
            assert!((ratio - 1.0).abs() < 0.06, "{what}: {ratio}");
        };
    check("offset", &|fit| fit.offset, &|fit| fit.uncertainty.offset);
    check("drift", &|fit| fit.drift, &|fit| fit.uncertainty.drift);
    for k in 0..5 {
        check(
            &format!("amplitude {}", k + 1),
            &|fit| fit.harmonics[k].amplitude(),
            &|fit| fit.uncertainty.amplitude[k],
        );
        check(
            &format!("phase {}", k + 1),
            &|fit| fit.harmonics[k].phase(),
            &|fit| fit.uncertainty.phase[k],
        );
    }
}
