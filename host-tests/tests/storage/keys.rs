//! The key in its two pages: one good copy of it suffices, without any the board is closed to everybody, and a new key
//! takes the place of the old one in one step.

use embassy_futures::block_on;
use hexsense_core::authority::MAX_WAIT_MS;
use hexsense_core::records::key::{KeyPages, StoredKey};
use hexsense_core::records::log::{ENTRY, Reason};
use hexsense_core::storage::{Storage, StorageCommand};
use hexsense_core::wire::change::{Act, Key};
use hexsense_core::wire::{Refusal, Response};
use host_tests::nor_flash::{Nor, PAGE, WORD, layout};
use host_tests::sets::{BOARD, encoded, numbered};

use crate::key_holder::{KEY, KeyHolder, OTHER_KEY, PAGES, acts, id, upload_of};

/// Where the first page of the key begins: behind eight pages of sets.
const KEY_PAGES: usize = 8 * PAGE;
/// Where the log begins: behind two pages of the key.
const LOG: usize = 10 * PAGE;
/// The second copy of a key, behind the first.
const SECOND_COPY: usize = PAGE / 2;
/// Words of a copy.
const WORDS: usize = 7;

/// A board with a key and sets 1 and 2.
fn board() -> Nor {
    let mut nor = Nor::new(PAGES);
    KeyHolder::with_sets(&mut nor, 2);
    nor
}

/// Changes a word, as wear or radiation may.
fn flip(nor: &mut Nor, place: usize, bits: u64) {
    let word = nor.bytes()[place..place + WORD].try_into().unwrap();
    let flipped = u64::from_le_bytes(word) ^ bits;
    nor.overwrite(place, &flipped.to_le_bytes());
}

/// Whether the board makes changes for the holder of this key.
fn serves(key_holder: &mut KeyHolder, key: &Key) -> bool {
    key_holder.now_ms += MAX_WAIT_MS;
    match key_holder.change(key, Act::Rollback(Default::default())) {
        Err(Refusal::NoSuchSet | Refusal::LogFull) => true,
        Err(Refusal::WrongTag) => false,
        other => panic!("{other:?}"),
    }
}

/// That the old key serves and the new one does not, at once and after the next start.
fn keeps_the_old_key(nor: &mut Nor, case: &str) {
    let mut key_holder = KeyHolder::start(nor);
    assert!(serves(&mut key_holder, &KEY), "{case}");
    assert!(!serves(&mut key_holder, &OTHER_KEY), "{case}");
}

fn replace(key_holder: &mut KeyHolder) -> Result<Response, Refusal> {
    key_holder.change(&KEY, Act::Provision(OTHER_KEY))
}

#[test]
fn a_new_key_needs_the_old_one_and_replaces_it() {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 2);
    assert_eq!(
        key_holder.change(&KEY, Act::Provision(OTHER_KEY)),
        Ok(Response::Done)
    );
    assert_eq!(key_holder.upload(3), Err(Refusal::WrongTag));
    drop(key_holder);
    let gone = KEY.0;
    assert!(
        !nor.bytes().windows(gone.len()).any(|bytes| bytes == gone),
        "the old key is erased"
    );
    let mut key_holder = KeyHolder::start(&mut nor);
    let rolled_back = key_holder.change(&OTHER_KEY, Act::Rollback(id(1)));
    assert!(matches!(rolled_back, Ok(Response::Committed(_))));
}

#[test]
fn one_or_two_wrong_bits_in_any_word_of_a_copy_cost_no_key() {
    let whole = board();
    for copy in [0, SECOND_COPY] {
        for (word, first) in (0..WORDS).flat_map(|word| (0..64).map(move |bit| (word, bit))) {
            for bits in [1 << first, 1 << first | 1 << ((first + 13) % 64)] {
                let mut nor = whole.clone();
                flip(&mut nor, KEY_PAGES + copy + word * WORD, bits);
                keeps_the_old_key(
                    &mut nor,
                    &format!("word {word} of copy {copy}, bits {bits:x}"),
                );
            }
        }
    }
}

