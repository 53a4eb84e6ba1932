//! Where the option bytes of the chip forbid it, nothing is written nor erased, at the start or by any command.

use embassy_futures::block_on;
use hexsense_core::storage::{Storage, StorageCommand};
use hexsense_core::wire::change::Act;
use hexsense_core::wire::message::Chunk;
use hexsense_core::wire::{Refusal, Response};
use host_tests::nor_flash::{Nor, Torn, layout};
use host_tests::sets::{BOARD, BUILD, encoded, numbered};

use crate::key_holder::{KEY, KeyHolder, PAGES, acts, id};

#[test]
fn every_change_is_refused_and_everything_can_be_read() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    let log = key_holder.log();
    drop(key_holder);
    let before = nor.operations;
    let mut key_holder = KeyHolder::start(&mut nor);
    key_holder.storage.forbid_changes();
    for act in acts() {
        assert_eq!(key_holder.change(&KEY, act), Err(Refusal::OptionBytes));
    }
    for command in [
        StorageCommand::Chunk(0, Chunk::new()),
        StorageCommand::Commit,
    ] {
        assert_eq!(key_holder.ask(command), Err(Refusal::OptionBytes));
    }
    assert_eq!(key_holder.ask(StorageCommand::Abort), Ok(Response::Done));
    assert_eq!(key_holder.active(), Some(numbered(2)));
    assert_eq!(key_holder.history(), [id(2), id(1)]);
    assert_eq!(key_holder.log(), log);
    drop(key_holder);
    assert_eq!(nor.operations, before);
}

#[test]
fn a_board_without_a_key_takes_none() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::start(&mut nor);
    key_holder.storage.forbid_changes();
    assert_eq!(
        key_holder.change(&KEY, Act::Provision(KEY)),
        Err(Refusal::OptionBytes)
    );
    drop(key_holder);
    assert_eq!(nor.operations, 0);
}

#[test]
fn a_change_that_was_interrupted_anywhere_is_not_completed() {
    let mut before = Nor::new(PAGES);
    drop(KeyHolder::with_sets(&mut before, 2));
    let mut left_over = 0;
    for operation in 0..200 {
        for act in acts() {
            let mut nor = before.clone();
            nor.cut_after(operation, Torn::Nothing, 1);
            // It may need fewer operations than that, and only an upload has something to send.
            let mut key_holder = KeyHolder::start(&mut nor);
            let _ = key_holder.change(&KEY, act);
            let _ = key_holder.send(&encoded(&numbered(3)));
            drop(key_holder);
            nor.power_on();
            let bytes = nor.bytes().to_vec();
            let mut storage = Storage::new(&mut nor, layout(PAGES), BOARD);
            storage.forbid_changes();
            storage.load().unwrap();
            block_on(storage.complete(BUILD)).unwrap();
            drop(storage);
            assert!(nor.bytes() == bytes, "cut in operation {operation}");
            drop(KeyHolder::start(&mut nor));
            left_over += u32::from(nor.bytes() != bytes);
        }
    }
    assert!(
        left_over > 10,
        "{left_over} starts had something to complete"
    );
}
