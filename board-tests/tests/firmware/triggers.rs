//! The sampling instants do not depend on what else the board does.

use board_tests::key_holder::calibrate;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::Request;

use crate::{on_counting, random};

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn the_interval_of_triggers_is_constant_under_every_load() -> anyhow::Result<()> {
    let mut board = on_counting("triggers")?;
    let line = &mut board.line;
    let mut random = random();
    let mut periods = Vec::new();
    for rate_hz in [1_000, 2_000, 4_000] {
        line.order(&Request::Rate(rate_hz))?;
        periods.push(150_000_000 / u64::from(rate_hz));
        line.stream(false, false)?;
        // Pages are erased, and code runs from the other bank.
        for _ in 0..3 {
            calibrate(line, &mut random)?;
        }
        // As many requests in a row as the receiver's ring holds.
        for _ in 0..3 {
            for _ in 0..20 {
                line.send(&Request::Identity)?;
            }
            line.run_s(0.2)?;
        }
    }
    line.order(&Request::Rate(1_000))?;
    for block in BlockSize::ALL {
        line.order(&Request::Block(block))?;
        line.run_s(0.2)?;
        periods.push(150_000);
    }
    let status = line.status()?;
    assert_eq!(status.events.converter_faults(), 0);
    let runs = board.leave()?.triggers;
    // The board begins at 1 kHz and sixteen scans, and every order starts the converters anew.
    for run in runs.iter().filter(|run| run.count > 1) {
        assert_eq!(run.min_cycles, run.max_cycles, "{runs:?}");
    }
    let found: Vec<u64> = runs.iter().map(|run| run.min_cycles).collect();
    assert!(periods.iter().all(|period| found.contains(period)));
    assert!(runs.iter().map(|run| run.count).sum::<u64>() >= status.scans);
    Ok(())
}
