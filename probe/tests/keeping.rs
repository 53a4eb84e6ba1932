//! The commands that change what the board keeps and show what was changed, as a user types them.

mod fake;

use fake::FakeBoard;
use fake::desk::{Desk, KEY_FILE};
use fake::key::KEY;
use fake::source::{Source, Still};
use hexsense_probe::{coefficient_file, key_file};
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
    assert_eq!(log["missing"], Value::Array(Vec::new()));
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
