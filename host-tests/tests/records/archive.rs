//! The archive while the power lasts.

use embassy_futures::block_on;
use hexsense_core::records::{Archive, ArchiveError, CoefficientSet, RecordError};

use host_tests::nor_flash::{Nor, PAGE};
use host_tests::sets::{BOARD, encoded, numbered, uploaded};

use crate::appends::{PAGES, append, newest};

#[test]
fn an_empty_archive_has_no_set_and_reading_it_changes_nothing() {
    let mut nor = Nor::new(PAGES);
    assert_eq!(newest(&mut nor), None);
    assert_eq!(nor.operations, 0);
}

#[test]
fn the_last_set_appended_is_the_newest_however_many_came_before() {
    let mut nor = Nor::new(PAGES);
    for number in 1..=100 {
        let stored = append(&mut nor, number).unwrap();
        let bytes = encoded(&numbered(number));
        assert_eq!(
            (stored.entry, stored.id, usize::from(stored.length)),
            (uploaded(number), CoefficientSet::id_of(&bytes), bytes.len())
        );
        assert_eq!(stored.made_unix_s, numbered(number).unix_s);
        assert_eq!(newest(&mut nor), Some((stored, numbered(number))));
    }
}

#[test]
fn pages_wear_evenly() {
    let mut nor = Nor::new(PAGES);
    for number in 1..=320 {
        append(&mut nor, number).unwrap();
    }
    assert_eq!(nor.erasures, [40; PAGES]);
}

#[test]
fn the_active_set_is_never_overwritten_however_old_it_is() {
    let mut nor = Nor::new(PAGES);
    let pinned = append(&mut nor, 1).unwrap();
    for number in 2..=30 {
        let (entry, set) = (uploaded(number), encoded(&numbered(number)));
        let mut archive = Archive::new(&mut nor, 0);
        block_on(archive.append(&entry, &set, Some(pinned.slot), &BOARD)).unwrap();
        let history = archive.history(0).unwrap();
        assert_eq!(history.last(), Some(&pinned));
        assert_eq!(history.len(), 8.min(number as usize));
    }
}

#[test]
fn a_page_that_is_worn_out_is_passed_over() {
    let mut nor = Nor::new(PAGES);
    for number in 1..=3 {
        append(&mut nor, number).unwrap();
    }
    nor.worn_out = 3 * PAGE as u32..4 * PAGE as u32;
    for number in 4..=30 {
        append(&mut nor, number).unwrap();
        let (newest, _) = newest(&mut nor).unwrap();
        assert_eq!(newest.entry, uploaded(number));
    }
}

#[test]
fn bytes_that_are_not_a_set_of_this_board_are_refused_and_nothing_is_written() {
    let mut nor = Nor::new(PAGES);
    append(&mut nor, 1).unwrap();
    let (before, operations) = (newest(&mut nor), nor.operations);
    let mut damaged = encoded(&numbered(2));
    damaged[40] ^= 1;
    let mut archive = Archive::new(&mut nor, 0);
    for bytes in [&damaged[..], &[], &[0; 700]] {
        let refused = block_on(archive.append(&uploaded(2), bytes, Some(0), &BOARD));
        let expected = CoefficientSet::decode(bytes).unwrap_err();
        assert_eq!(refused, Err(ArchiveError::Record(expected)));
    }
    assert!(matches!(
        block_on(archive.append(&uploaded(2), &damaged, Some(0), &BOARD)),
        Err(ArchiveError::Record(RecordError::Checksum { .. }))
    ));
    let (entry, good) = (uploaded(2), encoded(&numbered(2)));
    let foreign = block_on(archive.append(&entry, &good, Some(0), &[8; 12]));
    assert_eq!(foreign, Err(ArchiveError::OtherBoard));
    assert_eq!((newest(&mut nor), nor.operations), (before, operations));
}

#[test]
fn a_set_that_does_not_read_back_is_refused_and_the_newest_stays() {
    for stored in [5, 20] {
        let mut nor = Nor::new(PAGES);
        for number in 1..=stored {
            append(&mut nor, number).unwrap();
        }
        nor.worn_out = nor.range();
        let mut archive = Archive::new(&mut nor, 0);
        let refused = block_on(archive.append(
            &uploaded(stored + 1),
            &encoded(&numbered(stored + 1)),
            Some(0),
            &BOARD,
        ));
        assert_eq!(refused, Err(ArchiveError::ReadBack), "after {stored}");
        let (_, newest) = newest(&mut nor).unwrap();
        assert_eq!(newest, numbered(stored));
    }
}

#[test]
fn the_last_eight_are_kept_newest_first_and_none_from_before_a_reset() {
    let mut nor = Nor::new(PAGES);
    for number in 1..=30 {
        append(&mut nor, number).unwrap();
        let mut archive = Archive::new(&mut nor, 0);
        let mut kept = |after| {
            let kept = archive.history(after).unwrap();
            kept.iter()
                .map(|kept| kept.entry.counter)
                .collect::<Vec<_>>()
        };
        let expected: Vec<_> = (number.saturating_sub(7).max(1)..=number).rev().collect();
        assert_eq!(kept(0), expected);
        assert_eq!(kept(number - 1), [number]);
        assert!(kept(number).is_empty());
    }
}
