//! The board's integer sums, solved on the host, against least squares on the very same counts.

use std::f64::consts::TAU;

use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::{Analyser, Drive, Harmonics, Replay, Solver, solve};
use hexsense_core::sampling::{BLOCK, BlockSize, BlockSums};

use crate::reference;

/// A channel that the tests put their signal on, and another that must not leak into it.
const CHANNEL: usize = 4;

pub fn drive(frequency_hz: f64, rate_hz: f64, blocks: u32) -> Drive {
    Drive {
        increment: (frequency_hz / rate_hz * 2_f64.powi(64)) as u64,
        block: BlockSize::default(),
        settle_blocks: 0,
        blocks,
    }
}

/// The blocks of about `periods` periods, never a whole number of them.
fn blocks(frequency_hz: f64, rate_hz: f64, periods: f64) -> u32 {
    (periods * rate_hz / frequency_hz / BLOCK as f64).ceil() as u32
}

fn analyse(drive: Drive, counts: &[u16]) -> Analyser {
    let mut analyser = Analyser::new();
    analyser.start(drive);
    for (index, block) in counts.as_chunks::<BLOCK>().0.iter().enumerate() {
        let scans = block.map(|count| {
            let mut scan = [u16::MAX; CHANNELS];
            scan[CHANNEL] = count;
            scan
        });
        analyser.take(&BlockSums::of_scans(&scans, (index * BLOCK) as u64));
    }
    analyser
}

fn solved(analyser: &Analyser) -> Harmonics {
    let (drive, _, sums) = analyser.report(CHANNEL).unwrap();
    solve(&drive, &sums).unwrap()
}

const AMPLITUDE: f64 = 12_000.0;

/// Counts of a sensor that rides on gravity, drifts, and is not quite linear.
fn counts(frequency_hz: f64, rate_hz: f64, phase: f64, length: usize) -> Vec<u16> {
    let at = |n: usize| {
        let turns = (frequency_hz / rate_hz * n as f64).fract();
        let overtones: f64 = (2..=5)
            .map(|k| 90.0 / k as f64 * (TAU * k as f64 * turns + k as f64).cos())
            .sum();
        let drift = 200.0 * n as f64 / length as f64;
        32_768.0 + 9_806.65 + AMPLITUDE * (TAU * turns - phase).cos() + overtones + drift
    };
    (0..length).map(|n| at(n).round() as u16).collect()
}

/// Drive frequency and scan rate, Hz: slow and fast ones, not commensurate with the rate, so that rounding to whole
/// counts differs from period to period.
fn cases() -> impl Iterator<Item = (f64, f64)> {
    let slow = [0.01, 0.1234, 0.5003, 1.0007, 2.0019, 3.317, 5.0123, 5.9871];
    let fast = [0.57, 3.317, 12.53, 20.03, 24.87];
    let slow = slow.map(|frequency| (frequency, 1_000.0));
    slow.into_iter()
        .chain(fast.map(|frequency| (frequency, 4_000.0)))
}

/// Error of the first harmonic as a part of the amplitude, phase included.
fn relative(found: &Harmonics, expected: &[f64]) -> f64 {
    let first = found.first();
    (first.cosine - expected[2]).hypot(first.sine - expected[3]) / AMPLITUDE
}

#[test]
fn sums_solve_to_the_least_squares_of_the_same_counts() {
    for (frequency_hz, rate_hz) in cases() {
        for (phase, periods) in [(2.1, 3.0), (-1.0, 3.4)] {
            // Single counts are rounded, and sums in blocks weigh that a little differently: with fewer than a thousand
            // samples this alone is 5e-7.
            let blocks = blocks(frequency_hz, rate_hz, periods).max(80);
            let counts = counts(frequency_hz, rate_hz, phase, blocks as usize * BLOCK);
            let found = solved(&analyse(drive(frequency_hz, rate_hz, blocks), &counts));
            let samples: Vec<f64> = counts.iter().map(|count| f64::from(*count)).collect();
            let expected = reference::harmonics(frequency_hz / rate_hz, &samples);
            let case =
                format!("{frequency_hz} Hz at {rate_hz} Hz, {periods} periods, phase {phase}");
            assert!(
                relative(&found, &expected) < 5e-7,
                "{case}: {found:?}, {expected:?}"
            );
            assert!((found.offset - expected[0]).abs() < 0.02, "{case}");
            assert!((found.drift - expected[1]).abs() < 0.2, "{case}");
        }
    }
}

