//! Only the key holder changes anything, and a recorded exchange cannot be used again.

use hexsense_core::authority::{CHALLENGE_MS, MAX_WAIT_MS, log_mac, tag};
use hexsense_core::records::{BuildId, SetId};
use hexsense_core::storage::{StorageCommand, UPLOAD_MS};
use hexsense_core::wire::change::{Act, Change, Key};
use hexsense_core::wire::log::Volume;
use hexsense_core::wire::{Refusal, Response};
use host_tests::nor_flash::Nor;
use host_tests::sets::{BOARD, encoded, numbered};
use proptest::prelude::*;

use crate::key_holder::{KEY, KeyHolder, OTHER_KEY, PAGES, acts, id, upload_of};

/// Computed with Python's `hmac` and `hashlib` over the change's bytes written out by hand.
#[test]
fn a_tag_is_the_hmac_that_others_compute() {
    let key = Key(std::array::from_fn(|index| index as u8));
    let challenge = std::array::from_fn(|index| 0x40 + index as u8);
    let change = Change {
        unix_s: 1_790_000_000,
        act: Act::Rollback(SetId([1, 2, 3, 4, 5, 6, 7, 8])),
    };
    let tag = tag(&key, &challenge, &BOARD, &change);
    let hex: String = tag.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(
        hex,
        "4720332b51ca7a0245335b4c8f1a92408595e51510373286a3ed14a162a96fba"
    );
}

/// Computed with Python's `hmac`, `hashlib` and `struct`.
#[test]
fn the_proof_of_a_log_is_the_hmac_that_others_compute() {
    let key = Key(std::array::from_fn(|index| index as u8));
    let nonce = std::array::from_fn(|index| 0x40 + index as u8);
    let volume = Volume {
        first: 0x0102_0304,
        last: 0x1112_1314,
        head: std::array::from_fn(|index| 0x60 + index as u8),
        build: BuildId([0x81; 8]),
    };
    let mac = log_mac(&key, &nonce, &BOARD, &volume);
    let hex: String = mac.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(
        hex,
        "62099aabd3a3e3f51fca4238b0ad30ece45044e29375a65ac1a88b94e447a3f1"
    );
}

#[test]
fn a_board_without_a_key_takes_no_change_but_a_key() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::start(&mut nor);
    for act in acts().into_iter().take(3) {
        assert_eq!(key_holder.change(&KEY, act), Err(Refusal::Unprovisioned));
    }
    assert_eq!(
        key_holder.change(&OTHER_KEY, Act::Provision(KEY)),
        Err(Refusal::WrongTag),
        "the tag shows that the key has arrived whole"
    );
    assert!(!key_holder.storage.is_provisioned());
    drop(key_holder);
    assert_eq!(nor.operations, 0);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 0);
    assert!(key_holder.storage.is_provisioned());
    key_holder.upload(1).unwrap();
}

#[test]
fn no_change_is_made_with_another_key() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    for act in acts() {
        let refused = key_holder.change(&OTHER_KEY, act);
        assert_eq!(refused, Err(Refusal::WrongTag));
        key_holder.now_ms += MAX_WAIT_MS;
    }
    assert_eq!(
        key_holder.send(&encoded(&numbered(3))),
        Err(Refusal::NoUpload)
    );
    assert_eq!(
        (key_holder.log().len(), key_holder.active()),
        (3, Some(numbered(2)))
    );
}

#[test]
fn a_change_that_was_heard_changes_nothing_again() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    let (change, tag) = key_holder.signed(&KEY, Act::Rollback(id(1)));
    let heard = StorageCommand::Change(change, tag);
    assert!(matches!(
        key_holder.ask(heard.clone()),
        Ok(Response::Committed(_))
    ));
    key_holder.upload(2).unwrap();
    assert_eq!(key_holder.ask(heard.clone()), Err(Refusal::NoChallenge));
    key_holder.ask(StorageCommand::Challenge).unwrap();
    assert_eq!(key_holder.ask(heard), Err(Refusal::WrongTag));
    assert_eq!(key_holder.active(), Some(numbered(2)));
}

#[test]
fn a_tag_serves_for_no_other_change_board_or_challenge() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    let acts = acts();
    for (signed, sent) in acts.iter().zip(acts.iter().cycle().skip(1)) {
        let (mut change, tag) = key_holder.signed(&KEY, signed.clone());
        change.act = sent.clone();
        assert_eq!(
            key_holder.ask(StorageCommand::Change(change, tag)),
            Err(Refusal::WrongTag)
        );
        key_holder.now_ms += MAX_WAIT_MS;
    }
    let (mut change, tag) = key_holder.signed(&KEY, Act::FactoryReset);
    change.unix_s += 1;
    assert_eq!(
        key_holder.ask(StorageCommand::Change(change, tag)),
        Err(Refusal::WrongTag)
    );
    key_holder.now_ms += MAX_WAIT_MS;
    let Ok(Response::Challenge(challenge)) = key_holder.ask(StorageCommand::Challenge) else {
        panic!("no challenge");
    };
    let change = Change {
        unix_s: 0,
        act: Act::FactoryReset,
    };
    let elsewhere = hexsense_core::authority::tag(&KEY, &challenge, &[8; 12], &change);
    assert_eq!(
        key_holder.ask(StorageCommand::Change(change, elsewhere)),
        Err(Refusal::WrongTag)
    );
    assert_eq!(key_holder.log().len(), 3);
}

