//! No sample is lost while coefficients are written.

use board_tests::key_holder::calibrate;
use hexsense_core::wire::Request;
use hexsense_core::wire::status::Events;

use crate::stream::assert_whole;
use crate::{on, random};

/// More than the archive holds, so that pages of both of its halves are erased.
const UPLOADS: u64 = 30;

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn no_scan_is_lost_at_four_kilohertz_while_sets_are_stored_and_pages_erased() -> anyhow::Result<()>
{
    let mut board = on("writes")?;
    let line = &mut board.line;
    line.order(&Request::Rate(4_000))?;
    let before = line.status()?;
    line.stream(false, false)?;
    line.run_s(0.1)?;
    let mut random = random();
    for _ in 0..UPLOADS {
        calibrate(line, &mut random)?;
    }
    line.run_s(0.1)?;
    let status = line.status()?;
    assert_whole(line, "uploads");
    let scans = line.blocks.iter().map(|arrived| arrived.block.header.scans);
    let scans: u64 = scans.map(u64::from).sum();
    println!("{scans} scans during {UPLOADS} uploads");
    assert!(scans > 4_000);
    assert_eq!(status.scans_lost, before.scans_lost);
    assert_eq!(status.events, Events::NONE);
    Ok(())
}