#[test]
fn summing_in_blocks_costs_nothing() {
    for (frequency_hz, rate_hz) in cases() {
        for (phase, periods) in [(0.3, 1.0), (2.1, 3.0)] {
            let blocks = blocks(frequency_hz, rate_hz, periods).max(20);
            let counts = counts(frequency_hz, rate_hz, phase, blocks as usize * BLOCK);
            let found = solved(&analyse(drive(frequency_hz, rate_hz, blocks), &counts));
            let expected = reference::harmonics_of_sums(frequency_hz / rate_hz, &counts, BLOCK);
            let case =
                format!("{frequency_hz} Hz at {rate_hz} Hz, {periods} periods, phase {phase}");
            assert!(
                relative(&found, &expected) < 2e-8,
                "{case}: {:e}",
                relative(&found, &expected)
            );
            for k in 1..5 {
                let off = found.harmonics[k].cosine - expected[2 + 2 * k];
                // In fractions of a count: the sums' table is not ideal, and rounding to whole counts shows it.
                assert!(off.abs() < 5e-3, "{case}, harmonic {}: {off:e}", k + 1);
            }
        }
    }
}

#[test]
fn amplitudes_and_phases_are_those_of_the_signal() {
    for phase in [-3.0, -1.2, 0.0, 0.4, 1.9, 3.1] {
        let blocks = blocks(0.25, 1_000.0, 3.0);
        let counts = counts(0.25, 1_000.0, phase, blocks as usize * BLOCK);
        let found = solved(&analyse(drive(0.25, 1_000.0, blocks), &counts));
        let first = found.first();
        // Rounding to whole counts scatters the amplitude by 0.29·√(2/12000) = 0.004 counts.
        assert!((first.amplitude() - AMPLITUDE).abs() < 0.02);
        assert!(
            (first.phase() - phase).abs() < 2e-6,
            "{} for {phase}",
            first.phase()
        );
        for (k, harmonic) in (2..).zip(&found.harmonics[1..]) {
            assert!((harmonic.amplitude() - 90.0 / f64::from(k)).abs() < 0.02);
            let turn = (harmonic.phase() + f64::from(k)).rem_euclid(TAU);
            assert!(turn.min(TAU - turn) < 1e-3, "harmonic {k}: {turn}");
        }
        assert!((found.drift - 200.0).abs() < 0.1);
        assert!((found.offset - (32_768.0 + 9_806.65 + 100.0)).abs() < 0.02);
        let overtones = (2..=5).map(|k| (90.0 / f64::from(k)).powi(2)).sum::<f64>();
        assert!((found.distortion() - overtones.sqrt() / AMPLITUDE).abs() < 1e-5);
    }
}

#[test]
fn a_window_that_is_no_whole_number_of_periods_costs_nothing() {
    for periods in [1.01, 2.5, 2.99, 3.7] {
        let blocks = blocks(0.2, 1_000.0, periods);
        let counts = counts(0.2, 1_000.0, 1.0, blocks as usize * BLOCK);
        let amplitude = solved(&analyse(drive(0.2, 1_000.0, blocks), &counts))
            .first()
            .amplitude();
        assert!(
            (amplitude / AMPLITUDE - 1.0).abs() < 3e-6,
            "{periods}: {amplitude}"
        );
    }
}

