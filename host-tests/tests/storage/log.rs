//! The log by itself: its end is found again, it refuses entries when it is full, and spoilt places cost no entry.

use embassy_futures::block_on;
use hexsense_core::records::log::{ENTRY, End, Log, LogError};
use host_tests::nor_flash::{Nor, Torn};
use host_tests::sets::uploaded;

#[test]
fn a_full_log_takes_no_entry_and_keeps_those_it_has() {
    let mut nor = Nor::new(2);
    let range = nor.range();
    let mut log = Log::new(&mut nor, range);
    let mut end = End::default();
    let mut taken = 0;
    while log.has_room(&end) {
        taken += 1;
        block_on(log.append(&mut end, &uploaded(taken))).unwrap();
    }
    assert!(taken as usize > 2 * 2_048 / ENTRY - 10, "{taken} entries");
    assert_eq!(
        block_on(log.append(&mut end, &uploaded(taken + 1))),
        Err(LogError::Full)
    );
    assert_eq!(block_on(log.end()).unwrap(), end);
    let all: heapless::Vec<_, 200> = block_on(log.entries(&end, 1)).unwrap();
    assert!(all.iter().copied().eq((1..=taken).map(uploaded)));
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