/// A stranger takes a damaged key for a chance: no key, no set and no erasure is taken, whether the log or the archive
/// shows that there was a key.
#[test]
fn without_a_good_copy_no_change_is_taken_from_anybody() {
    let (log, archive) = (LOG..PAGES * PAGE, 0..KEY_PAGES);
    for (case, forgotten) in [("whole", 0..0), ("no log", log), ("no archive", archive)] {
        let mut nor = board();
        for copy in [0, SECOND_COPY] {
            flip(&mut nor, KEY_PAGES + copy + 3 * WORD, 1 << 17 | 1 << 40);
        }
        let erased = vec![0xFF; forgotten.len()];
        nor.overwrite(forgotten.start, &erased);
        // Without its log or its archive a board notes in the log what became of its set, once.
        KeyHolder::start(&mut nor);
        let content = nor.bytes().to_vec();
        let mut key_holder = KeyHolder::start(&mut nor);
        let active = key_holder.storage.active().map(|active| active.set.id);
        assert!(key_holder.storage.is_key_damaged() && !key_holder.storage.is_provisioned());
        for (key, act) in [KEY, OTHER_KEY]
            .into_iter()
            .flat_map(|key| acts().into_iter().map(move |act| (key.clone(), act)))
            .chain([
                (OTHER_KEY, Act::Provision(OTHER_KEY)),
                (KEY, Act::Provision(KEY)),
            ])
        {
            let refused = key_holder.change(&key, act.clone());
            assert_eq!(refused, Err(Refusal::KeyDamaged), "{case}: {act:?}");
        }
        assert_eq!(
            key_holder.send(&encoded(&numbered(3))),
            Err(Refusal::NoUpload)
        );
        let still = key_holder.storage.active().map(|active| active.set.id);
        assert_eq!(still, active, "{case}: it measures on");
        drop(key_holder);
        assert!(nor.bytes() == content, "{case}");
    }
}

/// Before the flash has been read, nobody knows whether there is a key.
#[test]
fn a_storage_that_has_not_read_its_flash_takes_no_key() {
    let mut nor = Nor::new(PAGES);
    let mut storage = Storage::new(&mut nor, layout(PAGES), BOARD);
    assert!(storage.is_key_damaged());
    let (change, tag) = hostile::key_holder::signed(&KEY, &[0; 16], Act::Provision(KEY));
    let change = StorageCommand::Change(change, tag);
    let refused = block_on(storage.carry_out(change, 0, async |_| true));
    assert_eq!(refused, Err(Refusal::KeyDamaged));
}

/// Nothing but a torn key page is in flash after a power cut in the first provisioning.
#[test]
fn a_board_that_never_had_a_key_takes_one_whatever_its_key_pages_hold() {
    for place in [KEY_PAGES, KEY_PAGES + SECOND_COPY, KEY_PAGES + PAGE] {
        let mut nor = Nor::new(PAGES);
        nor.overwrite(place, &[0x5A; 48]);
        let mut key_holder = KeyHolder::start(&mut nor);
        assert!(!key_holder.storage.is_key_damaged());
        key_holder.provision();
        assert!(serves(&mut key_holder, &KEY));
    }
}

#[test]
fn a_new_key_that_the_flash_does_not_take_leaves_the_old_one_in_force() {
    let log = LOG as u32..(PAGES * PAGE) as u32;
    let page = |page: usize| (KEY_PAGES + page * PAGE) as u32;
    let second = page(1) + SECOND_COPY as u32;
    // A word of the log, all of it, and the page of the new key: its first copy, its second, its erasure.
    for worn_out in [
        log.clone(),
        page(1) + 8..page(1) + 16,
        second..second + 56,
        page(1)..page(1) + 8,
    ] {
        let mut nor = board();
        nor.worn_out = worn_out.clone();
        let case = format!("worn out at {worn_out:?}");
        let mut key_holder = KeyHolder::start(&mut nor);
        let before = key_holder.log();
        assert_eq!(replace(&mut key_holder), Err(Refusal::Flash), "{case}");
        assert!(serves(&mut key_holder, &KEY), "{case}");
        assert!(!serves(&mut key_holder, &OTHER_KEY), "{case}");
        assert_eq!(key_holder.log(), before, "{case}");
        drop(key_holder);
        nor.worn_out = 0..0;
        keeps_the_old_key(&mut nor, &case);
        let mut key_holder = KeyHolder::start(&mut nor);
        assert_eq!(key_holder.log(), before, "{case}");
        assert_eq!(replace(&mut key_holder), Ok(Response::Done), "{case}");
    }
}

/// Whatever became of its page: a key without its entry stays out of force, also when another change has its number.
#[test]
fn a_key_whose_entry_the_log_did_not_take_never_comes_in_force() {
    let mut nor = board();
    let pending = StoredKey {
        counter: 4,
        unix_s: 1_790_000_000,
        key: OTHER_KEY,
    };
    let keep = |nor: &mut Nor| {
        block_on(KeyPages::new(nor, KEY_PAGES as u32).store(1, &pending)).unwrap();
    };
    keep(&mut nor);
    keeps_the_old_key(&mut nor, "no entry");
    KeyHolder::start(&mut nor).upload(3).unwrap();
    keep(&mut nor);
    keeps_the_old_key(&mut nor, "the entry of an upload");
}

