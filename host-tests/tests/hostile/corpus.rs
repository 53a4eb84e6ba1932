//! Each target takes the inputs that fuzzers found, and random ones; it panics where a promise is broken.

use std::fs;
use std::path::Path;

use hostile::key_holder::{KeyHolder, Shared};
use hostile::{TARGETS, Target, bases};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The kept inputs of a target, in the order of their names.
fn kept(name: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fuzz/corpus")
        .join(name);
    let files = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{folder:?}: {error}"));
    let mut paths: Vec<_> = files.map(|file| file.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

fn target(name: &str) -> Target {
    let found = TARGETS.iter().find(|(other, _)| *other == name);
    found.unwrap().1
}

/// Runs a target on the kept inputs, on `runs` inputs that differ from those in a few bytes, and on as many random
/// ones.
fn attack(name: &str, runs: u32, longest: usize) {
    let run = target(name);
    let mut random = ChaCha8Rng::seed_from_u64(20_261_126);
    let kept = kept(name);
    assert!(kept.len() >= 20, "the corpus of {name} is there");
    kept.iter().for_each(|input| run(input));
    for _ in 0..runs {
        let mut near = kept[random.random_range(0..kept.len())].clone();
        let changes = random.random_range(1..4);
        for _ in 0..changes.min(near.len()) {
            let place = random.random_range(0..near.len());
            near[place] = random.random();
        }
        run(&near);
        let length = random.random_range(0..longest);
        let far: Vec<u8> = (0..length).map(|_| random.random()).collect();
        run(&far);
    }
}

#[test]
fn no_bytes_on_the_line_keep_the_next_good_frame_from_being_found() {
    attack("frames", 20_000, 300);
}

#[test]
fn no_payload_makes_a_decoder_panic_and_what_decodes_stays_the_same() {
    attack("messages", 100_000, 200);
}

#[test]
fn no_commands_by_others_change_anything_and_the_next_good_upload_works() {
    attack("storage", 1_000, 60);
}

#[test]
fn no_bytes_in_flash_keep_the_board_from_starting() {
    attack("records", 3_000, 120);
}

#[test]
fn no_board_makes_the_host_panic_record_a_number_that_is_none_or_print_what_a_terminal_obeys() {
    attack("host", 5_000, 200);
}

/// Checks the starting points of the attacks: on wrong ones the attacks would be harmless.
#[test]
fn attacks_begin_on_boards_with_the_history_they_say() {
    let logged = bases::BASES.each_ref().map(|nor| {
        let nor = std::cell::RefCell::new(nor.clone());
        let (mut key_holder, started) = KeyHolder::start(Shared(&nor));
        assert_eq!(started, Ok(()));
        (key_holder.storage.is_provisioned(), key_holder.log().len())
    });
    assert_eq!(
        logged,
        [(false, 0), (true, 1), (true, 2), (true, 4), (true, 22)]
    );
}
