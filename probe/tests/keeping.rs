//! The commands that change what the board keeps and show what was changed, as a user types them.

mod fake;

use assert_cmd::Command;
use fake::FakeBoard;
use fake::desk::{Desk, KEY_FILE};
use fake::key::KEY;
use fake::source::{Source, Still};
use hexsense_core::records::log::{Entry, Reason};
use hexsense_probe::log_file::{LogFile, volume_flaws};
use hexsense_probe::{coefficient_file, files, key_file};
use serde_json::Value;

/// Another key's file in the folder of `desk`.
fn other_key(desk: &Desk) {
    key_file::create(&desk.path().join("other.key")).unwrap();
}

#[test]
fn a_board_says_whether_it_has_a_key_and_gets_it_once() {
    let desk = Desk::with(FakeBoard::unprovisioned(Box::new(Still)));
    assert_eq!(desk.json("status")["provisioned"], false);
    for command in ["status", "info"] {
        let said = desk.says(&[command]);
        assert!(
            said.contains("NONE") && said.contains("`hexsense provision`"),
            "{said}"
        );
    }
    assert!(desk.says(&["log"]).contains("the log is empty"));
    // No key file is made for a board whose key cannot be replaced.
    fake::key::write(&desk.path().join("old.key"), &"0123".repeat(16));
    desk.refuses(
        &["provision", "--old-key", "old.key"],
        &["has no key that could be replaced", "leave --old-key out"],
    );
    assert!(!desk.path().join(KEY_FILE).exists());

    let said = desk.says(&["provision"]);
    assert!(
        said.contains(&format!("only with the key in {KEY_FILE}")),
        "{said}"
    );
    let key = key_file::load(&desk.path().join(KEY_FILE)).unwrap();
    let digits = std::fs::read_to_string(desk.path().join(KEY_FILE)).unwrap();
    assert!(!said.contains(digits.trim()));
    assert_eq!(desk.json("status")["provisioned"], true);
    for command in ["status", "info"] {
        let said = desk.says(&[command]);
        assert!(
            said.contains("provisioned; the board takes changes only"),
            "{said}"
        );
    }
    let id = desk.upload(1);
    assert_eq!(desk.active_id(), id);

    let again = ["has a key already", "nothing has changed", "--old-key FILE"];
    desk.refuses(&["provision"], &again);
    desk.refuses(&["provision", "--key", "new.key"], &again);
    assert!(!desk.path().join("new.key").exists());
    assert!(key_file::load(&desk.path().join(KEY_FILE)).unwrap() == key);
}

#[test]
fn info_names_the_build_of_the_firmware() {
    let desk = Desk::new();
    assert_eq!(desk.json("info")["build"], "0908070605040302");
    assert_eq!(desk.json("info")["firmware"], "9.8.7");
    let said = desk.says(&["info"]);
    assert!(said.contains("9.8.7, build 0908070605040302,"), "{said}");
}

#[test]
fn a_key_is_replaced_with_the_old_one_only() {
    let desk = Desk::new();
    other_key(&desk);
    desk.refuses(
        &["provision", "--old-key", KEY_FILE],
        &[
            &format!("{KEY_FILE}: is there already, and a key that exists is never sent"),
            "--key FILE",
            "--new-key",
        ],
    );
    desk.refuses(
        &["provision", "--old-key", "other.key", "--key", "new.key"],
        &[
            "the key is not that of this board",
            "the new key is not in use, and stays in new.key.unused-1; the same command makes another",
        ],
    );
    let unused = key_file::load(&desk.path().join("new.key.unused-1")).unwrap();
    assert!(!desk.path().join("new.key").exists());
    // A second passes on the board, whose time goes on only while somebody listens.
    desk.says(&["capture", "--seconds", "2", "--out", "pause.csv"]);
    desk.says(&["provision", "--old-key", KEY_FILE, "--key", "new.key"]);
    assert!(key_file::load(&desk.path().join("new.key")).unwrap() != unused);
    let set = fake::set::set(1);
    coefficient_file::save(
        &desk.path().join("coefficients.toml"),
        &set,
        &fake::set::sources(),
    )
    .unwrap();
    desk.says(&["upload", "--key", "new.key", "coefficients.toml"]);
    desk.refuses(
        &["upload", "coefficients.toml"],
        &["the key is not that of this board", "unchanged"],
    );
}

