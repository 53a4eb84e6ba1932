//! Every change while the power lasts, and the refusals.

use std::cell::RefCell;

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::NorFlash;
use hexsense_core::authority::log_mac;
use hexsense_core::facts::FlashLayout;
use hexsense_core::records::log::{Log, Reason, capacity};
use hexsense_core::records::{BuildId, CoefficientSet, Entry, MAX_ENCODED, RecordError};
use hexsense_core::storage::{Storage, StorageCommand};
use hexsense_core::wire::change::Act;
use hexsense_core::wire::log::Volume;
use hexsense_core::wire::message::Chunk;
use hexsense_core::wire::{Refusal, Response};
use host_tests::nor_flash::{Nor, PAGE, layout};
use host_tests::sets::{BOARD, BUILD, encoded, numbered};
use hostile::key_holder::Shared;

use crate::key_holder::{KEY, KeyHolder, OTHER_KEY, PAGES, id, upload_of};

#[test]
fn an_upload_becomes_active_and_stays_so_over_a_start() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 0);
    assert_eq!(key_holder.active(), None);
    for number in 1..=20 {
        assert!(
            matches!(key_holder.upload(number), Ok(Response::Committed(active)) if active.id == id(number))
        );
        assert_eq!(key_holder.active(), Some(numbered(number)));
    }
    let (log, history) = (key_holder.log(), key_holder.history());
    drop(key_holder);
    let operations = nor.operations;
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!(key_holder.active(), Some(numbered(20)));
    assert_eq!((key_holder.log(), key_holder.history()), (log, history));
    drop(key_holder);
    assert_eq!(
        nor.operations, operations,
        "a start after a proper change writes nothing"
    );
}

#[test]
fn the_last_eight_sets_are_kept_and_any_of_them_can_become_active_again() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 12);
    let kept: Vec<_> = (5..=12).rev().map(id).collect();
    assert_eq!(key_holder.history(), kept);
    for number in [5, 9, 12, 6] {
        assert!(
            matches!(key_holder.roll_back(number), Ok(Response::Committed(active)) if active.id == id(number))
        );
        assert_eq!(key_holder.active(), Some(numbered(number)));
        assert_eq!(key_holder.history(), kept);
    }
    assert_eq!(key_holder.roll_back(6), Err(Refusal::AlreadyActive));
    assert_eq!(key_holder.roll_back(1), Err(Refusal::NoSuchSet));
}

#[test]
fn a_factory_reset_erases_the_sets_and_keeps_key_and_log() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 10);
    assert_eq!(
        key_holder.change(&KEY, Act::FactoryReset),
        Ok(Response::Erased { sets: 8 })
    );
    assert_eq!((key_holder.active(), key_holder.history()), (None, vec![]));
    drop(key_holder);
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!((key_holder.active(), key_holder.history()), (None, vec![]));
    assert_eq!(key_holder.log().len(), 12);
    key_holder.upload(11).unwrap();
    assert_eq!(key_holder.history(), [id(11)]);
}

#[test]
fn every_change_leaves_an_entry_that_says_what_came_in_place_of_what() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    key_holder.roll_back(1).unwrap();
    key_holder.change(&KEY, Act::FactoryReset).unwrap();
    let log = key_holder.log();
    let told: Vec<_> = log
        .iter()
        .map(|entry| (entry.counter, entry.reason, entry.id, entry.previous))
        .collect();
    let expected = [
        (1, Reason::Provision, None, None),
        (2, Reason::Upload, Some(id(1)), None),
        (3, Reason::Upload, Some(id(2)), Some(id(1))),
        (4, Reason::Rollback, Some(id(1)), Some(id(2))),
        (5, Reason::FactoryReset, None, Some(id(1))),
    ];
    assert_eq!(told, expected);
    assert!(log.iter().all(|entry| entry.unix_s == 1_790_000_000));
}

