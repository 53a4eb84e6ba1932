//! The starting points of attacks: contents to upload, and the flash of boards with some history.

use std::cell::RefCell;
use std::sync::LazyLock;

use hexsense_core::records::CoefficientSet;
use hexsense_core::wire::change::Act;

use crate::key_holder::{KEYS, KeyHolder, PAGES, Shared, id};
use crate::nor_flash::Nor;
use crate::sets::{encoded, numbered};

/// The number of contents that are sets for this board; the others are not.
pub const GOOD: usize = 3;

/// Encoded sets, then one for another board, one with a number that is not finite, and bytes that are not a set.
pub static CONTENTS: LazyLock<[Vec<u8>; GOOD + 3]> = LazyLock::new(|| {
    let [one, two, three] = [1, 2, 3].map(|number| encoded(&numbered(number)));
    let elsewhere = CoefficientSet {
        board: [8; 12],
        ..numbered(1)
    };
    let mut endless = numbered(1);
    endless.triads[1].matrix[0][0] = f32::INFINITY;
    let cut_off = one[..100].to_vec();
    [
        one,
        two,
        three,
        encoded(&elsewhere),
        encoded(&endless),
        cut_off,
    ]
});

/// Empty flash, flash with a key, with one set, with two sets of which the first is active, and with a full archive.
pub static BASES: LazyLock<[Nor; 5]> = LazyLock::new(|| {
    let empty = Nor::new(PAGES);
    let keyed = after(&empty, |key_holder| {
        key_holder.change(&KEYS[0], Act::Provision(KEYS[0].clone()))
    });
    let one = after(&keyed, |key_holder| {
        key_holder.upload(&KEYS[0], &CONTENTS[0])
    });
    let two = after(&one, |key_holder| key_holder.upload(&KEYS[0], &CONTENTS[1]));
    let first = after(&two, |key_holder| {
        key_holder.change(&KEYS[0], Act::Rollback(id(&CONTENTS[0])))
    });
    let full = (1..=20).fold(one.clone(), |nor, number| {
        after(&nor, |key_holder| {
            key_holder.upload(&KEYS[0], &CONTENTS[number % GOOD])
        })
    });
    [empty, keyed, one, first, full]
});

/// The flash after a change.
fn after<T, E: std::fmt::Debug>(
    nor: &Nor,
    change: impl FnOnce(&mut KeyHolder<Shared>) -> Result<T, E>,
) -> Nor {
    let nor = RefCell::new(nor.clone());
    let (mut key_holder, started) = KeyHolder::start(Shared(&nor));
    started.expect("a board starts");
    change(&mut key_holder).expect("a host with the key is served");
    drop(key_holder);
    nor.into_inner()
}
