//! The board's sums equal those of a replay of its streamed counts, bit for bit. The harmonics that the board solves from them
//! equal the host's, bit for bit.

use std::collections::BTreeMap;

use anyhow::bail;
use board_tests::line::Line;
use hexsense::FACTS;
use hexsense_core::channel::{CHANNELS, Scan};
use hexsense_core::harmonics::{ANALYSERS, Analyser, increment, solve_channel};
use hexsense_core::sampling::{BlockSize, BlockSums};
use hexsense_core::wire::message::{ChannelHarmonics, encode_response};
use hexsense_core::wire::status::Events;
use hexsense_core::wire::{AnalyserState, Drive, MAX_FRAME, Refusal, Request, Response};

use crate::on;
use crate::stream::assert_whole;

/// Counts by their scan counter.
fn capture(line: &Line) -> BTreeMap<u64, Scan> {
    let blocks = line.blocks.iter();
    blocks
        .flat_map(|arrived| {
            let first = arrived.block.header.first_scan;
            (first..).zip(arrived.block.counts.clone().unwrap())
        })
        .collect()
}

/// Compares every channel of a complete analyser with the replay.
fn assert_replay(line: &mut Line, analyser: u8, drive: Drive) -> anyhow::Result<()> {
    let scans = capture(line);
    let mut host = Analyser::new();
    host.start(Drive {
        settle_blocks: 0,
        ..drive
    });
    for channel in 0..CHANNELS as u8 {
        let report = line.ask(&Request::Sums { analyser, channel })?;
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
    Ok(())
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
fn three_analysers_sum_what_was_streamed_while_one_is_set_anew() -> anyhow::Result<()> {
    for (rate_hz, block) in [(4_000, BlockSize::Sixteen), (1_000, BlockSize::One)] {
        let mut board = on(&format!("sums-{rate_hz}"))?;
        let line = &mut board.line;
        line.order(&Request::Rate(rate_hz))?;
        line.order(&Request::Block(block))?;
        line.stream(false, false)?;
        line.blocks.clear();
        let set = |analyser, drive| Request::Drive { analyser, drive };
        let drives = [
            drive(1.3, rate_hz, block, 0.2, 1.5),
            drive(2.1, rate_hz, block, 0.0, 1.9),
            drive(4.7, rate_hz, block, 0.5, 0.6),
        ];
        for (analyser, drive) in (0..).zip(drives) {
            line.order(&set(analyser, drive))?;
        }
        line.run_s(0.7)?;
        let summing = line.status()?.analysers;
        assert_eq!(summing, [AnalyserState::Summing; ANALYSERS]);
        let anew = drive(3.3, rate_hz, block, 0.1, 0.8);
        line.order(&set(1, anew))?;
        line.run_s(1.5)?;
        for (analyser, drive) in [(0, drives[0]), (1, anew), (2, drives[2])] {
            assert_replay(line, analyser, drive)?;
            assert_fits(line, analyser, rate_hz)?;
        }
        let status = line.status()?;
        assert_eq!(status.events, Events::NONE);
    }
    Ok(())
}

/// The refusal of a request.
fn refusal(line: &mut Line, request: &Request) -> anyhow::Result<Refusal> {
    match line.ask(request)? {
        Response::Refused(refusal) => Ok(refusal),
        other => bail!("{request:?} was answered by {other:?}"),
    }
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn what_cannot_be_estimated_is_refused_by_name() -> anyhow::Result<()> {
    let mut board = on("refused")?;
    let line = &mut board.line;
    let good = drive(1.0, 1_000, BlockSize::Sixteen, 0.0, 1.0);
    let drive = |analyser, drive| Request::Drive { analyser, drive };
    line.order(&drive(2, good))?;
    let asked = refusal(line, &drive(3, good))?;
    assert_eq!(asked, Refusal::Analyser { analyser: 3 });
    let other = Drive {
        block: BlockSize::Four,
        ..good
    };
    let expected = Refusal::OtherBlock {
        drive: 4,
        board: 16,
    };
    assert_eq!(refusal(line, &drive(0, other))?, expected);
    let fast = Drive {
        increment: u64::MAX / 100,
        ..good
    };
    let asked = refusal(line, &drive(0, fast))?;
    assert!(matches!(asked, Refusal::Drive(_)), "{asked:?}");
    let fit = |analyser, channel| Request::Harmonics { analyser, channel };
    for (request, expected) in [
        (fit(2, 0), Refusal::Incomplete { analyser: 2 }),
        (fit(3, 0), Refusal::Analyser { analyser: 3 }),
        (fit(0, 15), Refusal::Channel { channel: 15 }),
        (Request::Motion { analyser: 0 }, Refusal::NoSet),
    ] {
        assert_eq!(refusal(line, &request)?, expected);
    }
    // Twelve blocks are complete and determine nothing.
    line.order(&drive(0, Drive { blocks: 12, ..good }))?;
    line.run_s(0.5)?;
    let undetermined = Refusal::Undetermined { blocks: 12 };
    assert_eq!(refusal(line, &fit(0, 0))?, undetermined);
    Ok(())
}

/// Fifty hertz needs single scans, or blocks of at most 2 at 4 kHz; the counts stream beside them at every rate.
#[test]
#[ignore = "needs the firmware and the virtual board"]
fn fifty_hertz_is_estimated_at_every_rate_while_counts_stream() -> anyhow::Result<()> {
    for rate_hz in FACTS.rates_hz {
        let mut board = on(&format!("fifty-{rate_hz}"))?;
        let line = &mut board.line;
        line.order(&Request::Rate(rate_hz))?;
        line.stream(false, false)?;
        line.order(&Request::Block(BlockSize::One))?;
        line.run_s(0.05)?;
        line.blocks.clear();
        let drive = drive(50.0, rate_hz, BlockSize::One, 0.1, 1.5);
        line.order(&Request::Drive { analyser: 0, drive })?;
        line.run_s(2.0)?;
        assert_whole(line, &format!("{rate_hz} Hz"));
        assert_replay(line, 0, drive)?;
        assert_fits(line, 0, rate_hz)?;
        let status = line.status()?;
        assert_eq!(status.events, Events::NONE);
    }
    Ok(())
}

/// Compares the harmonics that the board solves from its sums with the host's: the same bits.
fn assert_fits(line: &mut Line, analyser: u8, rate_hz: u32) -> anyhow::Result<()> {
    for channel in 0..CHANNELS as u8 {
        let report = line.ask(&Request::Sums { analyser, channel })?;
        let Response::Sums { drive, sums, .. } = report else {
            panic!("{report:?}");
        };
        let answer = line.ask(&Request::Harmonics { analyser, channel })?;
        let Response::Harmonics { first_scan, .. } = answer else {
            panic!("{answer:?}");
        };
        let late_scans = FACTS.instant_s(channel.into()) * f64::from(rate_hz);
        let solved = solve_channel(&drive, late_scans, &sums).unwrap();
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
    Ok(())
}

/// The board goes through a long window in slices: it says that it is busy, streams on, and answers in the end.
#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_long_window_is_solved_while_the_board_goes_on() -> anyhow::Result<()> {
    let mut board = on("long")?;
    let line = &mut board.line;
    line.order(&Request::Rate(4_000))?;
    line.order(&Request::Block(BlockSize::One))?;
    line.stream(false, false)?;
    let drive = drive(0.7, 4_000, BlockSize::One, 0.0, 25.0);
    line.order(&Request::Drive { analyser: 1, drive })?;
    line.run_s(25.5)?;
    line.blocks.clear();
    let mut busy = 0;
    let request = Request::Harmonics {
        analyser: 1,
        channel: 0,
    };
    while let Response::Refused(refusal) = line.ask_once(&request)? {
        assert_eq!(refusal, Refusal::Busy);
        busy += 1;
        line.status()?;
    }
    assert!((1..20).contains(&busy), "busy {busy} times");
    assert_fits(line, 1, 4_000)?;
    assert_whole(line, "while the board solved");
    let status = line.status()?;
    assert_eq!(status.events, Events::NONE);
    Ok(())
}
