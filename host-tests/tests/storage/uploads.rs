//! An upload at the limits of its length, its pieces and its time.

use hexsense_core::records::RecordError;
use hexsense_core::storage::{StorageCommand, UPLOAD_MS};
use hexsense_core::wire::change::Act;
use hexsense_core::wire::message::Chunk;
use hexsense_core::wire::{Refusal, Response};
use host_tests::nor_flash::Nor;
use host_tests::sets::{encoded, numbered};

use crate::key_holder::{KEY, KeyHolder, PAGES, upload_of};

fn announce(key_holder: &mut KeyHolder, length: u16) -> Result<Response, Refusal> {
    let digest = [0x5A; 32];
    key_holder.change(&KEY, Act::Upload { length, digest })
}

fn piece(key_holder: &mut KeyHolder, offset: u16, bytes: &[u8]) -> Result<Response, Refusal> {
    let bytes = Chunk::from_slice(bytes).unwrap();
    key_holder.ask(StorageCommand::Chunk(offset, bytes))
}

#[test]
fn one_byte_to_six_hundred_and_forty_may_be_announced() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 1);
    for (length, taken) in [(0, false), (1, true), (640, true), (641, false)] {
        let refused = Err(Refusal::Length { length, limit: 640 });
        let expected = if taken { Ok(Response::Done) } else { refused };
        assert_eq!(
            announce(&mut key_holder, length),
            expected,
            "{length} bytes"
        );
    }
}

#[test]
fn pieces_follow_each_other_and_end_where_the_announced_length_does() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 1);
    announce(&mut key_holder, 130).unwrap();
    assert_eq!(piece(&mut key_holder, 0, &[1; 128]), Ok(Response::Done));
    let out_of_order = Err(Refusal::OutOfOrder { expected: 128 });
    for offset in [0, 127, 129, 130, u16::MAX] {
        assert_eq!(
            piece(&mut key_holder, offset, &[2]),
            out_of_order,
            "{offset}"
        );
    }
    assert_eq!(piece(&mut key_holder, 128, &[2; 3]), out_of_order);
    assert_eq!(piece(&mut key_holder, 128, &[2; 1]), Ok(Response::Done));
    let early = key_holder.ask(StorageCommand::Commit);
    assert_eq!(early, Err(Refusal::OutOfOrder { expected: 129 }));

    announce(&mut key_holder, 130).unwrap();
    piece(&mut key_holder, 0, &[1; 128]).unwrap();
    assert_eq!(piece(&mut key_holder, 128, &[2; 2]), Ok(Response::Done));
    let one_more = piece(&mut key_holder, 130, &[3]);
    assert_eq!(one_more, Err(Refusal::OutOfOrder { expected: 130 }));
    let other = key_holder.ask(StorageCommand::Commit);
    assert_eq!(other, Err(Refusal::WrongIdentity));
}

#[test]
fn pieces_and_commit_come_within_a_minute_of_the_tag() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 1);
    for (number, begins_ms, ends_ms, refused) in [
        (2, 0, 60_000, None),
        (3, 0, 60_001, Some(Refusal::Expired)),
        (4, 60_000, 60_000, None),
        (5, 60_001, 60_001, Some(Refusal::Expired)),
    ] {
        let bytes = encoded(&numbered(number));
        key_holder.change(&KEY, upload_of(&bytes)).unwrap();
        let begun_ms = key_holder.now_ms;
        key_holder.now_ms = begun_ms + begins_ms;
        let mut sent = Ok(Response::Done);
        for (index, part) in bytes.chunks(128).enumerate() {
            sent = sent.and_then(|_| piece(&mut key_holder, index as u16 * 128, part));
        }
        key_holder.now_ms = begun_ms + ends_ms;
        let committed = sent.and_then(|_| key_holder.ask(StorageCommand::Commit));
        assert_eq!(committed.err(), refused, "{begins_ms} {ends_ms}");
    }
    assert_eq!(UPLOAD_MS, 60_000);
}

#[test]
fn every_changed_bit_of_a_set_is_another_set() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 1);
    let bytes = encoded(&numbered(2));
    for bit in [0, 1, 4 * bytes.len(), 8 * bytes.len() - 1] {
        key_holder.change(&KEY, upload_of(&bytes)).unwrap();
        let mut changed = bytes.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(key_holder.send(&changed), Err(Refusal::WrongIdentity));
        // Announced as they are, the bytes are no set.
        key_holder.change(&KEY, upload_of(&changed)).unwrap();
        let refused = key_holder.send(&changed);
        let is_damaged = matches!(refused, Err(Refusal::Record(RecordError::Checksum { .. })));
        assert!(is_damaged, "bit {bit}: {refused:?}");
    }
    assert_eq!(key_holder.active(), Some(numbered(1)));
}

#[test]
fn a_set_is_read_up_to_its_end_and_not_beyond() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 1);
    let bytes = encoded(&numbered(1));
    let length = bytes.len() as u16;
    for offset in [0, length - 129, length - 128, length - 1, length] {
        let rest = &bytes[usize::from(offset)..];
        let expected = Chunk::from_slice(&rest[..rest.len().min(128)]).unwrap();
        let read = key_holder.ask(StorageCommand::Read(offset));
        let bytes = expected;
        assert_eq!(read, Ok(Response::SetBytes { offset, bytes }));
    }
    let offset = length + 1;
    let beyond = key_holder.ask(StorageCommand::Read(offset));
    assert_eq!(beyond, Err(Refusal::Offset { offset, length }));
}
