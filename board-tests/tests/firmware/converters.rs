//! The counts of each channel are those of its own pin, whatever happens to DMA, and their offset stays the same until the
//! power goes.

use std::collections::BTreeSet;
use std::time::Duration;

use board_tests::bench::Board;
use board_tests::pins::{Pins, STEP_V};
use board_tests::power::Power;
use hexsense_core::channel::{CHANNELS, Scan};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::{Request, StreamContent};
use serde_json::{Value, json};

use crate::bench;

/// Half of the step from one channel to the next, counts.
const NEAR: f64 = STEP_V / 3.3 * 65_536.0 / 2.0;

/// A board with a steady voltage on each pin, to which these faults come.
fn on(name: &str, faults: &[Value]) -> anyhow::Result<(Pins, Board)> {
    let pins = Pins::steady()?;
    let process = bench(name)?.start(&Power {
        pins: Some(pins.address()),
        faults,
        ..Power::default()
    })?;
    Ok((pins, Board::connect(process)?))
}

/// The scans that have arrived.
fn scans(board: &mut Board) -> Vec<Scan> {
    let blocks = board.line.blocks.drain(..);
    blocks
        .flat_map(|arrived| arrived.block.counts.unwrap_or_default())
        .collect()
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn no_count_has_the_name_of_another_channel_after_dma_has_slipped() -> anyhow::Result<()> {
    let slip = |number: usize| {
        let result = ["lost", "twice"][number % 2];
        json!({
            "at_s": 0.2 + 0.05 * number as f64 + 0.000_031 * number as f64,
            "fault": "dma_slip", "adc": number / 2 % 2 + 1, "result": result,
        })
    };
    let slips: Vec<_> = (0..24).map(slip).collect();
    for rate_hz in [1_000, 4_000] {
        let (_pins, mut board) = on(&format!("slips-{rate_hz}"), &slips)?;
        board.line.stream_everything()?;
        board.line.order(&Request::Rate(rate_hz))?;
        board.line.run_until(Duration::from_millis(1_600))?;
        let scans = scans(&mut board);
        assert!(scans.len() > rate_hz as usize, "{} scans", scans.len());
        for scan in scans {
            for (channel, count) in scan.iter().enumerate().take(CHANNELS) {
                let expected = (channel + 1) as f64 * 2.0 * NEAR;
                assert!((f64::from(*count) - expected).abs() < NEAR, "{scan:?}");
            }
        }
        let events = board.line.status()?.events;
        assert_eq!(events.slips.count, 24, "{events:?}");
        assert_eq!(events.converter_faults(), 24, "{events:?}");
    }
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn no_offset_steps_when_the_converters_start_anew_or_the_board_is_reset() -> anyhow::Result<()> {
    const RESET_S: f64 = 3.0;
    let resets =
        [0.0, 0.5, 1.0].map(|later_s| json!({"at_s": RESET_S + later_s, "fault": "pin_reset"}));
    let (_pins, mut board) = on("self-calibration", &resets)?;
    let mut all = BTreeSet::new();
    let mut look = |board: &mut Board| -> anyhow::Result<()> {
        board.line.blocks.clear();
        board.line.stream(false, false)?;
        board.line.run_s(0.05)?;
        board
            .line
            .order(&Request::Stream(StreamContent::default()))?;
        for arrived in board.line.blocks.drain(..) {
            let supply = arrived.block.header.supply.to_bits();
            let counts = arrived.block.counts.unwrap_or_default();
            all.extend(counts.into_iter().map(|scan| (scan, supply)));
        }
        Ok(())
    };
    for rate_hz in [1_000, 2_000, 4_000] {
        for block in BlockSize::ALL {
            board.line.order(&Request::Rate(rate_hz))?;
            board.line.order(&Request::Block(block))?;
            look(&mut board)?;
        }
    }
    for reset in 1..=resets.len() {
        board
            .line
            .run_until(Duration::from_secs_f64(RESET_S + 0.5 * reset as f64 - 0.1))?;
        look(&mut board)?;
        assert_eq!(board.line.status()?.resets.pin, reset as u32);
    }
    // Without noise every scan is the same.
    assert_eq!(all.len(), 1, "{all:?}");
    Ok(())
}
