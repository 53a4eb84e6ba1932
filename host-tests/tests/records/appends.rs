//! An archive to which numbered sets are appended one after another.

use embassy_futures::block_on;
use hexsense_core::records::{Archive, CoefficientSet, Stored};
use host_tests::nor_flash::Nor;
use host_tests::sets::{BOARD, encoded, numbered, uploaded};

/// Pages that the board gives to the archive.
pub const PAGES: usize = 8;

/// Appends set `number` in place of the newest; none when the power goes.
pub fn append(nor: &mut Nor, number: u32) -> Option<Stored> {
    let mut archive = Archive::new(nor, 0);
    let active = archive.history(0).ok()?;
    let active = active.first().map(|newest| newest.slot);
    let set = encoded(&numbered(number));
    let appended = block_on(archive.append(&uploaded(number), &set, active, &BOARD));
    Some(appended.ok()?.0)
}

/// The newest set and its place.
pub fn newest(nor: &mut Nor) -> Option<(Stored, CoefficientSet)> {
    let mut archive = Archive::new(nor, 0);
    let history = archive
        .history(0)
        .expect("it can be read after any power cut");
    let newest = *history.first()?;
    let set = archive
        .read(newest.slot, newest.id)
        .expect("it can be read after any power cut");
    Some((newest, set.expect("what history tells can be read")))
}
