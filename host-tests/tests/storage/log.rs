//! The log by itself: its end is found again in a few reads, it refuses entries when it is full, and spoilt places cost no
//! entry.

use embassy_futures::block_on;
use hexsense_core::records::log::{ENTRY, End, Entry, Log, LogError, Reason};
use hexsense_core::records::{BuildId, SetId};
use host_tests::nor_flash::{Nor, PAGE, Torn};
use host_tests::sets::uploaded;

/// Of three pages of 2,048 bytes one stays free. Two have 64 places of 64 bytes, of which eight are for places that fail
/// and sixteen for new keys.
const TAKEN: u32 = 40;

/// The next entry of this kind.
fn next(end: &End, reason: Reason, page: u16) -> Entry {
    Entry {
        counter: end.next_counter(),
        reason,
        chain: end.head(),
        page,
        ..uploaded(1)
    }
}

/// Appends an entry of this kind; the first of a volume where the log wants it.
fn append(nor: &mut Nor, end: &mut End, reason: Reason) -> Result<(), LogError> {
    let range = nor.range();
    let mut log = Log::new(nor, range);
    let page = match reason {
        Reason::NewVolume => log.next_page(end),
        _ => end.page(),
    };
    let entry = next(end, reason, page);
    block_on(log.append(end, &entry))
}

fn found(nor: &mut Nor) -> End {
    let range = nor.range();
    Log::new(nor, range).end().unwrap()
}

/// The counters of the volume.
fn counters(nor: &mut Nor, end: &End, from: u32) -> Vec<u32> {
    let range = nor.range();
    let all: heapless::Vec<_, 300> = Log::new(nor, range).entries(end, from).unwrap();
    all.iter().map(|entry| entry.counter).collect()
}

#[test]
fn a_full_volume_takes_new_keys_a_while_longer_and_a_new_volume_always() {
    let (mut nor, mut end) = (Nor::new(3), End::default());
    for counter in 1..=TAKEN {
        append(&mut nor, &mut end, Reason::Upload)
            .unwrap_or_else(|error| panic!("entry {counter}: {error}"));
    }
    for reason in [Reason::Upload, Reason::Rollback, Reason::FactoryReset] {
        let full = append(&mut nor, &mut end, reason);
        assert_eq!(full, Err(LogError::Full), "{reason:?}");
    }
    for own in [Reason::Fallback, Reason::FirmwareChange].repeat(4) {
        append(&mut nor, &mut end, own).unwrap();
    }
    let full = append(&mut nor, &mut end, Reason::FirmwareChange);
    assert_eq!(full, Err(LogError::Full));
    for _ in 0..8 {
        append(&mut nor, &mut end, Reason::Provision).unwrap();
    }
    let full = append(&mut nor, &mut end, Reason::Provision);
    assert_eq!(full, Err(LogError::Full));
    assert_eq!(found(&mut nor), end);
    assert!(counters(&mut nor, &end, 1).into_iter().eq(1..=TAKEN + 16));
    append(&mut nor, &mut end, Reason::NewVolume).unwrap();
    assert_eq!(found(&mut nor), end);
    assert_eq!(counters(&mut nor, &end, 1), [TAKEN + 17]);
    append(&mut nor, &mut end, Reason::Upload).unwrap();
}

/// Volumes of any length, one after another, round and round the ring: at every entry the end is found, and the volume is
/// whole.
#[test]
fn the_end_is_found_at_every_entry_of_every_volume() {
    for pages in [2, 3, 5, 8] {
        let (mut nor, mut end) = (Nor::new(pages), End::default());
        let most = (pages - 1) * 32 - 24;
        for volume in 0..3 * pages {
            let first = end.next_counter();
            let length = [most, 1, most / 3, most / 2, most - 1][volume % 5];
            for entry in 0..length {
                let reason = match (volume, entry) {
                    (1.., 0) => Reason::NewVolume,
                    _ => Reason::Upload,
                };
                append(&mut nor, &mut end, reason).unwrap();
                assert_eq!(found(&mut nor), end, "{pages} pages, volume {volume}");
            }
            let whole = first..end.next_counter();
            assert!(counters(&mut nor, &end, 1).into_iter().eq(whole));
            let last = end.last_counter();
            assert_eq!(counters(&mut nor, &end, last), [last]);
        }
    }
}

/// The log of the board has 118 pages. Nine places of a page are looked at, and all of the last one.
#[test]
fn the_end_is_found_in_a_few_reads_at_any_level() {
    let (mut nor, mut end) = (Nor::new(118), End::default());
    for level in 1..=3_720_u32 {
        append(&mut nor, &mut end, Reason::Upload).unwrap();
        if level.is_multiple_of(37) || level > 3_700 {
            nor.reads = 0;
            assert_eq!(found(&mut nor), end);
            assert!(nor.reads <= 140, "{} reads at level {level}", nor.reads);
        }
    }
}

