//! From the trigger of a block's last scan to its calibrated values, and to its first bit on the line.

use anyhow::Context;
use board_tests::key_holder::calibrate;
use hexsense::{CORE_HZ, FACTS};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::Request;

use crate::{on_counting, random};

/// Prints a row for each block: `cargo test -p board-tests --test firmware -- --ignored --nocapture latency`.
#[test]
#[ignore = "needs the firmware and the virtual board"]
fn values_exist_a_tenth_of_a_millisecond_after_the_last_conversion() -> anyhow::Result<()> {
    println!("| block | values, µs | path, cycles | first bit, µs: least | most |");
    for block in BlockSize::ALL {
        let mut board = on_counting(&format!("latency-{}", block.scans()))?;
        let line = &mut board.line;
        calibrate(line, &mut random())?;
        line.stream(false, false)?;
        line.blocks.clear();
        line.order(&Request::Block(block))?;
        line.run_s(1.0)?;
        let cycles = line.status()?.path_cycles;
        let mut blocks = std::mem::take(&mut line.blocks);
        // The converters' last run begins after the last gap.
        let follows = |place: &usize| {
            let [before, after] = [place - 1, *place].map(|place| &blocks[place].block.header);
            after.first_scan == before.first_scan + u64::from(before.scans)
        };
        let first = (1..blocks.len()).rev().find(|place| !follows(place));
        blocks.drain(..first.unwrap_or(0));
        let triggers = board.leave()?.triggers;
        let run = triggers.last().context("no triggers were counted")?;
        let first_scan = blocks[0].block.header.first_scan;
        let late = blocks.iter().map(|arrived| {
            let header = arrived.block.header;
            let last = header.first_scan + u64::from(header.scans) - 1;
            let trigger_us = run.first_ns as f64 * 1e-3 + (last - first_scan) as f64 * 1e3;
            arrived.at.as_secs_f64() * 1e6 - arrived.bytes as f64 * 5.0 - trigger_us
        });
        let least = late.clone().fold(f64::INFINITY, f64::min);
        let most = late.fold(f64::NEG_INFINITY, f64::max);
        let path_us = f64::from(cycles.max) * 1e6 / f64::from(CORE_HZ);
        let value_us = 9.0 * f64::from(FACTS.rank_ns) * 1e-3 + path_us;
        println!(
            "| {} | {value_us:.1} | {} to {} | {least:.0} | {most:.0} |",
            block.scans(),
            cycles.min,
            cycles.max
        );
        assert!(path_us < 100.0, "{block:?}: {path_us} µs");
    }
    Ok(())
}
