//! The stream: whole at every block and rate that the link carries, and its values those of its counts.

use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::increment;
use hexsense_core::sampling::{BlockSize, Calibrator, RATES_HZ};
use hexsense_core::wire::status::Events;
use hexsense_core::wire::telemetry::{bits_per_second, scans_of_frame};
use hexsense_core::wire::{Drive, Request, Response, StreamContent};

use crate::bench::{Arrived, Board};
use crate::set::upload;

/// Frames follow each other without a gap from the first on.
pub fn assert_whole(board: &Board, what: &str) {
    assert!(board.blocks.len() > 5, "{what}: nothing came");
    for pair in board.blocks.windows(2) {
        let [before, after] = [&pair[0], &pair[1]].map(|arrived| &arrived.block.header);
        let due = before.first_scan + u64::from(before.scans);
        assert_eq!(after.first_scan, due, "{what}");
    }
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn streamed_values_are_those_of_the_streamed_counts_bit_for_bit_at_every_block() {
    let mut board = Board::on("values");
    let set = upload(&mut board, 1);
    let calibrator = Calibrator::new(&set);
    board.stream(true, false);
    for block in BlockSize::ALL {
        let before = board.status().scans_lost;
        board.order(&Request::Block(block));
        let lost = board.status().scans_lost - before;
        // A pause of some milliseconds, and what had not filled a block.
        assert!(lost < 40, "{lost} scans were lost");
        board.run_s(0.05);
        board.blocks.clear();
        board.run_s(0.5);
        assert_whole(&board, &format!("{block:?}"));
        for arrived in &board.blocks {
            let header = &arrived.block.header;
            assert_eq!(usize::from(header.scans), block.scans().min(16));
            let counts = arrived.block.counts.as_ref().unwrap();
            for (scan, values) in counts.iter().zip(arrived.block.values.as_ref().unwrap()) {
                let expected = calibrator.apply(scan, header.supply).map(f32::to_bits);
                assert_eq!(values.map(f32::to_bits), expected);
            }
        }
    }
    let status = board.status();
    assert_eq!(status.events, Events::NONE);
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn counts_stream_in_every_block_at_every_rate_in_frames_that_the_line_carries() {
    let counts = StreamContent {
        counts: true,
        values: false,
        pose: false,
    };
    for rate_hz in RATES_HZ {
        let mut board = Board::on(&format!("gathered-{rate_hz}"));
        board.order(&Request::Rate(rate_hz));
        board.stream(false, false);
        for block in BlockSize::ALL {
            board.order(&Request::Block(block));
            board.run_s(0.05);
            board.blocks.clear();
            board.run_s(1.0);
            let what = format!("{block:?} at {rate_hz} Hz");
            assert_whole(&board, &what);
            let due = scans_of_frame(counts, rate_hz, block);
            let scans = |arrived: &Arrived| usize::from(arrived.block.header.scans);
            let whole = board.blocks.iter().filter(|arrived| scans(arrived) == due);
            // With each of ten readings of the supply a frame may end early, and another at the end of the ring.
            assert!(whole.count() + 22 >= board.blocks.len(), "{what}");
            assert!(board.blocks.iter().all(|arrived| scans(arrived) <= due));
            let bytes: usize = board.blocks.iter().map(|arrived| arrived.bytes).sum();
            let stated = bits_per_second(counts, rate_hz, block);
            assert!(bytes * 10 <= stated as usize + 10_000, "{what}: {bytes}");
        }
        let status = board.status();
        assert_eq!(status.events, Events::NONE);
    }
}

/// Virtual minutes of the test below by `HEXSENSE_MINUTES`, ten without it.
fn seconds() -> f64 {
    let minutes = std::env::var("HEXSENSE_MINUTES");
    60.0 * minutes.map_or(10.0, |minutes| minutes.parse::<f64>().unwrap())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn everything_at_four_kilohertz_loses_nothing() {
    let mut board = Board::on("everything");
    upload(&mut board, 1);
    board.order(&Request::Rate(4_000));
    let before = board.status();
    board.stream(false, true);
    for (analyser, frequency_hz) in [0.7, 1.9, 5.3].into_iter().enumerate() {
        let drive = Drive {
            increment: increment(frequency_hz, 4_000).unwrap(),
            block: BlockSize::Sixteen,
            settle_blocks: 10,
            blocks: 1 << 20,
        };
        let analyser = analyser as u8;
        board.order(&Request::Drive { analyser, drive });
    }
    let mut next = None;
    let end_us = board.now_us + (seconds() * 1e6) as u64;
    let mut poses = 0;
    while board.now_us < end_us {
        board.run_s(0.1);
        for channel in 0..CHANNELS as u8 {
            let analyser = channel % 3;
            let report = board.ask(&Request::Sums { analyser, channel });
            assert!(matches!(report, Response::Sums { .. }));
        }
        board.status();
        for arrived in board.blocks.drain(..) {
            let header = arrived.block.header;
            assert_eq!(header.first_scan, *next.get_or_insert(header.first_scan));
            next = Some(header.first_scan + u64::from(header.scans));
        }
        assert!(board.poses.drain(..).all(|pose| {
            poses += 1;
            pose.outcome.is_ok()
        }));
    }
    let status = board.status();
    assert_eq!(status.scans_lost, before.scans_lost);
    assert_eq!(status.events, Events::NONE);
    assert!(f64::from(poses) > 90.0 * seconds(), "{poses} poses");
}