#[test]
fn a_set_for_another_board_is_refused_and_one_that_came_with_its_flash_is_not_used() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 0);
    let foreign = CoefficientSet {
        board: [8; 12],
        ..numbered(1)
    };
    let bytes = encoded(&foreign);
    key_holder.change(&KEY, upload_of(&bytes)).unwrap();
    assert_eq!(key_holder.send(&bytes), Err(Refusal::OtherBoard));
    key_holder.upload(1).unwrap();
    drop(key_holder);
    let mut elsewhere = Storage::new(&mut nor, layout(PAGES), [8; 12]);
    elsewhere.load().unwrap();
    assert!(elsewhere.active().is_none());
}

#[test]
fn lengths_that_lie_and_pieces_out_of_place_are_refused() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 0);
    let bytes = encoded(&numbered(1));
    let Act::Upload { digest, .. } = upload_of(&bytes) else {
        unreachable!()
    };
    for length in [0, MAX_ENCODED as u16 + 1, u16::MAX] {
        let refused = key_holder.change(&KEY, Act::Upload { length, digest });
        let limit = MAX_ENCODED as u16;
        assert_eq!(refused, Err(Refusal::Length { length, limit }));
    }
    let piece = Chunk::from_slice(&bytes[..100]).unwrap();
    assert_eq!(
        key_holder.ask(StorageCommand::Chunk(0, piece.clone())),
        Err(Refusal::NoUpload)
    );
    assert_eq!(
        key_holder.ask(StorageCommand::Commit),
        Err(Refusal::NoUpload)
    );
    key_holder
        .change(
            &KEY,
            Act::Upload {
                length: 150,
                digest,
            },
        )
        .unwrap();
    assert_eq!(
        key_holder.ask(StorageCommand::Chunk(1, piece.clone())),
        Err(Refusal::OutOfOrder { expected: 0 })
    );
    key_holder
        .ask(StorageCommand::Chunk(0, piece.clone()))
        .unwrap();
    assert_eq!(
        key_holder.ask(StorageCommand::Chunk(100, piece)),
        Err(Refusal::OutOfOrder { expected: 100 })
    );
    assert_eq!(
        key_holder.ask(StorageCommand::Commit),
        Err(Refusal::OutOfOrder { expected: 100 })
    );
    assert_eq!(key_holder.active(), None);
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 0);
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut set = numbered(1);
        set.triads[1].matrix[2][0] = value;
        let bytes = encoded(&set);
        key_holder.change(&KEY, upload_of(&bytes)).unwrap();
        let refused = key_holder.send(&bytes);
        assert!(
            matches!(refused, Err(Refusal::Record(RecordError::NotFinite { .. }))),
            "{refused:?}"
        );
    }
}

#[test]
fn an_upload_that_was_aborted_or_overtaken_is_forgotten() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 1);
    key_holder
        .change(&KEY, upload_of(&encoded(&numbered(2))))
        .unwrap();
    key_holder.ask(StorageCommand::Abort).unwrap();
    assert_eq!(
        key_holder.send(&encoded(&numbered(2))),
        Err(Refusal::NoUpload)
    );
    key_holder
        .change(&KEY, upload_of(&encoded(&numbered(2))))
        .unwrap();
    key_holder.upload(3).unwrap();
    assert_eq!(key_holder.active(), Some(numbered(3)));
}

/// Programs a word of the active set to zero, as a worn cell or a stray write might.
fn spoil(nor: &mut Nor, number: u32) {
    let bytes = encoded(&numbered(number));
    let place = nor
        .bytes()
        .windows(bytes.len())
        .rposition(|found| found == bytes);
    let word = (place.unwrap() + 100) / 8 * 8;
    block_on(nor.write(word as u32, &[0; 8])).unwrap();
}