#[test]
fn sums_begin_after_the_settling_blocks_with_phase_zero() {
    let (settle, summed) = (37, 800);
    let whole = counts(0.7, 1_000.0, 0.5, (settle + summed) * BLOCK);
    let drive = Drive {
        settle_blocks: settle as u32,
        ..drive(0.7, 1_000.0, summed as u32)
    };
    let late = analyse(drive, &whole);
    let (_, first_scan, sums) = late.report(CHANNEL).unwrap();
    assert_eq!(first_scan, (settle * BLOCK) as u64);
    let fresh = analyse(
        Drive {
            settle_blocks: 0,
            ..drive
        },
        &whole[settle * BLOCK..],
    );
    assert_eq!(sums, fresh.report(CHANNEL).unwrap().2);
}

#[test]
fn blocks_after_the_last_change_nothing() {
    let counts = counts(0.7, 1_000.0, 0.5, 100 * BLOCK);
    let drive = drive(0.7, 1_000.0, 60);
    let (whole, cut) = (
        analyse(drive, &counts),
        analyse(drive, &counts[..60 * BLOCK]),
    );
    assert_eq!(whole.report(CHANNEL), cut.report(CHANNEL));
}

#[test]
fn fewer_blocks_than_unknowns_are_refused() {
    for blocks in 1..40 {
        let counts = counts(5.0, 1_000.0, 0.5, blocks as usize * BLOCK);
        let analyser = analyse(drive(5.0, 1_000.0, blocks), &counts);
        let (drive, _, sums) = analyser.report(CHANNEL).unwrap();
        let solved = solve(&drive, &sums);
        assert!(blocks > 12 || solved.is_none(), "{blocks} blocks");
        // One period of 5 Hz is twelve and a half blocks.
        assert!(blocks < 20 || solved.is_some(), "{blocks} blocks");
    }
}

#[test]
fn a_window_that_is_replayed_in_slices_gives_the_same_bits() {
    let drive = drive(0.7, 1_000.0, 300);
    let counts = counts(0.7, 1_000.0, 0.5, 300 * BLOCK);
    let (_, _, sums) = analyse(drive, &counts).report(CHANNEL).unwrap();
    let whole = solve(&drive, &sums).unwrap();
    for slice in [1, 7, 64, 299] {
        let mut replay = Replay::new(drive).unwrap();
        let mut slices = 1;
        while !replay.advance(slice) {
            slices += 1;
        }
        assert_eq!(slices, 300_u32.div_ceil(slice));
        assert_eq!(Solver::new(&replay).unwrap().solve(&sums), whole);
    }
}

/// A window of less than a period hardly separates twelve unknowns. An answer must be right within its own uncertainty;
/// other windows are refused.
#[test]
fn a_window_too_short_for_its_unknowns_is_refused_before_it_is_wrong() {
    let mut refused = 0;
    for tenths in 1..=12 {
        let blocks = (f64::from(tenths) * 0.1 * 1_000.0 / 0.25 / BLOCK as f64) as u32;
        let counts = counts(0.25, 1_000.0, 0.5, blocks as usize * BLOCK);
        let analyser = analyse(drive(0.25, 1_000.0, blocks), &counts);
        let (drive, _, sums) = analyser.report(CHANNEL).unwrap();
        let Some(found) = solve(&drive, &sums) else {
            refused = tenths;
            continue;
        };
        let expected = reference::harmonics_of_sums(0.00025, &counts, BLOCK);
        let first = found.first();
        let off = (first.cosine - expected[2]).hypot(first.sine - expected[3]);
        println!(
            "{tenths} tenths: {off:e}, {:e}",
            found.uncertainty.amplitude[0]
        );
        assert!(
            off < 0.01 * found.uncertainty.amplitude[0],
            "{tenths} tenths"
        );
    }
    assert!((3..10).contains(&refused), "up to {refused} tenths");
}
