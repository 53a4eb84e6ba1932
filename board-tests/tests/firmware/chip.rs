//! The chip as it is: used as its manual asks, halted by a debugger, logging to a probe that does not read.

use board_tests::key_holder::calibrate;
use hexsense_core::wire::Request;
use serde_json::json;

use crate::{bench, random, run_until_s};

/// How the virtual board begins a line that is no entry of the firmware's log.
const BOARD: &str = "] board: ";

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn nothing_is_done_that_the_manual_of_the_chip_forbids() -> anyhow::Result<()> {
    let bench = bench("remarks")?;
    let mut board = bench.on(&[])?;
    let line = &mut board.line;
    calibrate(line, &mut random())?;
    line.order(&Request::Rate(4_000))?;
    line.stream(false, false)?;
    line.run_s(0.5)?;
    drop(board);
    let log = bench.log();
    let remarks: Vec<&str> = log.lines().filter(|line| line.contains(BOARD)).collect();
    assert!(log.contains("clock"), "there is no log: {log}");
    assert_eq!(remarks, [""; 0]);
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_core_that_a_debugger_halts_is_not_reset() -> anyhow::Result<()> {
    let halt = json!({"at_s": 0.5, "fault": "halt", "duration_us": 3_000_000});
    let mut board = bench("halt")?.on(&[halt])?;
    let line = &mut board.line;
    run_until_s(line, 4.0)?;
    let before = line.status()?;
    assert_eq!(before.resets.starts, 1, "{:?}", before.resets);
    line.run_s(0.5)?;
    let after = line.status()?;
    assert!(after.scans > before.scans + 400, "it does not sample on");
    assert_eq!(after.resets.starts, 1);
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_full_log_that_no_probe_reads_holds_up_nothing() -> anyhow::Result<()> {
    // Every overrun of the converters is logged; the log has room for some ten entries.
    const STALLS: u32 = 40;
    const OVERRUNS: u32 = 20;
    let mut faults = vec![json!({"at_s": 0.5, "fault": "log_unread"})];
    faults.extend((0..STALLS).map(|number| {
        json!({
            "at_s": 0.6 + 0.05 * f64::from(number),
            "fault": "dma_stall",
            "of": "converters",
            "duration_us": 2_000,
        })
    }));
    let mut board = bench("log")?.on(&faults)?;
    run_until_s(&mut board.line, 4.0)?;
    let status = board.line.status()?;
    assert_eq!(status.resets.starts, 1, "{:?}", status.resets);
    assert!(
        status.events.overruns.count >= OVERRUNS,
        "{:?}",
        status.events
    );
    Ok(())
}
