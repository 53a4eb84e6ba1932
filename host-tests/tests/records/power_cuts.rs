//! The power goes in every operation of an append: the old set or the new one is active afterwards, whole.

use hexsense_core::records::{CoefficientSet, Stored};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use host_tests::nor_flash::{Nor, Torn};
use host_tests::sets::numbered;

use crate::appends::{PAGES, append, newest};

/// Appends set `number` to `nor` with the arranged power cut; checks the result, and that the next append works.
/// Returns whether the power went.
fn survive(nor: &mut Nor, number: u32, case: &str) -> bool {
    let old = newest_undisturbed(nor);
    let appended = append(nor, number);
    let cut = nor.power_on();
    assert_eq!(
        appended.is_none(),
        cut,
        "{case}: an append fails only when the power goes"
    );
    let found = newest(nor);
    let is_new = found
        .as_ref()
        .is_some_and(|(_, set)| *set == numbered(number));
    assert!(
        found == old || is_new,
        "{case}: had {old:?}, found {found:?}"
    );
    assert!(cut || is_new, "{case}: a completed append is the newest");
    cut
}

/// The newest set in a copy of the flash, so that reading repairs nothing.
fn newest_undisturbed(nor: &Nor) -> Option<(Stored, CoefficientSet)> {
    let mut copy = nor.clone();
    copy.power_on();
    newest(&mut copy)
}

/// Cuts the power in each operation of each of these appends in turn.
fn sweep(appends: std::ops::RangeInclusive<u32>, torn: Torn) {
    let mut nor = Nor::new(PAGES);
    for number in 1..*appends.start() {
        append(&mut nor, number).unwrap();
    }
    for number in appends {
        let mut operation = 0;
        loop {
            let case = format!("{torn:?} in operation {operation} of append {number}");
            let mut cut = nor.clone();
            cut.cut_after(
                operation,
                torn,
                u64::from(number) << 32 | u64::from(operation),
            );
            if !survive(&mut cut, number, &case) {
                break;
            }
            let next = append(&mut cut, number + 1)
                .unwrap_or_else(|| panic!("{case}: the next append fails"));
            assert_eq!(
                newest(&mut cut),
                Some((next, numbered(number + 1))),
                "{case}"
            );
            operation += 1;
        }
        append(&mut nor, number).unwrap();
    }
}

/// The first set, the last into an empty page, and one into each page that holds another.
fn sweep_all(torn: Torn) {
    sweep(1..=1, torn);
    sweep(8..=16, torn);
}

#[test]
fn a_cut_before_an_operation_leaves_the_old_or_the_new_set() {
    sweep_all(Torn::Nothing);
}

#[test]
fn a_cut_after_an_operation_leaves_the_old_or_the_new_set() {
    sweep_all(Torn::Everything);
}

#[test]
fn a_cut_that_leaves_some_bits_leaves_the_old_or_the_new_set() {
    sweep_all(Torn::SomeBits);
}

#[test]
fn a_cut_that_leaves_a_word_of_garbage_leaves_the_old_or_the_new_set() {
    sweep_all(Torn::Garbage);
}

#[test]
fn a_cut_that_leaves_a_patchwork_leaves_the_old_or_the_new_set() {
    sweep_all(Torn::Patchwork);
}

/// Repeated damage: every other append is cut somewhere, and so is the repair after it.
fn generations(mut nor: Nor) {
    let mut random = ChaCha8Rng::seed_from_u64(20_260_101);
    let mut cuts = 0;
    for number in 1..1_200 {
        let torn = Torn::ALL[random.random_range(0..Torn::ALL.len())];
        // An append is about eighty operations, with the erasure of a page among the first of some.
        let most = if random.random() { 160 } else { 6 };
        let operation = random.random_range(0..most);
        nor.cut_after(operation, torn, random.random());
        let case = format!("append {number}, {torn:?} in operation {operation}");
        cuts += u32::from(survive(&mut nor, number, &case));
    }
    assert!(cuts > 600, "{cuts} cuts");
}

#[test]
fn power_cuts_in_a_row_never_cost_the_active_set() {
    generations(Nor::new(PAGES));
}

#[test]
fn power_cuts_in_a_row_never_cost_the_active_set_though_the_driver_loses_errors() {
    let mut nor = Nor::new(PAGES);
    nor.reports = false;
    generations(nor);
}
