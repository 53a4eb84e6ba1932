//! The board proves that it has the key, what set and how many changes it has, and that it has forgotten what was under way.

use hexsense_core::authority::proof;
use hexsense_core::records::{BuildId, SetId};
use hexsense_core::storage::{PROOF_MS, StorageCommand};
use hexsense_core::wire::change::{Act, Key, Statement};
use hexsense_core::wire::{Refusal, Response};
use host_tests::nor_flash::Nor;
use host_tests::sets::{BOARD, BUILD, encoded, numbered};

use crate::key_holder::{KEY, KeyHolder, OTHER_KEY, PAGES, acts, id, upload_of};

const CHALLENGE: [u8; 32] = *b"thirty-two random bytes of hosts";

/// Computed with Python's `hmac` and `hashlib` over bytes written out by hand.
#[test]
fn a_proof_is_the_hmac_that_others_compute() {
    let key = Key(std::array::from_fn(|index| index as u8));
    let challenge = std::array::from_fn(|index| 0x40 + index as u8);
    let build = BuildId([0xB1; 8]);
    for (statement, expected) in [
        (
            Statement {
                set: Some(SetId([1, 2, 3, 4, 5, 6, 7, 8])),
                changes: 0x0102_0304,
            },
            "41834e0073cb91756a27efbd9bcba4bfb2c0a6baf5fdfa8438f81cc36db43480",
        ),
        (
            Statement {
                set: None,
                changes: 0,
            },
            "80f69d390eb1bc8cc781d5013f9d06c972265ce99298f38ea881ba5e733e7a4b",
        ),
    ] {
        let tag = proof(&key, &challenge, &BOARD, &build, &statement);
        let hex: String = tag.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hex, expected);
    }
}

fn prove(key_holder: &mut KeyHolder) -> Result<Response, Refusal> {
    key_holder.now_ms += PROOF_MS;
    key_holder.ask(StorageCommand::Prove(CHALLENGE))
}

#[test]
fn a_proof_tells_set_and_changes_and_is_made_with_the_key_in_force() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!(prove(&mut key_holder), Err(Refusal::Unprovisioned));
    key_holder.provision();
    let holds = |key_holder: &mut KeyHolder, key: &Key, set, changes| {
        let statement = Statement { set, changes };
        let tag = proof(key, &CHALLENGE, &BOARD, &BUILD, &statement);
        assert_eq!(prove(key_holder), Ok(Response::Proof { statement, tag }));
    };
    holds(&mut key_holder, &KEY, None, 1);
    key_holder.upload(1).unwrap();
    holds(&mut key_holder, &KEY, Some(id(1)), 2);
    key_holder.change(&KEY, Act::Provision(OTHER_KEY)).unwrap();
    holds(&mut key_holder, &OTHER_KEY, Some(id(1)), 3);
}

/// A change that was held back on the line arrives after the proof: its challenge is void, and so is an upload.
#[test]
fn after_a_proof_nothing_that_was_under_way_is_carried_out() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    let before = (key_holder.log(), key_holder.active());
    for act in acts() {
        let (change, tag) = key_holder.signed(&KEY, act);
        prove(&mut key_holder).unwrap();
        let late = key_holder.ask(StorageCommand::Change(change, tag));
        assert_eq!(late, Err(Refusal::NoChallenge));
    }
    let bytes = encoded(&numbered(3));
    key_holder.change(&KEY, upload_of(&bytes)).unwrap();
    prove(&mut key_holder).unwrap();
    assert_eq!(key_holder.send(&bytes), Err(Refusal::NoUpload));
    assert_eq!((key_holder.log(), key_holder.active()), before);
}

/// Also on a board without a key, whose first key may be held back.
#[test]
fn a_board_without_a_key_forgets_its_challenge_too() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::start(&mut nor);
    let (change, tag) = key_holder.signed(&KEY, Act::Provision(KEY));
    assert_eq!(prove(&mut key_holder), Err(Refusal::Unprovisioned));
    let late = key_holder.ask(StorageCommand::Change(change, tag));
    assert_eq!(late, Err(Refusal::NoChallenge));
    assert!(!key_holder.storage.is_provisioned());
}

#[test]
fn a_flood_gets_one_proof_in_ten_milliseconds() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 0);
    key_holder.now_ms = 5_000;
    let mut proofs = 0;
    for _ in 0..1_000 {
        match key_holder.ask(StorageCommand::Prove(CHALLENGE)) {
            Ok(Response::Proof { .. }) => proofs += 1,
            Err(Refusal::Busy) => {}
            other => panic!("{other:?}"),
        }
        key_holder.now_ms += 1;
    }
    assert_eq!(proofs, 100);
}
