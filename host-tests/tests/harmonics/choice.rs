//! The block that a drive allows, the effect of a larger one, and gaps.

use std::f64::consts::TAU;

use hexsense_core::channel::{INERTIAL, JACKS};
use hexsense_core::harmonics::choice::mistaken;
use hexsense_core::harmonics::{Analyser, Drive, increment, largest_block, solve};
use hexsense_core::sampling::{BlockSize, BlockSums};
use hexsense_core::wire::AnalyserState;

use crate::accuracy::sums;

#[test]
fn the_fifth_harmonic_turns_by_a_tenth_of_a_turn_at_most() {
    let largest = |frequency_hz, rate_hz| largest_block(frequency_hz, rate_hz, 3.0, &[], 0.0);
    assert_eq!(largest(0.5, 1_000.0), Some(BlockSize::ThirtyTwo));
    assert_eq!(largest(0.625, 1_000.0), Some(BlockSize::ThirtyTwo));
    assert_eq!(largest(0.626, 1_000.0), Some(BlockSize::Sixteen));
    assert_eq!(largest(5.1, 4_000.0), Some(BlockSize::Eight));
    assert_eq!(largest(19.0, 1_000.0), Some(BlockSize::One));
    assert_eq!(largest(99.9, 1_000.0), Some(BlockSize::One));
    for bad in [100.0, 0.0, -1.0, f64::NAN] {
        assert_eq!(largest(bad, 1_000.0), None, "{bad}");
    }
}

/// A disturbance of a hundredth of full scale beside a multiple of the block rate: its effect on the sums, and the
/// chosen block.
#[test]
fn a_known_disturbance_is_kept_from_the_first_harmonic() {
    let (frequency_hz, rate_hz) = (0.5, 1_000);
    // 4 · 1000 / 32 Hz and once the drive frequency; also 2 · 1000 / 16.
    let line_hz = 125.5;
    let error = |block: BlockSize| {
        let drive = Drive {
            increment: increment(frequency_hz, rate_hz).unwrap(),
            block,
            settle_blocks: 0,
            blocks: (6_000 / block.scans()) as u32,
        };
        let found = sums(drive, |n| {
            let t = n as f64 / f64::from(rate_hz);
            let sine = 20_000.0 * (TAU * frequency_hz * t).cos();
            (32_768.0 + sine + 655.0 * (TAU * line_hz * t).cos()).round() as u16
        });
        (solve(&drive, &found).unwrap().first().amplitude() / 20_000.0 - 1.0).abs()
    };
    let lines = [50.0, 100.0, 150.0, line_hz];
    let chosen = largest_block(frequency_hz, rate_hz.into(), 3.0, &lines, 2.0 / 6.0).unwrap();
    assert_eq!(chosen, BlockSize::Four);
    assert!(
        error(BlockSize::Sixteen) > 1e-4,
        "{:e}",
        error(BlockSize::Sixteen)
    );
    assert!(error(chosen) < 2e-6, "{:e}", error(chosen));
    let found = mistaken(
        frequency_hz,
        rate_hz.into(),
        BlockSize::Sixteen,
        &lines,
        0.3,
    )
    .unwrap();
    assert_eq!(
        (found.line_hz, found.multiple, found.harmonic),
        (line_hz, 2, 1)
    );
}

#[test]
fn what_single_scans_would_mistake_too_is_not_the_blocks_doing() {
    let lines = [1_001.0];
    assert_eq!(
        largest_block(0.5, 1_000.0, 3.0, &lines, 3.0),
        Some(BlockSize::ThirtyTwo)
    );
    assert_eq!(mistaken(0.5, 1_000.0, BlockSize::One, &[999.6], 3.0), None);
}

#[test]
fn a_gap_between_blocks_begins_everything_anew() {
    let drive = Drive {
        increment: increment(0.7, 1_000).unwrap(),
        block: BlockSize::Eight,
        settle_blocks: 3,
        blocks: 5,
    };
    let block = |first_scan: u64| BlockSums {
        first_scan,
        inertial: [8 * 100; INERTIAL],
        jacks: [8 * 200; JACKS],
    };
    let mut analyser = Analyser::new();
    analyser.start(drive);
    (0..6).for_each(|index| analyser.take(&block(1_000 + 8 * index)));
    assert_eq!(analyser.state(), AnalyserState::Summing);
    analyser.take(&block(1_056));
    assert_eq!(analyser.state(), AnalyserState::Settling);
    (1..8).for_each(|index| analyser.take(&block(1_056 + 8 * index)));
    assert_eq!(analyser.state(), AnalyserState::Complete);
    let (_, first_scan, sums) = analyser.report(INERTIAL).unwrap();
    assert_eq!((first_scan, sums.offset), (1_056 + 3 * 8, 5 * 1_600));
}

#[test]
fn the_limits_of_a_drive_follow_its_block() {
    for (block, limit_hz) in BlockSize::ALL
        .into_iter()
        .zip([100.0, 25.0, 12.5, 6.25, 3.125])
    {
        let with = |frequency_hz: f64| Drive {
            increment: increment(frequency_hz, 1_000).unwrap(),
            block,
            settle_blocks: 0,
            blocks: 100,
        };
        assert!(with(0.999 * limit_hz).check().is_ok(), "{block:?}");
        assert!(with(1.001 * limit_hz).check().is_err(), "{block:?}");
        assert_eq!(BlockSize::of_scans(block.scans()), Some(block));
    }
    assert_eq!(BlockSize::of_scans(2), None);
    // Sizes of one channel and of fifteen.
    assert!(size_of::<Analyser>() <= 1_536);
}