#[test]
fn an_active_set_that_cannot_be_read_any_more_gives_way_to_the_newest_and_that_is_logged() {
    let mut nor = Nor::new(PAGES);
    drop(KeyHolder::with_sets(&mut nor, 3));
    spoil(&mut nor, 3);
    for _ in 0..2 {
        let mut key_holder = KeyHolder::start(&mut nor);
        assert_eq!(key_holder.active(), Some(numbered(2)));
        let log = key_holder.log();
        let told = log
            .iter()
            .map(|entry| (entry.reason, entry.id, entry.previous));
        let fallback = (Reason::Fallback, Some(id(2)), Some(id(3)));
        assert!(told.skip(4).eq([fallback]), "{log:?}");
    }
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!(key_holder.roll_back(3), Err(Refusal::NoSuchSet));
    key_holder.upload(4).unwrap();
}

#[test]
fn worn_out_flash_is_told_and_the_old_set_stays() {
    let mut nor = Nor::new(PAGES);
    drop(KeyHolder::with_sets(&mut nor, 1));
    nor.worn_out = nor.range();
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!(key_holder.upload(2), Err(Refusal::Flash));
    assert_eq!(
        key_holder.change(&KEY, Act::Provision(OTHER_KEY)),
        Err(Refusal::Flash)
    );
    assert_eq!(
        key_holder.change(&KEY, Act::FactoryReset),
        Err(Refusal::Flash)
    );
    assert_eq!(
        (key_holder.active(), key_holder.log().len()),
        (Some(numbered(1)), 2)
    );
}

#[test]
fn a_change_whose_entry_the_log_does_not_take_is_told_and_no_other_is_made_before_it_is_there() {
    let mut nor = Nor::new(PAGES);
    drop(KeyHolder::with_sets(&mut nor, 1));
    nor.worn_out = layout(PAGES).log();
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!(key_holder.upload(2), Err(Refusal::Log));
    let made = |key_holder: &mut KeyHolder| (key_holder.active(), key_holder.log().len());
    assert_eq!(made(&mut key_holder), (Some(numbered(2)), 2));
    assert_eq!(key_holder.upload(3), Err(Refusal::EarlierLog));
    assert_eq!(key_holder.roll_back(1), Err(Refusal::EarlierLog));
    assert_eq!(
        key_holder.change(&KEY, Act::FactoryReset),
        Err(Refusal::EarlierLog)
    );
    assert_eq!(made(&mut key_holder), (Some(numbered(2)), 2));
    drop(key_holder);
    let (_, started) = KeyHolder::try_start(&mut nor);
    assert_eq!(started, Err(Refusal::Log));
    nor.worn_out = 0..0;
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!(made(&mut key_holder), (Some(numbered(2)), 3));
    key_holder.upload(3).unwrap();
}

#[test]
fn a_factory_reset_that_erases_nothing_is_told_and_finished_at_the_next_start() {
    let mut nor = Nor::new(PAGES);
    drop(KeyHolder::with_sets(&mut nor, 2));
    nor.worn_out = FlashLayout::ARCHIVE..layout(PAGES).key();
    let mut key_holder = KeyHolder::start(&mut nor);
    let reset = key_holder.change(&KEY, Act::FactoryReset);
    assert_eq!(reset, Err(Refusal::Erasure));
    assert_eq!((key_holder.active(), key_holder.history()), (None, vec![]));
    drop(key_holder);
    let (mut key_holder, started) = KeyHolder::try_start(&mut nor);
    assert_eq!(
        (started, key_holder.active()),
        (Err(Refusal::Erasure), None)
    );
    drop(key_holder);
    nor.worn_out = 0..0;
    assert_eq!(KeyHolder::start(&mut nor).active(), None);
    for number in 1..=2 {
        let bytes = encoded(&numbered(number));
        let mut places = nor.bytes().windows(bytes.len());
        assert!(!places.any(|place| place == bytes), "set {number} is there");
    }
}

