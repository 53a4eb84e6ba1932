//! The power goes in every operation of every change: the state afterwards is that before or after the change, and the
//! log tells which.

use hexsense_core::records::CoefficientSet;
use hexsense_core::wire::change::{Act, Key};
use hexsense_core::wire::{Refusal, Response};
use host_tests::nor_flash::{Nor, Torn};
use host_tests::sets::numbered;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::key_holder::{KEY, KeyHolder, OTHER_KEY, PAGES};

/// A change.
#[derive(Debug, Clone, Copy)]
enum Step {
    Upload(u32),
    Rollback(u32),
    Reset,
    Provision,
    Rekey,
    NewVolume,
}

impl Step {
    fn take(self, key_holder: &mut KeyHolder) -> Result<Response, Refusal> {
        match self {
            Self::Upload(number) => key_holder.upload(number),
            Self::Rollback(number) => key_holder.roll_back(number),
            Self::Reset => key_holder.change(&KEY, Act::FactoryReset),
            Self::Provision => key_holder.change(&KEY, Act::Provision(KEY)),
            Self::NewVolume => key_holder.new_volume(),
            Self::Rekey => key_holder.change(&KEY, Act::Provision(OTHER_KEY)),
        }
    }
}

/// The board from the host's side: active set, entries in the log, and its key.
#[derive(Debug, PartialEq)]
struct View {
    active: Option<CoefficientSet>,
    /// The counters of its volume's first and last entry.
    log: [u32; 2],
    key: Option<Key>,
}

/// Starts the board, checks that log and active set agree, and returns its state.
fn look(nor: &mut Nor, case: &str) -> View {
    let mut key_holder = KeyHolder::start(nor);
    let (log, active) = (key_holder.log(), key_holder.active());
    let counters = log.iter().map(|entry| entry.counter);
    let ends = [log.first(), log.last()].map(|entry| entry.map_or(0, |entry| entry.counter));
    let whole = ends[0]..ends[0] + log.len() as u32;
    assert!(counters.eq(whole), "{case}: {log:?}");
    let id = key_holder.storage.active().map(|active| active.set.id);
    assert_eq!(
        log.last().and_then(|entry| entry.id),
        id,
        "{case}: the last entry names what is active"
    );
    for pair in log.windows(2) {
        assert_eq!(
            pair[1].previous, pair[0].id,
            "{case}: entries follow on each other"
        );
        assert_eq!(pair[1].chain, pair[0].hash(), "{case}: the chain is whole");
    }
    let key = [KEY, OTHER_KEY].into_iter().find(|key| {
        key_holder.now_ms += 100_000;
        key_holder.storage.is_provisioned()
            && key_holder.change(key, Act::Rollback(Default::default())) == Err(Refusal::NoSuchSet)
    });
    assert_eq!(key.is_some(), key_holder.storage.is_provisioned(), "{case}");
    View {
        active,
        log: ends,
        key,
    }
}

/// Cuts the power in each operation of `step` in turn, in every way, on a board after the changes `before`.
fn sweep(before: &[Step], step: Step) {
    let mut nor = Nor::new(PAGES);
    let mut key_holder = KeyHolder::start(&mut nor);
    for step in before {
        step.take(&mut key_holder).unwrap();
    }
    drop(key_holder);
    let old = look(&mut nor.clone(), "before");
    let mut done = nor.clone();
    step.take(&mut KeyHolder::start(&mut done)).unwrap();
    let new = look(&mut done, "after");
    assert_ne!(old, new);
    let operations = done.operations - nor.operations;
    for (torn, operation) in Torn::ALL
        .iter()
        .flat_map(|torn| (0..operations).map(move |at| (*torn, at)))
    {
        let case =
            format!("{step:?} after {before:?}, {torn:?} in operation {operation} of {operations}");
        let mut cut = nor.clone();
        cut.cut_after(operation, torn, operation.into());
        let answer = step.take(&mut KeyHolder::start(&mut cut));
        assert!(cut.power_on(), "{case}");
        let found = look(&mut cut, &case);
        // Only the erasure of an old key comes after all that counts.
        assert!(answer.is_err() || found == new, "{case}: {answer:?}");
        assert!(found == old || found == new, "{case}: {found:?}");
        let settled = cut.operations;
        assert_eq!(
            look(&mut cut, &case),
            found,
            "{case}: a second start finds the same"
        );
        assert_eq!(
            cut.operations, settled,
            "{case}: and has nothing left to do"
        );
        // The board then takes further changes.
        let mut key_holder = KeyHolder::start(&mut cut);
        if found.key == Some(KEY) {
            key_holder
                .upload(99)
                .unwrap_or_else(|refusal| panic!("{case}: {refusal}"));
            assert_eq!(key_holder.active(), Some(numbered(99)), "{case}");
        }
        if found.key.is_none() {
            key_holder.provision();
        }
    }
}