#[test]
fn history_has_every_kept_set_with_its_times_and_marks_the_active_one() {
    let desk = Desk::new();
    assert!(desk.says(&["history"]).contains("keeps no coefficients"));
    assert_eq!(desk.json("history")["sets"], Value::Array(Vec::new()));
    let ids: Vec<String> = (1..=10)
        .map(|set| desk.upload(1_780_000_000 + set))
        .collect();
    let history = desk.json("history");
    let sets = history["sets"].as_array().unwrap();
    assert_eq!(sets.len(), 8);
    for (age, set) in sets.iter().enumerate() {
        // The first change was the key.
        assert_eq!(set["change"], 11 - age);
        assert_eq!(set["id"], ids[9 - age]);
        assert_eq!(set["made_unix_s"], 1_780_000_010 - age);
        assert_eq!(set["active"], age == 0);
        let geometry = (age == 0).then_some("an-74tk-200");
        assert_eq!(set["geometry"], Value::from(geometry));
    }
    let text = desk.says(&["history"]);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 1 + 8 + 1);
    assert!(
        lines[1].starts_with("*     11")
            && lines[1].contains(&ids[9])
            && lines[1].contains("2026-05-28T20:26:50Z"),
        "{text}"
    );
    assert!(
        lines[2..9].iter().all(|line| line.starts_with("  ")),
        "{text}"
    );
    assert!(lines[9].contains("made for base an-74tk-200"), "{text}");
}

#[test]
fn rollback_makes_a_kept_set_active_and_reads_it_back() {
    let desk = Desk::new();
    desk.refuses(
        &["rollback", "ab"],
        &["keeps no coefficients to go back to"],
    );
    let [first, second] = [1, 2].map(|set| desk.upload(set));
    let said = desk.says(&["rollback", &first[..5].to_uppercase()]);
    assert!(
        said.contains(&format!(
            "set {first}, which was uploaded with change 2, is active again"
        )) && said.contains("1970-01-01T00:00:01Z")
            && said.contains("base an-74tk-200"),
        "{said}"
    );
    assert_eq!(desk.active_id(), first);
    let sets = &desk.json("history")["sets"];
    assert_eq!(
        (&sets[0]["active"], &sets[1]["active"]),
        (&false.into(), &true.into())
    );
    assert_eq!(
        (&sets[0]["id"], &sets[1]["id"]),
        (&Value::from(&*second), &Value::from(&*first))
    );

    let all = format!("{first}, {second}");
    let all_sorted = if first < second {
        all
    } else {
        format!("{second}, {first}")
    };
    desk.refuses(
        &["rollback", "0123456789abcdef"],
        &["keeps no set \"0123456789abcdef\"", &all_sorted],
    );
    desk.refuses(&["rollback", ""], &["keeps no set \"\""]);
    desk.refuses(&["rollback", &first], &["is the active one already"]);
    other_key(&desk);
    desk.refuses(
        &["rollback", "--key", "other.key", &second],
        &["the key is not that of this board", "nothing has changed"],
    );
    desk.refuses(
        &["rollback", &second],
        &[
            "after a wrong key the board takes no change for another ",
            "its own time, which stands still while no host listens",
            &format!(
                "`hexsense capture --seconds 1 --out pause.csv --port {}`",
                desk.port
            ),
        ],
    );
    desk.refuses(
        &["rollback", "--key", "none.key", &second],
        &["none.key: there is no such key file", "--key FILE"],
    );
    assert_eq!(desk.active_id(), first);
}

