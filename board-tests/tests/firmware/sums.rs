//! The board's sums, bit for bit those of a replay of the counts that it streamed; and what it solves from them, bit for
//! bit what the host does.

use std::collections::BTreeMap;

use hexsense_core::channel::{CHANNELS, Scan};
use hexsense_core::harmonics::{ANALYSERS, Analyser, increment, solve_channel};
use hexsense_core::sampling::{BlockSize, BlockSums, RATES_HZ};
use hexsense_core::wire::message::{ChannelHarmonics, encode_response};
use hexsense_core::wire::status::Events;
use hexsense_core::wire::{AnalyserState, Drive, MAX_FRAME, Refusal, Request, Response};

use crate::bench::Board;
use crate::stream::assert_whole;

/// Counts by their scan counter.
fn capture(board: &Board) -> BTreeMap<u64, Scan> {
    let blocks = board.blocks.iter();
    blocks
        .flat_map(|arrived| {
            let first = arrived.block.header.first_scan;
            (first..).zip(arrived.block.counts.clone().unwrap())
        })
        .collect()
}

/// Every channel of an analyser that is complete, against the replay.
fn assert_replay(board: &mut Board, analyser: u8, drive: Drive) {
    let scans = capture(board);
    let mut host = Analyser::new();
    host.start(Drive {
        settle_blocks: 0,
        ..drive
    });
    for channel in 0..CHANNELS as u8 {
        let report = board.ask(&Request::Sums { analyser, channel });
        let Response::Sums {
            state,
            drive: reported,
            first_scan,
            sums,
        } = report
        else {
            panic!("{report:?}");
        };
        assert_eq!((state, reported), (AnalyserState::Complete, drive));
        if channel == 0 {
            let length = drive.block.scans();
            let window = u64::from(drive.blocks) * length as u64;
            let counts: Vec<Scan> = (first_scan..first_scan + window)
                .map(|scan| scans[&scan])
                .collect();
            for (block, first_scan) in counts.chunks(length).zip((first_scan..).step_by(length)) {
                host.take(&BlockSums::of_scans(block, first_scan));
            }
        }
        let (_, _, expected) = host.report(channel.into()).unwrap();
        assert_eq!(sums, expected, "analyser {analyser}, channel {channel}");
    }
}