/// A board with a key and sets 1 to `last`.
fn sets(last: u32) -> Vec<Step> {
    std::iter::once(Step::Provision)
        .chain((1..=last).map(Step::Upload))
        .collect()
}

#[test]
fn in_the_first_upload() {
    sweep(&sets(0), Step::Upload(1));
}

/// The ninth overwrites the oldest; from the nineteenth on pages are erased.
#[test]
fn in_uploads_that_overwrite_the_oldest() {
    for last in [8, 12, 18, 19, 20, 21, 22, 23] {
        sweep(&sets(last), Step::Upload(last + 1));
    }
}

#[test]
fn in_a_rollback() {
    sweep(&sets(2), Step::Rollback(1));
    sweep(&sets(20), Step::Rollback(13));
    sweep(&sets(21), Step::Rollback(15));
}

/// The active set may then be in either half, and be the oldest there.
#[test]
fn in_uploads_after_a_rollback() {
    for (last, back) in [(12, 5), (20, 13), (21, 15), (22, 20), (23, 19)] {
        let rolled_back = [sets(last), vec![Step::Rollback(back)]].concat();
        sweep(&rolled_back, Step::Upload(last + 1));
    }
}

#[test]
fn in_a_factory_reset() {
    sweep(&sets(1), Step::Reset);
    sweep(&sets(21), Step::Reset);
}

#[test]
fn in_provisioning() {
    sweep(&[], Step::Provision);
    sweep(&sets(3), Step::Rekey);
}

#[test]
fn in_a_new_volume() {
    let second = [sets(2), vec![Step::NewVolume]].concat();
    sweep(&sets(1), Step::NewVolume);
    sweep(&second, Step::NewVolume);
    sweep(&second, Step::Upload(3));
}

/// Any changes one after another; every second one is cut somewhere, and so is the repair after it.
#[test]
fn again_and_again_in_any_order() {
    let mut random = ChaCha8Rng::seed_from_u64(20_261_125);
    let mut nor = Nor::new(PAGES);
    Step::Provision
        .take(&mut KeyHolder::start(&mut nor))
        .unwrap();
    let mut old = look(&mut nor, "first");
    let (mut cuts, mut recent) = (0, vec![]);
    for number in 1..1_000 {
        let step = match random.random_range(0..20) {
            0 => Step::Reset,
            19 => Step::NewVolume,
            1..=4 if !recent.is_empty() => {
                Step::Rollback(recent[random.random_range(0..recent.len())])
            }
            _ => Step::Upload(number),
        };
        let torn = Torn::ALL[random.random_range(0..Torn::ALL.len())];
        let operation = random.random_range(0..160);
        let case = format!("{number}: {step:?}, {torn:?} in operation {operation}");
        nor.cut_after(operation, torn, random.random());
        let answer = step.take(&mut KeyHolder::try_start(&mut nor).0);
        let cut = nor.power_on();
        cuts += u32::from(cut);
        let found = look(&mut nor, &case);
        let wanted = match step {
            Step::Upload(number) | Step::Rollback(number) => Some(numbered(number)),
            Step::NewVolume => old.active.clone(),
            _ => None,
        };
        let (is_old, is_new) = (found.active == old.active, found.active == wanted);
        assert!(
            is_new || answer.is_err(),
            "{case}: a completed change counts"
        );
        assert!(is_old || is_new, "{case}: {found:?}");
        assert!(
            cut || is_new == answer.is_ok() || is_old,
            "{case}: {answer:?}"
        );
        assert_eq!(found.key, Some(KEY), "{case}");
        match step {
            Step::Reset if found.active.is_none() => recent.clear(),
            Step::Upload(number) if found.active == Some(numbered(number)) => recent.push(number),
            _ => {}
        }
        recent.drain(..recent.len().saturating_sub(5));
        old = found;
    }
    assert!(cuts > 300, "{cuts} cuts");
}