/// In the next volume the entry that has the number of the other key cannot be looked up any more.
#[test]
fn a_key_that_is_not_in_force_and_cannot_be_erased_keeps_the_volume_open() {
    let mut nor = board();
    let page = (KEY_PAGES + PAGE) as u32;
    let pending = StoredKey {
        counter: 4,
        unix_s: 1_790_000_000,
        key: OTHER_KEY,
    };
    block_on(KeyPages::new(&mut nor, KEY_PAGES as u32).store(1, &pending)).unwrap();
    nor.worn_out = page..page + PAGE as u32;
    let mut key_holder = KeyHolder::start(&mut nor);
    key_holder.upload(3).unwrap();
    assert_eq!(key_holder.new_volume(), Err(Refusal::Flash));
    drop(key_holder);
    keeps_the_old_key(&mut nor, "a page that stays");
    nor.worn_out = 0..0;
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!(key_holder.new_volume(), Ok(Response::Done));
    drop(key_holder);
    keeps_the_old_key(&mut nor, "a new volume");
}

/// The archive has higher numbers than a log that is lost: a later upload is still the newest.
#[test]
fn the_numbers_go_on_behind_those_of_the_archive_when_the_log_is_lost() {
    let mut nor = board();
    nor.overwrite(LOG, &vec![0xFF; PAGES * PAGE - LOG]);
    let mut key_holder = KeyHolder::start(&mut nor);
    let counters = |key_holder: &mut KeyHolder| -> Vec<u32> {
        key_holder.log().iter().map(|entry| entry.counter).collect()
    };
    assert_eq!(counters(&mut key_holder), [3]);
    key_holder.upload(4).unwrap();
    drop(key_holder);
    let mut key_holder = KeyHolder::start(&mut nor);
    assert_eq!(counters(&mut key_holder), [3, 4]);
    let active = key_holder.storage.active().map(|active| active.set.id);
    assert_eq!(active, Some(id(4)));
}

/// The old key's page is still there when the power goes before its erasure, and the entry may be damaged later.
#[test]
fn a_key_whose_entry_the_log_took_is_in_force_beside_the_old_one() {
    for damage in [0, 1 << 20] {
        let mut nor = board();
        let old = nor.bytes()[KEY_PAGES..KEY_PAGES + PAGE].to_vec();
        let mut key_holder = KeyHolder::start(&mut nor);
        assert_eq!(replace(&mut key_holder), Ok(Response::Done));
        let change = key_holder.change(&OTHER_KEY, Act::Rollback(id(1)));
        assert!(matches!(change, Ok(Response::Committed(_))));
        drop(key_holder);
        nor.overwrite(KEY_PAGES, &old);
        // The fourth change was the new key.
        flip(&mut nor, LOG + 3 * ENTRY + WORD, damage);
        let mut key_holder = KeyHolder::start(&mut nor);
        assert!(serves(&mut key_holder, &OTHER_KEY) && !serves(&mut key_holder, &KEY));
        drop(key_holder);
        assert!(
            nor.bytes()[KEY_PAGES..KEY_PAGES + PAGE]
                .iter()
                .all(|byte| *byte == 0xFF),
            "the start erases the old key"
        );
    }
}

#[test]
fn with_a_full_log_the_old_key_stays_in_force() {
    let mut nor = Nor::new(12);
    let mut key_holder = KeyHolder::with_sets(&mut nor, 1);
    while key_holder.change(&KEY, Act::FactoryReset).is_ok() {}
    // The last places are for new keys.
    for _ in 0..8 {
        assert_eq!(replace(&mut key_holder), Ok(Response::Done));
        let back = key_holder.change(&OTHER_KEY, Act::Provision(KEY));
        assert_eq!(back, Ok(Response::Done));
    }
    assert_eq!(replace(&mut key_holder), Err(Refusal::LogFull));
    drop(key_holder);
    keeps_the_old_key(&mut nor, "full log");
}

#[test]
fn the_key_that_a_board_has_is_no_change() {
    let mut nor = board();
    let operations = nor.operations;
    let mut key_holder = KeyHolder::start(&mut nor);
    let again = key_holder.change(&KEY, Act::Provision(KEY));
    assert_eq!(again, Err(Refusal::SameKey));
    let log = key_holder.log();
    assert_eq!(log.len(), 3);
    assert_eq!(
        log.iter()
            .filter(|entry| entry.reason == Reason::Provision)
            .count(),
        1
    );
    // It is asked for with the key, and ends an upload as every change does.
    let foreign = key_holder.change(&OTHER_KEY, Act::Provision(KEY));
    assert_eq!(foreign, Err(Refusal::WrongTag));
    key_holder.now_ms += MAX_WAIT_MS;
    let bytes = encoded(&numbered(3));
    key_holder.change(&KEY, upload_of(&bytes)).unwrap();
    let again = key_holder.change(&KEY, Act::Provision(KEY));
    assert_eq!(again, Err(Refusal::SameKey));
    assert_eq!(key_holder.send(&bytes), Err(Refusal::NoUpload));
    drop(key_holder);
    assert_eq!(nor.operations, operations);
}