#[test]
fn a_beginning_that_several_sets_have_is_refused_with_their_names() {
    let desk = Desk::new();
    let ids: Vec<String> = (1..=8).map(|set| desk.upload(set)).collect();
    // Eight identities begin with sixteen possible digits; these are fixed, and two of them share theirs.
    let shared = ids.iter().find_map(|id| {
        let same: Vec<_> = ids.iter().filter(|other| other[..1] == id[..1]).collect();
        (same.len() > 1).then(|| (id[..1].to_owned(), same))
    });
    let (digit, same) = shared.unwrap();
    let mut parts: Vec<&str> = same.iter().map(|id| id.as_str()).collect();
    parts.push("give more digits");
    desk.refuses(&["rollback", &digit], &parts);
}

#[test]
fn factory_reset_asks_erases_and_says_what_stays() {
    let desk = Desk::new();
    for set in 1..=3 {
        desk.upload(set);
    }
    desk.refuses(
        &["factory-reset"],
        &["keeps 3 coefficient sets", "nothing was erased", "--yes"],
    );
    other_key(&desk);
    desk.refuses(
        &["factory-reset", "--yes", "--key", "other.key"],
        &["the key is not that of this board", "nothing has changed"],
    );
    desk.says(&["capture", "--seconds", "2", "--out", "pause.csv"]);
    let said = desk.says(&["factory-reset", "--yes"]);
    assert!(
        said.contains("erased 3 coefficient sets")
            && said.contains("key stays")
            && said.contains("log"),
        "{said}"
    );
    assert_eq!(desk.active_id(), Value::Null);
    assert_eq!(desk.json("history")["sets"], Value::Array(Vec::new()));
    assert_eq!(desk.json("status")["provisioned"], true);
    let id = desk.upload(4);
    assert_eq!(desk.active_id(), id);
}

#[test]
fn the_log_has_every_change_in_order_with_its_time() {
    let desk = Desk::new();
    let start = hexsense_client::change::unix_now();
    let [first, second] = [1, 2].map(|set| desk.upload(set));
    desk.says(&["rollback", &first]);
    desk.says(&["factory-reset", "--yes"]);
    desk.says(&["provision", "--new-key", "--old-key", KEY_FILE]);
    let end = hexsense_client::change::unix_now();
    let log = desk.json("log");
    let (first, second) = (Value::from(first), Value::from(second));
    let none = Value::Null;
    let expected = [
        ("provision", &none, &none),
        ("upload", &first, &none),
        ("upload", &second, &first),
        ("rollback", &first, &second),
        ("factory-reset", &none, &first),
        ("provision", &none, &none),
    ];
    let entries = log["entries"].as_array().unwrap();
    assert_eq!(entries.len(), expected.len(), "{log}");
    for (index, (entry, (what, id, previous))) in entries.iter().zip(expected).enumerate() {
        assert_eq!(entry["change"], index + 1);
        assert_eq!(entry["what"], what);
        assert_eq!(
            (&entry["id"], &entry["previous_id"]),
            (id, previous),
            "{entry}"
        );
        // The fake board got its first key at second 1.
        let unix_s = entry["unix_s"].as_u64().unwrap();
        let due = if index == 0 { 1..=1 } else { start..=end };
        assert!(due.contains(&unix_s), "{entry}");
        assert_eq!(entry["utc"], hexsense_probe::date::utc(unix_s));
    }
    assert_eq!(log["flaws"], Value::Array(Vec::new()));
    let text = desk.says(&["log"]);
    assert_eq!(text.lines().count(), 1 + expected.len() + 1, "{text}");
    assert!(
        text.lines()
            .nth(1)
            .unwrap()
            .starts_with("     1  1970-01-01T00:00:01Z  provision"),
        "{text}"
    );
}

#[test]
fn an_upload_needs_the_key_of_the_board() {
    let desk = Desk::new();
    let set = fake::set::set(1);
    coefficient_file::save(
        &desk.path().join("coefficients.toml"),
        &set,
        &fake::set::sources(),
    )
    .unwrap();
    std::fs::write(desk.path().join("no.key"), "not a key").unwrap();
    desk.refuses(
        &["upload", "--key", "no.key", "coefficients.toml"],
        &["no.key: this is no key file", "64 hexadecimal digits"],
    );
    std::fs::remove_file(desk.path().join(KEY_FILE)).unwrap();
    desk.refuses(
        &["upload", "coefficients.toml"],
        &[
            &format!("{KEY_FILE}: there is no such key file"),
            "hexsense provision",
        ],
    );
    assert_eq!(desk.active_id(), Value::Null);
    fake::key::save(desk.path(), &Still.uid());
    assert!(key_file::load(&desk.path().join(KEY_FILE)).unwrap() == KEY);
    desk.says(&["upload", "coefficients.toml"]);
    assert_ne!(desk.active_id(), Value::Null);
}