#[test]
fn a_challenge_expires_and_serves_once() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    for (wait_ms, accepted) in [(CHALLENGE_MS, true), (CHALLENGE_MS + 1, false)] {
        let (change, tag) = key_holder.signed(&KEY, upload_of(&encoded(&numbered(3))));
        key_holder.now_ms += wait_ms;
        let answer = key_holder.ask(StorageCommand::Change(change, tag));
        let expected = if accepted {
            Ok(Response::Done)
        } else {
            Err(Refusal::NoChallenge)
        };
        assert_eq!(answer, expected, "after {wait_ms} ms");
    }
}

#[test]
fn an_unlocked_upload_expires() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    for (number, wait_ms, expected) in [
        (3, UPLOAD_MS, None),
        (4, UPLOAD_MS + 1, Some(Refusal::Expired)),
    ] {
        let bytes = encoded(&numbered(number));
        key_holder.change(&KEY, upload_of(&bytes)).unwrap();
        key_holder.now_ms += wait_ms;
        assert_eq!(
            key_holder.send(&bytes).err(),
            expected,
            "after {wait_ms} ms"
        );
    }
}

#[test]
fn the_set_that_was_unlocked_is_the_only_one_that_is_taken() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    key_holder
        .change(&KEY, upload_of(&encoded(&numbered(3))))
        .unwrap();
    let other = encoded(&numbered(4));
    assert_eq!(key_holder.send(&other), Err(Refusal::WrongIdentity));
    assert_eq!(key_holder.active(), Some(numbered(2)));
}

#[test]
fn wrong_answers_wait_longer_and_longer_and_a_right_one_ends_it() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    for attempt in 0..10 {
        let wait_ms = (1_000 << attempt).min(MAX_WAIT_MS);
        assert_eq!(
            key_holder.change(&OTHER_KEY, Act::FactoryReset),
            Err(Refusal::WrongTag)
        );
        key_holder.now_ms += wait_ms - 1;
        assert_eq!(
            key_holder.change(&KEY, Act::FactoryReset),
            Err(Refusal::BackOff { ms: 1 }),
            "even the right key waits, attempt {attempt}"
        );
        key_holder.now_ms += 1;
    }
    key_holder.upload(3).unwrap();
    assert_eq!(
        key_holder.change(&OTHER_KEY, Act::FactoryReset),
        Err(Refusal::WrongTag)
    );
    key_holder.now_ms += 1_000;
    key_holder.upload(4).unwrap();
}

#[test]
fn a_challenge_lives_ten_seconds_an_upload_a_minute_and_a_wait_at_most_sixty_four_seconds() {
    assert_eq!(
        (CHALLENGE_MS, UPLOAD_MS, MAX_WAIT_MS),
        (10_000, 60_000, 64_000)
    );
}

/// Seconds to wait after the first wrong tag, the second, and so on.
#[test]
fn each_wrong_tag_doubles_the_wait_up_to_sixty_four_seconds() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 1);
    for seconds in [1, 2, 4, 8, 16, 32, 64, 64, 64] {
        let wrong = key_holder.change(&OTHER_KEY, Act::FactoryReset);
        assert_eq!(wrong, Err(Refusal::WrongTag));
        let at_once = key_holder.change(&KEY, Act::FactoryReset);
        let ms = seconds * 1_000;
        assert_eq!(at_once, Err(Refusal::BackOff { ms }));
        key_holder.now_ms += u64::from(ms) - 1;
        let refused = key_holder.change(&KEY, Act::FactoryReset);
        assert_eq!(refused, Err(Refusal::BackOff { ms: 1 }));
        key_holder.now_ms += 1;
    }
    assert_eq!(key_holder.active(), Some(numbered(1)));
    let reset = key_holder.change(&KEY, Act::FactoryReset);
    assert_eq!(reset, Ok(Response::Erased { sets: 1 }));
}

/// A refused change uses its challenge up, also while the board waits.
#[test]
fn a_challenge_that_was_tried_during_the_wait_does_not_serve_after_it() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 1);
    let wrong = key_holder.change(&OTHER_KEY, Act::FactoryReset);
    assert_eq!(wrong, Err(Refusal::WrongTag));
    let (change, tag) = key_holder.signed(&KEY, Act::FactoryReset);
    let command = StorageCommand::Change(change, tag);
    let waits = key_holder.ask(command.clone());
    assert_eq!(waits, Err(Refusal::BackOff { ms: 1_000 }));
    key_holder.now_ms += 1_000;
    assert_eq!(key_holder.ask(command), Err(Refusal::NoChallenge));
}

#[test]
fn nothing_that_is_asked_gives_the_key_away() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    let mut answers = vec![format!("{:?}", key_holder.storage.active())];
    for number in 0..=u8::MAX {
        let commands = [
            StorageCommand::ActiveSet,
            StorageCommand::Read(u16::from(number) * 16),
            StorageCommand::History(number),
            StorageCommand::Log(number.into()),
            StorageCommand::LogProof([number; 32]),
            StorageCommand::Challenge,
        ];
        answers.extend(commands.map(|command| format!("{:?}", key_holder.ask(command))));
    }
    let key = format!("{:?}", KEY.0);
    let inside = key.trim_matches(['[', ']']);
    assert!(answers.iter().all(|answer| !answer.contains(inside)));
    assert_eq!(format!("{KEY:?}"), "Key(secret)");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn one_changed_bit_of_a_tag_is_a_wrong_tag(bit in 0..256_usize) {
        let mut nor = Nor::new(PAGES);
        let mut key_holder = KeyHolder::with_sets(&mut nor, 0);
        let (change, mut tag) = key_holder.signed(&KEY, Act::FactoryReset);
        tag[bit / 8] ^= 1 << (bit % 8);
        prop_assert_eq!(key_holder.ask(StorageCommand::Change(change, tag)), Err(Refusal::WrongTag));
    }
}