/// Whatever else lies in the pages, the log erases it when it comes to it.
#[test]
fn foreign_content_takes_no_place() {
    let (mut nor, mut end) = (Nor::new(3), End::default());
    let foreign: Vec<u8> = (0..3 * PAGE).map(|at| (at * 31 % 251) as u8).collect();
    nor.overwrite(0, &foreign);
    assert_eq!(found(&mut nor), end);
    for _ in 0..TAKEN {
        append(&mut nor, &mut end, Reason::Upload).unwrap();
        assert_eq!(found(&mut nor), end);
    }
}

#[test]
fn a_page_that_is_lost_hides_no_page_behind_it() {
    let (mut nor, mut end) = (Nor::new(8), End::default());
    (0..200).for_each(|_| append(&mut nor, &mut end, Reason::Upload).unwrap());
    for page in 0..6 {
        let mut lost = nor.clone();
        lost.overwrite(page * PAGE, &[0x5A; PAGE]);
        assert_eq!(found(&mut lost).last, end.last, "page {page}");
    }
}

/// Flash behind the log's own range: the log begins and ends where its range does, also when the last places fail.
#[test]
fn no_entry_lies_outside_the_logs_range() {
    let mut nor = Nor::new(5);
    let range = 2_048..4 * 2_048;
    let mut end = End::default();
    for volume in 0..7 {
        let mut log = Log::new(&mut nor, range.clone());
        if volume > 0 {
            let first = next(&end, Reason::NewVolume, log.next_page(&end));
            block_on(log.append(&mut end, &first)).unwrap();
        }
        while log.has_room(&end, Reason::Provision) {
            let entry = next(&end, Reason::Provision, end.page());
            block_on(log.append(&mut end, &entry)).unwrap();
        }
    }
    let outside = nor.bytes().iter().enumerate();
    let mut outside = outside.filter(|(at, _)| !(2_048..4 * 2_048).contains(at));
    assert!(outside.all(|(_, byte)| *byte == 0xFF));
}

/// A place whose checksum does not match holds no entry: a flipped bit anywhere in it, and every unknown reason.
#[test]
fn an_entry_with_any_changed_bit_is_passed_over() {
    let (mut nor, mut end) = (Nor::new(3), End::default());
    (0..3).for_each(|_| append(&mut nor, &mut end, Reason::Provision).unwrap());
    let whole = nor.bytes()[64..128].to_vec();
    for bit in 0..64 * 8 {
        let mut changed = whole.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        nor.overwrite(64, &changed);
        assert_eq!(counters(&mut nor, &end, 1), [1, 3], "bit {bit}");
    }
}

/// Bits that no entry has, under a checksum that matches: unused flags, and an identity that is said not to be there.
#[test]
fn what_no_entry_encodes_to_is_no_entry() {
    let (mut nor, mut end) = (Nor::new(3), End::default());
    (0..3).for_each(|_| append(&mut nor, &mut end, Reason::Provision).unwrap());
    let whole = nor.bytes()[64..128].to_vec();
    // The entries have no set before.
    for (byte, bit) in [(5, 2), (5, 7), (24, 0), (31, 7)] {
        let mut changed = whole.clone();
        changed[byte] ^= 1 << bit;
        let sum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&changed[..60]);
        changed[60..].copy_from_slice(&sum.to_le_bytes());
        nor.overwrite(64, &changed);
        assert_eq!(counters(&mut nor, &end, 1), [1, 3], "byte {byte}");
    }
}

/// Computed with Python's `struct` and `hashlib`.
#[test]
fn the_hash_of_an_entry_is_the_one_that_others_compute() {
    let entry = Entry {
        counter: 0x0102_0304,
        reason: Reason::FirmwareChange,
        unix_s: 0x1112_1314_1516_1718,
        id: Some(SetId([0x21; 8])),
        previous: Some(SetId([0x31; 8])),
        build: BuildId([0x41; 8]),
        chain: std::array::from_fn(|index| 0x50 + index as u8),
        reset: 0x6162_6364,
        page: 0x0605,
    };
    let hex = |byte: &u8| format!("{byte:02x}");
    let hex: String = entry.hash().iter().map(hex).collect();
    assert_eq!(hex, "e92b9e4a30b2cce418e3ae3708e82400");
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
            let mut end = log.end().unwrap();
            assert_eq!(end.last_counter(), written);
            let _ = block_on(log.append(&mut end, &uploaded(written + 1)));
            nor.power_on();
            let range = nor.range();
            let mut log = Log::new(&mut nor, range);
            let mut end = log.end().unwrap();
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
        let end = log.end().unwrap();
        let all: heapless::Vec<_, 500> = log.entries(&end, 1).unwrap();
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
        let mut nor = Nor::new(3);
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
        assert_eq!(log.end().unwrap(), end, "{spoilt} places");
        let all: heapless::Vec<_, 8> = log.entries(&end, 1).unwrap();
        assert!(all.iter().copied().eq((1..=4).map(uploaded)));
    }
}
