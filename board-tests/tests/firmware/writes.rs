//! No sample is lost while coefficients are written.

use hexsense_core::wire::Request;
use hexsense_core::wire::status::Events;

use crate::bench::Board;
use crate::set::upload;

/// More than the archive holds, so that pages of both of its halves are erased.
const UPLOADS: u64 = 30;

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn no_scan_is_lost_at_four_kilohertz_while_sets_are_stored_and_pages_erased() {
    let mut board = Board::on("writes");
    board.order(&Request::Rate(4_000));
    let before = board.status();
    board.stream(false, false);
    board.run_s(0.1);
    for unix_s in 0..UPLOADS {
        upload(&mut board, unix_s);
    }
    board.run_s(0.1);
    let status = board.status();
    let first = board.blocks[0].block.header.first_scan;
    let mut next = first;
    for arrived in &board.blocks {
        let header = arrived.block.header;
        assert_eq!(header.first_scan, next, "a gap");
        next += u64::from(header.scans);
    }
    println!("{} scans during {UPLOADS} uploads", next - first);
    assert!(next - first > 4_000);
    assert_eq!(status.scans_lost, before.scans_lost);
    assert_eq!(status.events, Events::NONE);
}
