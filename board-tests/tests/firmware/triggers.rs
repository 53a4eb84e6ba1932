//! The sampling instants do not know what else the board does.

use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::Request;

use crate::bench::Board;
use crate::set::upload;

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn the_interval_of_triggers_is_constant_under_every_load() {
    let mut board = Board::on("triggers");
    let mut periods = Vec::new();
    for rate_hz in [1_000, 2_000, 4_000] {
        board.order(&Request::Rate(rate_hz));
        periods.push(150_000_000 / u64::from(rate_hz));
        board.stream(false, false);
        // Pages are erased, and code runs from the other bank.
        for unix_s in 0..3 {
            upload(&mut board, unix_s);
        }
        // As many requests in a row as the receiver's ring holds.
        for _ in 0..3 {
            for _ in 0..20 {
                board.send(&Request::Identity);
            }
            board.run_s(0.2);
        }
    }
    board.order(&Request::Rate(1_000));
    for block in BlockSize::ALL {
        board.order(&Request::Block(block));
        board.run_s(0.2);
        periods.push(150_000);
    }
    let status = board.status();
    assert_eq!(status.events.converter_faults(), 0);
    let runs = board.triggers();
    // The board begins at 1 kHz and sixteen scans, and every order starts the converters anew.
    for run in runs.iter().filter(|run| run.count > 1) {
        assert_eq!(run.min_cycles, run.max_cycles, "{runs:?}");
    }
    let found: Vec<u64> = runs.iter().map(|run| run.min_cycles).collect();
    assert!(periods.iter().all(|period| found.contains(period)));
    assert!(runs.iter().map(|run| run.count).sum::<u64>() >= status.scans);
}