#[test]
fn a_set_from_before_a_factory_reset_does_not_take_the_place_of_one_that_is_lost() {
    let nor = RefCell::new(Nor::new(PAGES));
    let (mut key_holder, _) = hostile::key_holder::KeyHolder::start(Shared(&nor));
    key_holder
        .change(&KEY, Act::Provision(KEY))
        .expect("it has no key");
    key_holder.upload(&KEY, &encoded(&numbered(1))).unwrap();
    nor.borrow_mut().worn_out = FlashLayout::ARCHIVE..layout(PAGES).key();
    let reset = key_holder.change(&KEY, Act::FactoryReset);
    assert_eq!(reset, Err(Refusal::Erasure));
    nor.borrow_mut().worn_out = 0..0;
    key_holder.upload(&KEY, &encoded(&numbered(2))).unwrap();
    drop(key_holder);
    let mut nor = nor.into_inner();
    spoil(&mut nor, 2);
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!(key_holder.active(), None);
    let log = key_holder.log();
    let last = log.last().map(|entry| (entry.reason, entry.id));
    assert_eq!(last, Some((Reason::Fallback, None)));
}

#[test]
fn any_change_ends_an_upload_under_way() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    let bytes = encoded(&numbered(3));
    key_holder.change(&KEY, upload_of(&bytes)).unwrap();
    key_holder.roll_back(1).unwrap();
    assert_eq!(key_holder.send(&bytes), Err(Refusal::NoUpload));
    assert_eq!(key_holder.active(), Some(numbered(1)));
}

/// Of 118 pages of 32 places one stays free; eight places are for those that fail, and sixteen for new keys.
#[test]
fn with_a_full_log_no_change_is_made_but_of_the_key_and_a_new_volume_makes_room() {
    let mut nor = Nor::new(PAGES);
    drop(KeyHolder::with_sets(&mut nor, 2));
    let mut log = Log::new(&mut nor, layout(PAGES).log());
    let mut end = log.end().unwrap();
    for counter in 4..=3_719 {
        let entry = Entry {
            counter,
            reason: Reason::Rollback,
            previous: Some(id(2)),
            chain: end.head(),
            ..end.last.unwrap()
        };
        block_on(log.append(&mut end, &entry)).unwrap();
    }
    assert_eq!(capacity(&layout(PAGES)), 3_720);
    let mut key_holder = KeyHolder::start(&mut nor);
    let last = key_holder.roll_back(1);
    assert!(matches!(last, Ok(Response::Committed(active)) if active.id == id(1)));
    assert_eq!(key_holder.storage.log_used(), Some(3_720));
    drop(key_holder);
    let operations = nor.operations;
    let mut key_holder = KeyHolder::start(&mut nor);
    for act in [
        upload_of(&encoded(&numbered(3))),
        Act::FactoryReset,
        Act::Rollback(id(2)),
    ] {
        assert_eq!(key_holder.change(&KEY, act), Err(Refusal::LogFull));
    }
    assert_eq!(key_holder.active(), Some(numbered(1)));
    drop(key_holder);
    assert_eq!(nor.operations, operations);
    let mut key_holder = KeyHolder::start(&mut nor);
    for key in 0..16 {
        let keys = [KEY, OTHER_KEY];
        let [old, new] = [key, key + 1].map(|key| keys[key % 2].clone());
        let replaced = key_holder.change(&old, Act::Provision(new));
        assert_eq!(replaced, Ok(Response::Done));
    }
    let full = key_holder.change(&KEY, Act::Provision(OTHER_KEY));
    assert_eq!(full, Err(Refusal::LogFull));
    let before = key_holder.log();
    assert_eq!(before.len(), 3_736);
    assert_eq!(key_holder.new_volume(), Ok(Response::Done));
    let log = key_holder.log();
    let told = log
        .iter()
        .map(|entry| (entry.counter, entry.reason, entry.chain));
    let head = before.last().unwrap().hash();
    assert!(told.eq([(3_737, Reason::NewVolume, head)]));
    key_holder.upload(3).unwrap();
    assert_eq!(key_holder.storage.log_used(), Some(2));
}

