//! The stream is whole at every block and rate that the link carries, and its values are those of its counts.

use std::time::Duration;

use board_tests::key_holder::calibrate;
use board_tests::line::{ArrivedBlock, Line};
use hexsense::FACTS;
use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::increment;
use hexsense_core::sampling::{BlockSize, Calibrator};
use hexsense_core::wire::message::encode_request;
use hexsense_core::wire::status::Events;
use hexsense_core::wire::telemetry::{bits_per_second, scans_of_frame};
use hexsense_core::wire::{Drive, MAX_FRAME, Request, Response, StreamContent};

use crate::{on, random};

/// Frames follow each other without a gap from the first on.
pub fn assert_whole(line: &Line, what: &str) {
    assert!(line.blocks.len() > 5, "{what}: nothing came");
    assert_eq!(line.damaged(), 0, "{what}: damaged frames");
    let mut headers = line.blocks.iter().map(|arrived| arrived.block.header);
    let mut due = None;
    assert!(
        headers.all(|header| {
            let follows = due.is_none_or(|due| due == header.first_scan);
            due = Some(header.first_scan + u64::from(header.scans));
            follows
        }),
        "{what}: a gap"
    );
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn streamed_values_are_those_of_the_streamed_counts_bit_for_bit_at_every_block()
-> anyhow::Result<()> {
    let mut board = on("values")?;
    let line = &mut board.line;
    let (_, set) = calibrate(line, &mut random())?;
    let calibrator = Calibrator::new(&set);
    line.stream(true, false)?;
    for block in BlockSize::ALL {
        let before = line.status()?.scans_lost;
        line.order(&Request::Block(block))?;
        let lost = line.status()?.scans_lost - before;
        // A pause of some milliseconds, and the scans of a block that was not full.
        assert!(lost < 40, "{lost} scans were lost");
        line.run_s(0.05)?;
        line.blocks.clear();
        line.run_s(0.5)?;
        assert_whole(line, &format!("{block:?}"));
        for arrived in &line.blocks {
            let header = &arrived.block.header;
            assert_eq!(usize::from(header.scans), block.scans().min(16));
            let counts = arrived.block.counts.as_ref().unwrap();
            for (scan, values) in counts.iter().zip(arrived.block.values.as_ref().unwrap()) {
                let expected = calibrator.apply(scan, header.supply).map(f32::to_bits);
                assert_eq!(values.map(f32::to_bits), expected);
            }
        }
    }
    let status = line.status()?;
    assert_eq!(status.events, Events::NONE);
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn counts_stream_in_every_block_at_every_rate_in_frames_that_the_line_carries() -> anyhow::Result<()>
{
    let counts = StreamContent {
        counts: true,
        values: false,
        pose: false,
    };
    for rate_hz in FACTS.rates_hz {
        let mut board = on(&format!("gathered-{rate_hz}"))?;
        let line = &mut board.line;
        line.order(&Request::Rate(rate_hz))?;
        line.stream(false, false)?;
        for block in BlockSize::ALL {
            line.order(&Request::Block(block))?;
            line.run_s(0.05)?;
            line.blocks.clear();
            line.run_s(1.0)?;
            let what = format!("{block:?} at {rate_hz} Hz");
            assert_whole(line, &what);
            let due = scans_of_frame(counts, rate_hz, block, FACTS.max_telemetry_bits_per_s());
            let scans = |arrived: &ArrivedBlock| usize::from(arrived.block.header.scans);
            let whole = line.blocks.iter().filter(|arrived| scans(arrived) == due);
            // With each of ten readings of the supply a frame may end early, and another at the end of the ring.
            assert!(whole.count() + 22 >= line.blocks.len(), "{what}");
            assert!(line.blocks.iter().all(|arrived| scans(arrived) <= due));
            let bytes: usize = line.blocks.iter().map(|arrived| arrived.bytes).sum();
            let stated = bits_per_second(counts, rate_hz, block, FACTS.max_telemetry_bits_per_s());
            assert!(bytes * 10 <= stated as usize + 10_000, "{what}: {bytes}");
        }
        let status = line.status()?;
        assert_eq!(status.events, Events::NONE);
    }
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_flood_of_requests_takes_nothing_from_the_stream_and_some_are_answered() -> anyhow::Result<()> {
    const FLOOD_S: u64 = 3;
    let mut board = on("flood")?;
    let line = &mut board.line;
    line.stream_everything()?;
    line.run_s(0.1)?;
    let before = line.status()?;
    let mut status = [0; MAX_FRAME];
    let length = encode_request(&Request::Status, 7, &mut status)?;
    // What the line carries in ten milliseconds.
    let wave: Vec<u8> = status[..length]
        .iter()
        .copied()
        .cycle()
        .take(FACTS.baud as usize / 1_000)
        .collect();
    let mut answers = 0;
    for _ in 0..100 * FLOOD_S {
        line.send_bytes(&wave)?;
        line.run(Duration::from_millis(10))?;
        while line.answer_to(7).is_some() {
            answers += 1;
        }
    }
    line.run_s(0.5)?;
    assert_whole(line, "flood");
    let after = line.status()?;
    assert_eq!(after.events.blocks_dropped, before.events.blocks_dropped);
    assert_eq!(after.scans_lost, before.scans_lost);
    let scans: u64 = line
        .blocks
        .iter()
        .map(|arrived| u64::from(arrived.block.header.scans))
        .sum();
    assert!(scans > 4_000 * FLOOD_S, "{scans} scans");
    // What the stream leaves of the line carries hundreds a second.
    println!("{answers} answers in {FLOOD_S} s, {:?}", after.events);
    assert!(answers > 100 * FLOOD_S, "{answers} answers");
    Ok(())
}

/// Virtual minutes of the test below by `HEXSENSE_MINUTES`, ten without it.
fn seconds() -> f64 {
    let minutes = std::env::var("HEXSENSE_MINUTES");
    60.0 * minutes.map_or(10.0, |minutes| minutes.parse::<f64>().unwrap())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn everything_at_four_kilohertz_loses_nothing() -> anyhow::Result<()> {
    let mut board = on("everything")?;
    let line = &mut board.line;
    calibrate(line, &mut random())?;
    line.order(&Request::Rate(4_000))?;
    let before = line.status()?;
    line.stream(false, true)?;
    for (analyser, frequency_hz) in [0.7, 1.9, 5.3].into_iter().enumerate() {
        let drive = Drive {
            increment: increment(frequency_hz, 4_000).unwrap(),
            block: BlockSize::Sixteen,
            settle_blocks: 10,
            blocks: 1 << 20,
        };
        let analyser = analyser as u8;
        line.order(&Request::Drive { analyser, drive })?;
    }
    let mut next = None;
    let end = line.now() + Duration::from_secs_f64(seconds());
    let mut poses = 0;
    while line.now() < end {
        line.run_s(0.1)?;
        for channel in 0..CHANNELS as u8 {
            let analyser = channel % 3;
            let report = line.ask(&Request::Sums { analyser, channel })?;
            assert!(matches!(report, Response::Sums { .. }));
        }
        line.status()?;
        for arrived in line.blocks.drain(..) {
            let header = arrived.block.header;
            assert_eq!(header.first_scan, *next.get_or_insert(header.first_scan));
            next = Some(header.first_scan + u64::from(header.scans));
        }
        assert!(line.poses.drain(..).all(|pose| {
            poses += 1;
            pose.outcome.is_ok()
        }));
    }
    let status = line.status()?;
    assert_eq!(status.scans_lost, before.scans_lost);
    assert_eq!(status.events, Events::NONE);
    assert!(f64::from(poses) > 90.0 * seconds(), "{poses} poses");
    Ok(())
}
