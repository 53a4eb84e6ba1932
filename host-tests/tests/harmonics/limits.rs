//! The range of the sums, and their state on the way.

use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::analyser::MAX_BLOCKS;
use hexsense_core::harmonics::{Analyser, Drive, DriveError, solve};
use hexsense_core::sampling::{BLOCK, BlockSize, BlockSums};
use hexsense_core::wire::AnalyserState;

use crate::board::drive;

#[test]
fn the_range_of_a_drive_is_open_at_zero_and_at_a_tenth_of_the_block_rate() {
    for block in BlockSize::ALL {
        let limit = (u128::from(u64::MAX) + 1) / 10 / block.scans() as u128;
        let with = |increment, blocks| {
            let drive = Drive {
                increment,
                block,
                settle_blocks: MAX_BLOCKS,
                blocks,
            };
            drive.check()
        };
        let fifth = Err(match block {
            BlockSize::One => DriveError::Frequency,
            _ => DriveError::FifthHarmonic {
                scans: block.scans() as u8,
            },
        });
        assert_eq!(with(1, 1), Ok(()));
        assert_eq!(with(limit as u64 - 1, MAX_BLOCKS), Ok(()));
        assert_eq!(with(0, 1), Err(DriveError::Frequency));
        assert_eq!(with(limit as u64 + 1, 1), fifth);
        assert_eq!(with(u64::MAX / 10, 1), Err(DriveError::Frequency));
        for blocks in [0, MAX_BLOCKS + 1] {
            assert_eq!(with(1, blocks), Err(DriveError::Blocks { blocks }));
        }
        for blocks in [MAX_BLOCKS + 1, u32::MAX] {
            let endless = Drive {
                increment: 1,
                block,
                settle_blocks: blocks,
                blocks: 1,
            };
            assert_eq!(endless.check(), Err(DriveError::Settle { blocks }));
        }
    }
    // Frequencies that users need: 6 Hz at 1 kHz and 25 Hz, just, at 4 kHz.
    for (below, above, rate_hz) in [(6.24, 6.26, 1_000.0), (24.9, 25.1, 4_000.0)] {
        assert_eq!(drive(below, rate_hz, 100).check(), Ok(()));
        let refused = drive(above, rate_hz, 100).check();
        assert_eq!(refused, Err(DriveError::FifthHarmonic { scans: 16 }));
    }
}

#[test]
fn the_longest_sum_of_full_scale_does_not_overflow() {
    // Arithmetic is checked in tests: an overflow panics. Each channel gets the counts that make one of its sums
    // greatest.
    let drive = Drive {
        increment: u64::MAX / 161,
        block: BlockSize::default(),
        settle_blocks: 0,
        blocks: MAX_BLOCKS,
    };
    let mut analyser = Analyser::new();
    analyser.start(drive);
    let full = [u16::MAX; CHANNELS];
    let mut phase = 0_u64;
    for block in 0..MAX_BLOCKS {
        let mut scan = full;
        // Full scale wherever cosine or sine is positive, and zero elsewhere.
        scan[1] = if phase.wrapping_add(1 << 62) < 1 << 63 {
            u16::MAX
        } else {
            0
        };
        scan[2] = if phase < 1 << 63 { u16::MAX } else { 0 };
        let first_scan = u64::from(block) * BLOCK as u64;
        analyser.take(&BlockSums::of_scans(&[scan; BLOCK], first_scan));
        phase = phase.wrapping_add(drive.increment.wrapping_mul(BLOCK as u64));
    }
    assert_eq!(analyser.state(), AnalyserState::Complete);
    let (_, _, sums) = analyser.report(0).unwrap();
    let (blocks, sum) = (i128::from(MAX_BLOCKS), i128::from(u16::MAX) * BLOCK as i128);
    assert_eq!(i128::from(sums.offset), blocks * sum);
    // 512 blocks share one of 4096 places.
    assert_eq!(i128::from(sums.drift), 512 * (4_096 * 4_095 / 2) * sum);
    assert_eq!(i128::from(sums.square), blocks * sum * sum);
    let fit = solve(&drive, &sums).unwrap();
    assert!((fit.offset - f64::from(u16::MAX)).abs() < 1e-6 && fit.first().amplitude() < 1e-6);
    let (_, _, square_wave) = analyser.report(1).unwrap();
    assert!(square_wave.cosine[0] > i64::from(MAX_BLOCKS) << 33);
}

#[test]
fn an_analyser_says_how_far_it_is() {
    let mut analyser = Analyser::new();
    let block = [[100; CHANNELS]; BLOCK];
    analyser.take(&BlockSums::of_scans(&block, 0));
    assert_eq!(
        (analyser.state(), analyser.report(0)),
        (AnalyserState::Idle, None)
    );

    let drive = Drive {
        settle_blocks: 2,
        ..drive(1.0, 1_000.0, 3)
    };
    analyser.start(drive);
    let states: Vec<_> = (1..=6)
        .map(|index| {
            let state = analyser.state();
            analyser.take(&BlockSums::of_scans(&block, index * 16));
            state
        })
        .collect();
    use AnalyserState::{Complete, Settling, Summing};
    assert_eq!(
        states,
        [Settling, Settling, Summing, Summing, Summing, Complete]
    );
    let (reported, first_scan, sums) = analyser.report(CHANNELS - 1).unwrap();
    assert_eq!((reported, first_scan, sums.offset), (drive, 48, 3 * 1_600));
    assert_eq!(analyser.report(CHANNELS), None);

    analyser.start(drive);
    assert_eq!(analyser.state(), Settling);
    assert_eq!(analyser.report(0).unwrap().2.offset, 0);
}