#[test]
fn a_volume_that_has_got_another_entry_since_it_was_read_stays_open() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    key_holder.roll_back(1).unwrap();
    let moved = key_holder.change(&KEY, Act::NewVolume { last: 3 });
    assert_eq!(moved, Err(Refusal::LogMoved));
    assert_eq!(key_holder.log().len(), 4);
}

#[test]
fn the_set_that_is_active_is_no_change_when_it_is_uploaded_again() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    key_holder.roll_back(1).unwrap();
    for _ in 0..2 {
        assert_eq!(key_holder.upload(1), Err(Refusal::AlreadyActive));
        assert_eq!(key_holder.history(), [id(2), id(1)]);
        assert_eq!(key_holder.log().len(), 4);
        drop(key_holder);
        let operations = nor.operations;
        key_holder = KeyHolder::start(&mut nor);
        assert_eq!(key_holder.upload(1), Err(Refusal::AlreadyActive));
        drop(key_holder);
        assert_eq!(nor.operations, operations);
        key_holder = KeyHolder::start(&mut nor);
    }
}

#[test]
fn another_firmware_is_an_entry_of_its_own_and_every_entry_names_its_build() {
    let mut nor = Nor::new(PAGES);
    drop(KeyHolder::with_sets(&mut nor, 1));
    let other = BuildId([0xB2; 8]);
    for build in [other, other, BUILD] {
        let started = hostile::key_holder::KeyHolder::start_with(&mut nor, build);
        let (mut key_holder, started) = started;
        assert_eq!(started, Ok(()));
        assert_eq!(key_holder.log().last().unwrap().build, build);
    }
    let mut key_holder = KeyHolder::start(&mut nor);
    key_holder.upload(2).unwrap();
    let log = key_holder.log();
    let told = log
        .iter()
        .skip(1)
        .map(|entry| (entry.reason, entry.build, entry.id, entry.unix_s));
    let (one, at) = (Some(id(1)), 1_790_000_000);
    let expected = [
        (Reason::Upload, BUILD, one, at),
        (Reason::FirmwareChange, other, one, 0),
        (Reason::FirmwareChange, BUILD, one, 0),
        (Reason::Upload, BUILD, Some(id(2)), at),
    ];
    assert!(told.eq(expected), "{log:?}");
}

#[test]
fn a_log_is_proven_with_the_key_only_and_anew_after_each_entry() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::start(&mut nor);
    let nonce = [0x5A; 32];
    let refused = key_holder.ask(StorageCommand::LogProof(nonce));
    assert_eq!(refused, Err(Refusal::Unprovisioned));
    key_holder.provision();
    for number in 1..3 {
        key_holder.upload(number).unwrap();
        let last = *key_holder.log().last().unwrap();
        let volume = Volume {
            first: 1,
            last: last.counter,
            head: last.hash(),
            build: BUILD,
        };
        let mac = log_mac(&KEY, &nonce, &BOARD, &volume);
        let proof = key_holder.ask(StorageCommand::LogProof(nonce));
        assert_eq!(proof, Ok(Response::LogProof { volume, mac }));
    }
}

/// A bank that something else was in: no record of ours, and not a single erased word.
#[test]
fn foreign_content_of_the_flash_is_told_and_takes_no_place() {
    let mut nor = Nor::new(PAGES);
    assert_eq!(KeyHolder::start(&mut nor).storage.log_used(), Some(0));
    let foreign: Vec<u8> = (0..PAGES * PAGE).map(|at| (at * 37 % 253) as u8).collect();
    nor.overwrite(0, &foreign);
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!(key_holder.storage.log_used(), None);
    assert_eq!((key_holder.active(), key_holder.log()), (None, vec![]));
    key_holder.provision();
    assert_eq!(key_holder.storage.log_used(), Some(1));
    for number in 1..=40 {
        key_holder.upload(number).unwrap();
    }
    drop(key_holder);
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!(key_holder.active(), Some(numbered(40)));
    assert_eq!(key_holder.log().len(), 41);
    assert_eq!(key_holder.history().len(), 8);
}
