//! The archive while the power lasts.

use embassy_futures::block_on;
use hexsense::store::{Archive, ArchiveError, CoefficientSet, RecordError, Stored};

use host_tests::nor_flash::{Nor, PAGE};
use host_tests::sets::{encoded, numbered, uploaded};

/// Pages that the board gives to the archive.
const PAGES: usize = 8;

fn append(nor: &mut Nor, number: u32) -> Stored {
    let range = nor.range();
    let mut archive = Archive::new(nor, range).unwrap();
    let active = block_on(archive.history(0)).unwrap();
    let active = active.first().map(|newest| newest.slot);
    block_on(archive.append(&uploaded(number), &encoded(&numbered(number)), active)).unwrap()
}

fn newest(nor: &mut Nor) -> Option<(Stored, CoefficientSet)> {
    let range = nor.range();
    let mut archive = Archive::new(nor, range).unwrap();
    let newest = *block_on(archive.history(0)).unwrap().first()?;
    let set = block_on(archive.read(newest.slot)).unwrap();
    Some((newest, set.expect("what history tells can be read")))
}

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
        let stored = append(&mut nor, number);
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
fn pages_wear_evenly_and_slowly() {
    let mut nor = Nor::new(PAGES);
    for number in 1..=320 {
        append(&mut nor, number);
    }
    let (least, most) = (nor.erasures.iter().min(), nor.erasures.iter().max());
    // Three sets to a page: 320 appends fill 106 pages, thirteen times each of the eight.
    assert!(
        least >= Some(&12) && most <= Some(&14),
        "{:?}",
        nor.erasures
    );
}

#[test]
fn bytes_that_are_no_set_are_refused_and_nothing_is_written() {
    let mut nor = Nor::new(PAGES);
    append(&mut nor, 1);
    let (before, operations) = (newest(&mut nor), nor.operations);
    let mut damaged = encoded(&numbered(2));
    damaged[40] ^= 1;
    let range = nor.range();
    let mut archive = Archive::new(&mut nor, range).unwrap();
    for bytes in [&damaged[..], &[], &[0; 700]] {
        let refused = block_on(archive.append(&uploaded(2), bytes, Some(0)));
        let expected = CoefficientSet::decode(bytes).unwrap_err();
        assert_eq!(refused, Err(ArchiveError::Record(expected)));
    }
    assert!(matches!(
        block_on(archive.append(&uploaded(2), &damaged, Some(0))),
        Err(ArchiveError::Record(RecordError::Checksum { .. }))
    ));
    assert_eq!((newest(&mut nor), nor.operations), (before, operations));
}

#[test]
fn a_range_that_cannot_hold_eight_sets_is_refused() {
    let page = PAGE as u32;
    let ranges = [
        0..0,
        0..page,
        0..2 * page,
        1..8 * page,
        0..8 * page - 8,
        8 * page..0,
    ];
    for range in ranges {
        let refused = Archive::new(Nor::new(PAGES), range.clone()).err();
        assert_eq!(refused, Some(ArchiveError::Range), "{range:?}");
    }
}

#[test]
fn the_smallest_range_that_is_accepted_never_fills_up() {
    let accepted = |pages: &usize| {
        let nor = Nor::new(*pages);
        let range = nor.range();
        Archive::new(nor, range).is_ok()
    };
    let pages = (1..=PAGES).find(accepted).unwrap();
    let mut nor = Nor::new(pages);
    for number in 1..=100 {
        assert_eq!(append(&mut nor, number).entry.counter, number);
    }
}

#[test]
fn a_set_that_does_not_read_back_is_refused_and_the_newest_stays() {
    for stored in [5, 20] {
        let mut nor = Nor::new(PAGES);
        for number in 1..=stored {
            append(&mut nor, number);
        }
        nor.worn_out = nor.range();
        let range = nor.range();
        let mut archive = Archive::new(&mut nor, range).unwrap();
        let refused = block_on(archive.append(
            &uploaded(stored + 1),
            &encoded(&numbered(stored + 1)),
            Some(0),
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
        append(&mut nor, number);
        let range = nor.range();
        let mut archive = Archive::new(&mut nor, range).unwrap();
        let mut kept = |after| {
            let kept = block_on(archive.history(after)).unwrap();
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