fn drive(frequency_hz: f64, rate_hz: u32, block: BlockSize, settle_s: f64, length_s: f64) -> Drive {
    let blocks = |seconds: f64| (seconds * f64::from(rate_hz)) as u32 / block.scans() as u32;
    Drive {
        increment: increment(frequency_hz, rate_hz).unwrap(),
        block,
        settle_blocks: blocks(settle_s),
        blocks: blocks(length_s),
    }
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn three_analysers_sum_what_was_streamed_while_one_is_set_anew() {
    for (rate_hz, block) in [(4_000, BlockSize::Sixteen), (1_000, BlockSize::One)] {
        let mut board = Board::on(&format!("sums-{rate_hz}"));
        board.order(&Request::Rate(rate_hz));
        board.order(&Request::Block(block));
        board.stream(false, false);
        board.blocks.clear();
        let set = |analyser, drive| Request::Drive { analyser, drive };
        let drives = [
            drive(1.3, rate_hz, block, 0.2, 1.5),
            drive(2.1, rate_hz, block, 0.0, 1.9),
            drive(4.7, rate_hz, block, 0.5, 0.6),
        ];
        for (analyser, drive) in (0..).zip(drives) {
            board.order(&set(analyser, drive));
        }
        board.run_s(0.7);
        let summing = board.status().analysers;
        assert_eq!(summing, [AnalyserState::Summing; ANALYSERS]);
        let anew = drive(3.3, rate_hz, block, 0.1, 0.8);
        board.order(&set(1, anew));
        board.run_s(1.5);
        for (analyser, drive) in [(0, drives[0]), (1, anew), (2, drives[2])] {
            assert_replay(&mut board, analyser, drive);
            assert_fits(&mut board, analyser, rate_hz);
        }
        let status = board.status();
        assert_eq!(status.events, Events::NONE);
    }
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn what_cannot_be_estimated_is_refused_by_name() {
    let mut board = Board::on("refused");
    let good = drive(1.0, 1_000, BlockSize::Sixteen, 0.0, 1.0);
    let mut refused = |analyser, drive| match board.ask(&Request::Drive { analyser, drive }) {
        Response::Refused(refusal) => Some(refusal),
        _ => None,
    };
    assert_eq!(refused(2, good), None);
    assert_eq!(refused(3, good), Some(Refusal::Analyser { analyser: 3 }));
    let other = Drive {
        block: BlockSize::Four,
        ..good
    };
    let expected = Refusal::OtherBlock {
        drive: 4,
        board: 16,
    };
    assert_eq!(refused(0, other), Some(expected));
    let fast = Drive {
        increment: u64::MAX / 100,
        ..good
    };
    assert!(matches!(refused(0, fast), Some(Refusal::Drive(_))));
    let asked = |board: &mut Board, request| match board.ask(&request) {
        Response::Refused(refusal) => refusal,
        other => panic!("{other:?}"),
    };
    let fit = |analyser, channel| Request::Harmonics { analyser, channel };
    assert_eq!(
        asked(&mut board, fit(2, 0)),
        Refusal::Incomplete { analyser: 2 }
    );
    assert_eq!(
        asked(&mut board, fit(3, 0)),
        Refusal::Analyser { analyser: 3 }
    );
    assert_eq!(
        asked(&mut board, fit(0, 15)),
        Refusal::Channel { channel: 15 }
    );
    let without_set = asked(&mut board, Request::Motion { analyser: 0 });
    assert_eq!(without_set, Refusal::NoSet);
    // Twelve blocks are complete and determine nothing.
    board.order(&Request::Drive {
        analyser: 0,
        drive: Drive { blocks: 12, ..good },
    });
    board.run_s(0.5);
    assert_eq!(
        asked(&mut board, fit(0, 0)),
        Refusal::Undetermined { blocks: 12 }
    );
}

/// Fifty hertz needs single scans, or blocks of at most 2 at 4 kHz; the counts stream beside them at every rate.
#[test]
#[ignore = "needs the firmware and the virtual board"]
fn fifty_hertz_is_estimated_at_every_rate_while_counts_stream() {
    for rate_hz in RATES_HZ {
        let mut board = Board::on(&format!("fifty-{rate_hz}"));
        board.order(&Request::Rate(rate_hz));
        board.stream(false, false);
        board.order(&Request::Block(BlockSize::One));
        board.run_s(0.05);
        board.blocks.clear();
        let drive = drive(50.0, rate_hz, BlockSize::One, 0.1, 1.5);
        board.order(&Request::Drive { analyser: 0, drive });
        board.run_s(2.0);
        assert_whole(&board, &format!("{rate_hz} Hz"));
        assert_replay(&mut board, 0, drive);
        assert_fits(&mut board, 0, rate_hz);
        let status = board.status();
        assert_eq!(status.events, Events::NONE);
    }
}

/// What the board solves from its sums, against what the host does: the same bits.
fn assert_fits(board: &mut Board, analyser: u8, rate_hz: u32) {
    for channel in 0..CHANNELS as u8 {
        let report = board.ask(&Request::Sums { analyser, channel });
        let Response::Sums { drive, sums, .. } = report else {
            panic!("{report:?}");
        };
        let answer = board.ask(&Request::Harmonics { analyser, channel });
        let Response::Harmonics { first_scan, .. } = answer else {
            panic!("{answer:?}");
        };
        let solved = solve_channel(&drive, rate_hz, channel.into(), &sums).unwrap();
        let host = Response::Harmonics {
            drive,
            first_scan,
            harmonics: ChannelHarmonics::from(&solved),
        };
        let bytes = |response: &Response| {
            let mut out = [0; MAX_FRAME];
            encode_response(response, 0, &mut out).unwrap();
            out
        };
        assert!(
            bytes(&answer) == bytes(&host),
            "analyser {analyser}, channel {channel}: {answer:?} and {host:?}"
        );
    }
}

/// Two million blocks are gone through in slices: the board says that it is busy, streams on, and answers in the end.
#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_long_window_is_solved_while_the_board_goes_on() {
    let mut board = Board::on("long");
    board.order(&Request::Rate(4_000));
    board.order(&Request::Block(BlockSize::One));
    board.stream(false, false);
    let drive = drive(0.7, 4_000, BlockSize::One, 0.0, 25.0);
    board.order(&Request::Drive { analyser: 1, drive });
    board.run_s(25.5);
    board.blocks.clear();
    let mut busy = 0;
    let request = Request::Harmonics {
        analyser: 1,
        channel: 0,
    };
    while let Response::Refused(refusal) = board.ask(&request) {
        assert_eq!(refusal, Refusal::Busy);
        busy += 1;
        board.status();
    }
    assert!((1..20).contains(&busy), "busy {busy} times");
    assert_fits(&mut board, 1, 4_000);
    assert_whole(&board, "while the board solved");
    let status = board.status();
    assert_eq!(status.events, Events::NONE);
}
