//! Whether entries are a whole chain, and the volume that was signed.

use hexsense_core::records::log::{Entry, Reason};
use hexsense_core::wire::log::Volume;

/// What is wrong with the entries of a volume, in words; empty when the chain is whole.
#[must_use]
pub fn flaws(entries: &[Entry]) -> Vec<String> {
    let mut flaws = Vec::new();
    if let Some(first) = entries.first() {
        let is_first = match first.counter {
            1 => first.chain == [0; 16],
            _ => first.reason == Reason::NewVolume,
        };
        if !is_first {
            let counter = first.counter;
            flaws.push(format!(
                "change {counter} is the first there is, and it does not begin a volume: entries before it ARE MISSING"
            ));
        }
    }
    for pair in entries.windows(2) {
        let [before, after] = [&pair[0], &pair[1]];
        let next = u64::from(before.counter) + 1;
        if u64::from(after.counter) > next {
            let last = u64::from(after.counter) - 1;
            flaws.push(format!(
                "changes {next} to {last} ARE MISSING between changes {} and {}",
                before.counter, after.counter
            ));
        } else if u64::from(after.counter) < next || after.chain != before.hash() {
            flaws.push(format!(
                "change {} does not follow on change {}: one of them WAS ALTERED, or put in",
                after.counter, before.counter
            ));
        }
    }
    flaws
}

/// What is wrong with the entries of the volume that was signed.
#[must_use]
pub fn volume_flaws(entries: &[Entry], volume: &Volume) -> Vec<String> {
    let mut flaws = flaws(entries);
    let ends =
        [entries.first(), entries.last()].map(|entry| entry.map_or(0, |entry| entry.counter));
    if ends != [volume.first, volume.last] {
        flaws.push(format!(
            "the entries are changes {} to {}, and what was signed is changes {} to {}",
            ends[0], ends[1], volume.first, volume.last
        ));
    }
    if entries.last().map_or([0; 16], Entry::hash) != volume.head {
        flaws.push("the last entry is not the one that was signed".to_owned());
    }
    flaws
}
