//! The log by itself: its end is found again, it refuses entries when it is full, and spoilt places cost no entry.

use embassy_futures::block_on;
use hexsense_core::records::log::{ENTRY, End, Log, LogError};
use host_tests::nor_flash::{Nor, Torn};
use host_tests::sets::uploaded;

/// Two pages of 2,048 bytes have 102 places of 40 bytes; the last eight are the reserve.
const TAKEN: u32 = 94;

#[test]
fn a_full_log_takes_no_entry_and_keeps_those_it_has() {
    let mut nor = Nor::new(2);
    let range = nor.range();
    let mut log = Log::new(&mut nor, range);
    let mut end = End::default();
    for counter in 1..=TAKEN {
        assert!(log.has_room(&end), "for entry {counter}");
        block_on(log.append(&mut end, &uploaded(counter))).unwrap();
    }
    assert!(!log.has_room(&end));
    assert_eq!(
        block_on(log.append(&mut end, &uploaded(TAKEN + 1))),
        Err(LogError::Full)
    );
    assert_eq!(block_on(log.end()).unwrap(), end);
    let all: heapless::Vec<_, 200> = block_on(log.entries(&end, 1)).unwrap();
    assert!(all.iter().copied().eq((1..=TAKEN).map(uploaded)));
}

/// Flash behind the log's own range: the log begins and ends where its range does, also when the last places fail.
#[test]
fn no_entry_lies_outside_the_logs_range() {
    for reserve in 0..=9 {
        let mut nor = Nor::new(4);
        let range = 2_048..3 * 2_048;
        let mut end = End::default();
        let mut append = |nor: &mut Nor, counter| {
            block_on(Log::new(nor, range.clone()).append(&mut end, &uploaded(counter)))
        };
        (1..TAKEN).for_each(|counter| append(&mut nor, counter).unwrap());
        // From the place of the last entry on, so many places take nothing.
        let first = 2_048 + (TAKEN - 1) * 40;
        nor.worn_out = first..first + reserve * 40;
        let last = append(&mut nor, TAKEN);
        let expected = if reserve == 9 {
            Err(LogError::ReadBack)
        } else {
            Ok(())
        };
        assert_eq!(last, expected, "{reserve} places fail");
        if reserve < 9 {
            assert_eq!(append(&mut nor, TAKEN + 1), Err(LogError::Full));
        }
        let inside = 2_048..2_048 + 102 * 40;
        let outside = nor.bytes().iter().enumerate();
        let mut outside = outside.filter(|(at, _)| !inside.contains(at));
        assert!(outside.all(|(_, byte)| *byte == 0xFF));
    }
}

/// A place whose checksum does not match holds no entry: a flipped bit anywhere in it, and every unknown reason.
#[test]
fn an_entry_with_any_changed_bit_is_passed_over() {
    let mut nor = Nor::new(2);
    let range = nor.range();
    let mut end = End::default();
    for counter in 1..=3 {
        block_on(Log::new(&mut nor, range.clone()).append(&mut end, &uploaded(counter))).unwrap();
    }
    let whole = nor.bytes()[40..80].to_vec();
    // The last four bytes only fill up the last word.
    for bit in 0..36 * 8 {
        let mut changed = whole.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        nor.overwrite(40, &changed);
        let mut log = Log::new(&mut nor, range.clone());
        let found: heapless::Vec<_, 8> = block_on(log.entries(&end, 1)).unwrap();
        assert_eq!(found[..], [uploaded(1), uploaded(3)], "bit {bit}");
    }
}

/// After any number of power cuts in an append, the next complete append works.
#[test]
fn appends_that_are_cut_again_and_again_spoil_only_their_own_places() {
    for torn in [
        Torn::Nothing,
        Torn::SomeBits,
        Torn::Garbage,
        Torn::Everything,
    ] {
        let mut nor = Nor::new(16);
        nor.reports = false;
        let mut written = 0;
        for round in 0..200_u64 {
            nor.cut_after(round as u32 % 5, torn, round);
            let range = nor.range();
            let mut log = Log::new(&mut nor, range);
            let mut end = block_on(log.end()).unwrap();
            assert_eq!(end.last_counter(), written);
            let _ = block_on(log.append(&mut end, &uploaded(written + 1)));
            nor.power_on();
            let range = nor.range();
            let mut log = Log::new(&mut nor, range);
            let mut end = block_on(log.end()).unwrap();
            assert!(
                [written, written + 1].contains(&end.last_counter()),
                "{torn:?}"
            );
            written = end.last_counter();
            if round % 40 == 39 {
                written += 1;
                block_on(log.append(&mut end, &uploaded(written))).unwrap();
            }
        }
        let range = nor.range();
        let mut log = Log::new(&mut nor, range);
        let end = block_on(log.end()).unwrap();
        let all: heapless::Vec<_, 500> = block_on(log.entries(&end, 1)).unwrap();
        assert!(
            all.iter().copied().eq((1..=written).map(uploaded)),
            "{torn:?}"
        );
    }
}

/// A word that a power cut left half programmed may look erased and take nothing.
#[test]
fn up_to_eight_places_in_a_row_that_look_erased_and_take_nothing_are_passed_over() {
    for spoilt in 1..=9 {
        let mut nor = Nor::new(2);
        let range = nor.range();
        let mut end = End::default();
        let mut append = |nor: &mut Nor, counter| {
            block_on(Log::new(nor, range.clone()).append(&mut end, &uploaded(counter)))
        };
        append(&mut nor, 1).unwrap();
        append(&mut nor, 2).unwrap();
        nor.worn_out = (2 * ENTRY) as u32..((2 + spoilt) * ENTRY) as u32;
        let third = append(&mut nor, 3);
        if spoilt == 9 {
            assert_eq!(third, Err(LogError::ReadBack));
            continue;
        }
        third.unwrap();
        append(&mut nor, 4).unwrap();
        let mut log = Log::new(&mut nor, range.clone());
        assert_eq!(block_on(log.end()).unwrap(), end, "{spoilt} places");
        let all: heapless::Vec<_, 8> = block_on(log.entries(&end, 1)).unwrap();
        assert!(all.iter().copied().eq((1..=4).map(uploaded)));
    }
}
