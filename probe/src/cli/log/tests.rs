//! Tests of what the command prints.

use super::*;
use hexsense_core::records::BuildId;
use hexsense_core::records::log::Reason;

const SETS: [SetId; 2] = [SetId([0x0a; 8]), SetId([1, 2, 3, 4, 5, 6, 7, 0xab])];

/// A new key, two uploads, a fallback and a firmware change, which have no time, and a reset; the fourth change is missing.
fn entries() -> [Entry; 6] {
    let entry = |counter, reason, unix_s, id: Option<usize>, previous: Option<usize>| Entry {
        counter,
        reason,
        unix_s,
        id: id.map(|set| SETS[set]),
        previous: previous.map(|set| SETS[set]),
        build: BuildId([0xb0 + counter as u8; 8]),
        chain: [counter as u8; 16],
        reset: 0,
        page: 0,
    };
    [
        entry(1, Reason::Provision, 1_780_000_000, None, None),
        entry(2, Reason::Upload, 1_780_000_061, Some(0), None),
        entry(3, Reason::Upload, 1_780_003_600, Some(1), Some(0)),
        entry(5, Reason::Fallback, 99, Some(0), Some(1)),
        entry(6, Reason::FirmwareChange, 98, Some(0), Some(0)),
        entry(7, Reason::FactoryReset, 1_780_086_400, None, Some(0)),
    ]
}

#[test]
fn every_change_has_its_time_kind_and_both_sets_in_their_columns() {
    let expected = "\
change  time                  what           active then       active before     firmware
 1  2026-05-28T20:26:40Z  provision      none              none              b1b1b1b1b1b1b1b1
 2  2026-05-28T20:27:41Z  upload         0a0a0a0a0a0a0a0a  none              b2b2b2b2b2b2b2b2
 3  2026-05-28T21:26:40Z  upload         01020304050607ab  0a0a0a0a0a0a0a0a  b3b3b3b3b3b3b3b3
 5  unknown               fallback       0a0a0a0a0a0a0a0a  01020304050607ab  b5b5b5b5b5b5b5b5
 6  unknown               firmware       0a0a0a0a0a0a0a0a  0a0a0a0a0a0a0a0a  b6b6b6b6b6b6b6b6
 7  2026-05-29T20:26:40Z  factory-reset  none              0a0a0a0a0a0a0a0a  b7b7b7b7b7b7b7b7
";
    assert_eq!(table(&entries()), expected);
}

#[test]
fn the_document_has_every_change_and_every_gap() {
    let entry =
        |change: u8, utc: Option<(u64, &str)>, what, id: Option<&str>, previous: Option<&str>| {
            json!({
                "change": change,
                "unix_s": utc.map(|utc| utc.0),
                "utc": utc.map(|utc| utc.1),
                "what": what,
                "id": id,
                "previous_id": previous,
                "build": format!("b{change}").repeat(8),
                "chain": format!("0{change}").repeat(16),
            })
        };
    let [first, second] = ["0a0a0a0a0a0a0a0a", "01020304050607ab"].map(Some);
    let expected = json!({
        "entries": [
            entry(1, Some((1_780_000_000, "2026-05-28T20:26:40Z")), "provision", None, None),
            entry(2, Some((1_780_000_061, "2026-05-28T20:27:41Z")), "upload", first, None),
            entry(3, Some((1_780_003_600, "2026-05-28T21:26:40Z")), "upload", second, first),
            entry(5, None, "fallback", first, second),
            entry(6, None, "firmware", first, first),
            entry(7, Some((1_780_086_400, "2026-05-29T20:26:40Z")), "factory-reset", None, first),
        ],
        "flaws": ["one"],
    });
    assert_eq!(to_json(&entries(), &["one".to_owned()]), expected);
}