#[test]
fn every_command_on_a_board_without_a_key_says_how_to_give_it_one() {
    let desk = Desk::with(FakeBoard::unprovisioned(Box::new(Still)));
    other_key(&desk);
    let set = fake::set::set(1);
    coefficient_file::save(
        &desk.path().join("coefficients.toml"),
        &set,
        &fake::set::sources(),
    )
    .unwrap();
    for arguments in [
        &["upload", "coefficients.toml", "--key", "other.key"][..],
        &["factory-reset", "--yes", "--key", "other.key"],
    ] {
        desk.refuses(arguments, &["the board has no key", "hexsense provision"]);
    }
}

/// A volume with some changes, exported to `one.log`.
fn exported() -> Desk {
    let desk = Desk::new();
    let [first, _] = [1, 2].map(|set| desk.upload(set));
    desk.says(&["rollback", &first]);
    desk.says(&["log", "--export", "one.log"]);
    desk
}

impl Desk {
    /// `hexsense log --check`, without the board.
    fn checks(&self, arguments: &[&str]) -> Result<String, String> {
        let output = Command::cargo_bin("hexsense")
            .unwrap()
            .current_dir(self.path())
            .args(["log", "--check"])
            .args(arguments)
            .output()
            .unwrap();
        let [said, error] =
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        assert!(!error.contains("panicked"), "{error}");
        if output.status.success() {
            Ok(said)
        } else {
            Err(error)
        }
    }
}

#[test]
fn an_exported_log_is_checked_away_from_the_board_and_with_the_key_the_board_is_proven() {
    let desk = exported();
    let chain = desk.checks(&["one.log"]).unwrap();
    assert!(
        chain.contains("changes 1 to 4; no entry is missing or altered"),
        "{chain}"
    );
    assert!(chain.contains("not proven without the key"), "{chain}");
    let proven = desk.checks(&["one.log", "--key", KEY_FILE]).unwrap();
    assert!(
        proven.contains("proven with the key: the board signed it"),
        "{proven}"
    );
    other_key(&desk);
    let other = desk.checks(&["one.log", "--key", "other.key"]).unwrap_err();
    assert!(
        other.contains("the signature is NOT that of this board"),
        "{other}"
    );
    desk.refuses(
        &["log", "--export", "one.log"],
        &["one.log: is there already"],
    );
}

/// Every character of the file is changed in turn. Most changes break the chain or the form; the others do not bear the
/// signature. A change of the signature itself needs the key to be seen.
#[test]
fn no_character_of_an_export_can_be_changed_unseen() {
    let desk = exported();
    let whole = std::fs::read_to_string(desk.path().join("one.log")).unwrap();
    let key = key_file::load(&desk.path().join(KEY_FILE)).unwrap();
    let log = LogFile::parse("one.log", &whole).unwrap();
    assert!(log.is_signed(&key) && volume_flaws(&log.entries, &log.volume).is_empty());
    for at in 0..whole.len() {
        let mut forged = whole.clone().into_bytes();
        forged[at] ^= 1;
        let forged = String::from_utf8(forged).unwrap();
        let passes = LogFile::parse("one.log", &forged).is_ok_and(|log| {
            volume_flaws(&log.entries, &log.volume).is_empty() && log.is_signed(&key)
        });
        assert!(!passes, "{}", &whole[at.saturating_sub(20)..at + 1]);
    }
}

/// Entries that are left out, put in, or put elsewhere, by somebody who gives the right ends.
#[test]
fn entries_that_are_missing_or_out_of_order_are_told() {
    let desk = exported();
    let log = LogFile::load(&desk.path().join("one.log")).unwrap();
    let told = |change: &dyn Fn(&mut Vec<Entry>)| {
        let mut entries = log.entries.clone();
        change(&mut entries);
        volume_flaws(&entries, &log.volume).join("; ")
    };
    assert_eq!(told(&|_| ()), "");
    assert!(
        told(&|entries| entries.retain(|entry| entry.counter != 2))
            .contains("changes 2 to 2 ARE MISSING")
    );
    assert!(
        told(&|entries| entries.retain(|entry| entry.counter != 1))
            .contains("does not begin a volume")
    );
    assert!(told(&|entries| entries.truncate(3)).contains("not the one that was signed"));
    assert!(told(&|entries| entries.swap(1, 2)).contains("WAS ALTERED"));
    assert!(told(&|entries| entries.insert(2, entries[1])).contains("WAS ALTERED"));
    assert!(
        told(&|entries| entries[1].unix_s += 1).contains("change 3 does not follow on change 2")
    );
    let reasons = told(&|entries| entries[0].reason = Reason::Upload);
    assert!(
        reasons.contains("change 2 does not follow on change 1"),
        "{reasons}"
    );
}

#[test]
fn a_new_volume_begins_with_the_hash_of_the_last_entry_of_the_one_before() {
    let desk = Desk::new();
    desk.upload(1);
    desk.refuses(
        &["log", "--new-volume"],
        &["no terminal", "the volume stays open", "--yes"],
    );
    let said = desk.says(&["log", "--export", "one.log", "--new-volume"]);
    assert!(said.contains("change 3 begins a new volume"), "{said}");
    let one = LogFile::load(&desk.path().join("one.log")).unwrap();
    assert_eq!((one.volume.first, one.volume.last), (1, 2));
    let log = desk.json("log");
    let entries = log["entries"].as_array().unwrap();
    assert_eq!(entries.len(), 1, "{log}");
    assert_eq!(entries[0]["what"], "new-volume");
    assert_eq!(entries[0]["chain"], files::hex(&one.volume.head));
    assert_eq!(log["flaws"], Value::Array(Vec::new()));
    assert_eq!(desk.json("status")["log"]["used"], 1);
    desk.upload(2);
    desk.says(&["log", "--export", "two.log"]);
    let said = desk.checks(&["two.log", "--key", KEY_FILE]).unwrap();
    let before = format!(
        "continues the volume whose head is {}",
        files::hex(&one.volume.head)
    );
    assert!(
        said.contains("changes 3 to 4") && said.contains(&before),
        "{said}"
    );
    other_key(&desk);
    desk.refuses(
        &["log", "--new-volume", "--yes", "--key", "other.key"],
        &["the key is not that of this board"],
    );
}

#[test]
fn the_set_that_is_active_is_not_uploaded_again() {
    let desk = Desk::new();
    let id = desk.upload(1);
    let log = desk.json("log");
    let said = desk.says(&["upload", "coefficients.toml"]);
    assert!(
        said.contains(&format!(
            "set {id} was active already and nothing was changed"
        )),
        "{said}"
    );
    assert_eq!(desk.json("log"), log);
}

#[test]
fn a_flash_of_something_else_is_taken_for_the_board_only_after_asking() {
    let mut board = FakeBoard::unprovisioned(Box::new(Still));
    board.flash.0.lock().unwrap().fill(0x5A);
    board.switch_on();
    let desk = Desk::with(board);
    assert_eq!(desk.json("status")["log"]["used"], Value::Null);
    assert!(
        desk.says(&["status"])
            .contains("holds what this firmware did not write")
    );
    desk.refuses(
        &["provision"],
        &["holds something else", "nothing has changed", "--yes"],
    );
    assert!(!desk.path().join(KEY_FILE).exists());
    desk.says(&["provision", "--yes"]);
    let id = desk.upload(1);
    assert_eq!(desk.active_id(), id);
    assert_eq!(desk.json("status")["log"]["used"], 2);
}
