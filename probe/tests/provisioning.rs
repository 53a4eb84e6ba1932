//! Keys and their files through the command line: a key is made for one provisioning and never sent again, and a board
//! proves that it has the key at hand.

mod fake;

use std::sync::{Arc, Mutex};

use assert_cmd::Command;
use fake::desk::{Desk, KEY_FILE};
use fake::key::KEY;
use fake::source::{Source, Still};
use fake::{FakeBoard, Lie};
use hexsense_core::wire::{Refusal, Request, Response};
use hexsense_probe::key_file;

/// A board that a test looks at, and a desk at its port, without a key file.
fn watched(board: FakeBoard) -> (Arc<Mutex<FakeBoard>>, Desk) {
    let board = Arc::new(Mutex::new(board));
    let desk = Desk {
        folder: tempfile::tempdir().unwrap(),
        port: fake::line::shared(&board),
    };
    (board, desk)
}

/// Names of the key files in the folder.
fn key_files(desk: &Desk) -> Vec<String> {
    let entries = std::fs::read_dir(desk.path()).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter(|name| name.contains(".key")).collect();
    names.sort();
    names
}

/// What answers says that it has no key, as a fake board does that wants the key of the real one.
#[test]
fn a_key_that_exists_is_never_sent() {
    let (board, desk) = watched(FakeBoard::unprovisioned(Box::new(Still)));
    fake::key::save(desk.path(), &Still.uid());
    let told = [
        &format!("{KEY_FILE}: is there already, and a key that exists is never sent") as &str,
        "another board or program answers",
        "the line changes what the board says",
        "the board's flash was erased",
        "--new-key",
    ];
    desk.refuses(&["provision"], &told);
    assert_eq!(key_files(&desk), [KEY_FILE]);
    let heard = |key: &[u8]| {
        let heard = board.lock().unwrap().heard.clone();
        heard.windows(key.len()).any(|bytes| bytes == key)
    };
    // The bytes of a key cross the line as they are, unless one of them is zero.
    assert!(!heard(&KEY.0[1..]));
    let said = desk.says(&["provision", "--new-key"]);
    let old = format!("{KEY_FILE}.old-1");
    assert!(said.contains(&old), "{said}");
    assert!(key_file::load(&desk.path().join(&old)).unwrap() == KEY);
    let fresh = key_file::load(&desk.path().join(KEY_FILE)).unwrap();
    assert!(fresh != KEY);
    assert!(!heard(&KEY.0[1..]));
    let pieces = fresh.0.split(|byte| *byte == 0);
    assert!(pieces.filter(|piece| piece.len() > 4).all(heard));
    assert!(desk.says(&["info"]).contains("board proven"));
}

#[test]
fn every_provisioning_has_a_key_of_its_own() {
    let keys = [(); 2].map(|()| {
        let desk = Desk::with(FakeBoard::unprovisioned(Box::new(Still)));
        desk.says(&["provision"]);
        key_file::load(&desk.path().join(KEY_FILE)).unwrap()
    });
    assert!(keys[0] != keys[1]);
}

/// The same command serves after a failure, with another key: the first has crossed the line.
#[test]
fn a_key_that_was_refused_is_kept_and_not_sent_again() {
    let (board, desk) = watched(FakeBoard::unprovisioned(Box::new(Still)));
    board.lock().unwrap().lie = |request| match request {
        Request::Change { .. } => Lie::Hold(Some(Response::Refused(Refusal::Flash))),
        _ => Lie::None,
    };
    let unused = format!("{KEY_FILE}.unused-1");
    desk.refuses(&["provision"], &["flash failed", &unused]);
    assert_eq!(key_files(&desk), [unused.as_str()]);
    board.lock().unwrap().lie = |_| Lie::None;
    desk.says(&["provision"]);
    let [first, second] = [&unused, KEY_FILE].map(|name| key_file::load(&desk.path().join(name)));
    assert!(first.unwrap() != second.unwrap());
}

/// The board took the key, and its answers are lost: both keys stay, and the command tells how to find out.
#[test]
fn a_replacement_of_unknown_outcome_keeps_both_keys_and_says_how_to_find_out() {
    let (board, desk) = watched(FakeBoard::new(Box::new(Still)));
    fake::key::save(desk.path(), &Still.uid());
    board.lock().unwrap().lie = |request| match request {
        Request::Change { .. } | Request::Prove { .. } => Lie::Hold(None),
        _ => Lie::None,
    };
    let output = desk.run(&["provision", "--new-key", "--old-key", KEY_FILE]);
    let error = String::from_utf8(output.stderr).unwrap();
    let old = format!("{KEY_FILE}.old-1");
    let command = format!("`hexsense info --key {KEY_FILE} --port {}`", desk.port);
    assert!(error.contains(&old) && error.contains(&command), "{error}");
    board.lock().unwrap().lie = |_| Lie::None;
    board.lock().unwrap().deliver();
    assert!(desk.says(&["info"]).contains("board proven"));
    let output = desk.run(&["info", "--key", &old]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        !output.status.success() && said.contains("BOARD NOT PROVEN"),
        "{said}"
    );
}

#[test]
fn commands_say_whether_the_board_is_proven() {
    let desk = Desk::new();
    for command in ["info", "show", "log"] {
        let said = desk.says(&[command]);
        let proven = format!("board proven: it has the key in {KEY_FILE}");
        assert!(said.contains(&proven), "{said}");
        assert_eq!(desk.json(command)["proven"], true);
    }
    desk.upload(1);
    assert!(desk.says(&["show"]).contains("board proven"));
    assert_eq!(desk.json("show")["proven"], true);
    std::fs::remove_file(desk.path().join(KEY_FILE)).unwrap();
    for command in ["info", "show", "log"] {
        let said = desk.says(&[command]);
        let reason = format!("board not proven: there is no {KEY_FILE} here");
        assert!(said.contains(&reason), "{said}");
        assert_eq!(desk.json(command)["proven"], false);
    }
    key_file::create(&desk.path().join("other.key")).unwrap();
    for command in ["info", "show", "log"] {
        let output = desk.run(&[command, "--key", "other.key"]);
        let [said, error] =
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        assert!(!output.status.success(), "{said}");
        assert!(
            said.contains("BOARD NOT PROVEN: other.key: what answers"),
            "{said}"
        );
        assert!(error.contains("NOT PROVEN"), "{error}");
    }
}

/// With a key file of the board in the folder, a board that says it has none is another one, or a lie.
#[test]
fn a_board_that_should_have_a_key_and_says_it_has_none_is_not_proven() {
    let (_board, desk) = watched(FakeBoard::unprovisioned(Box::new(Still)));
    fake::key::save(desk.path(), &Still.uid());
    let output = desk.run(&["info"]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        !output.status.success() && said.contains("so the board had a key"),
        "{said}"
    );
}

/// The real board proves itself, and somebody on the line shows another set and another log.
#[test]
fn a_line_that_changes_what_a_proven_board_says_is_found_out() {
    let (board, desk) = watched(FakeBoard::new(Box::new(Still)));
    fake::key::save(desk.path(), &Still.uid());
    desk.upload(1);
    type Told = (&'static str, &'static str, fn(&Request) -> Lie);
    let lies: [Told; 2] = [
        (
            "show",
            "the board proves that its set is",
            |request| match request {
                Request::ActiveSet => Lie::Hold(Some(Response::ActiveSet(None))),
                _ => Lie::None,
            },
        ),
        (
            "log",
            "the board proves that its last change is 2, and on the line it is 0",
            |request| match request {
                Request::Log { .. } => Lie::Hold(Some(Response::Log {
                    last: 0,
                    entries: Default::default(),
                })),
                _ => Lie::None,
            },
        ),
    ];
    for (command, told, lie) in lies {
        board.lock().unwrap().lie = lie;
        let output = desk.run(&[command]);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && error.contains(told), "{error}");
    }
}

#[test]
fn a_damaged_key_is_told_with_what_to_do_and_nothing_can_be_changed() {
    let (board, desk) = watched(FakeBoard::new(Box::new(Still)));
    fake::key::save(desk.path(), &Still.uid());
    desk.upload(1);
    {
        let mut board = board.lock().unwrap();
        // Both copies, in the first page behind eight pages of sets.
        for copy in [0, 1_024] {
            board.flash.0.lock().unwrap()[8 * 2_048 + copy + 20] ^= 0x81;
        }
        board.switch_on();
    }
    assert_eq!(desk.json("status")["key_damaged"], true);
    for command in ["status", "info"] {
        let said = desk.says(&[command]);
        assert!(
            said.contains("DAMAGED") && said.contains("debug probe"),
            "{said}"
        );
    }
    let damaged = ["can no longer read it", "erase flash bank 2"];
    for arguments in [
        &["provision"][..],
        &["provision", "--new-key"],
        &["provision", "--new-key", "--old-key", KEY_FILE],
        &["upload", "coefficients.toml"],
        &["factory-reset", "--yes"],
    ] {
        desk.refuses(arguments, &damaged);
    }
    assert_eq!(key_files(&desk), [KEY_FILE]);
    assert!(desk.active_id().is_string(), "it measures on with its set");
}

#[test]
fn verify_stops_before_anything_moves_when_the_board_is_not_the_one_of_the_key() {
    let bench = fake::bench::Bench::new(|_| {});
    assert!(bench.record("calibrate").status.success());
    assert!(bench.hexsense(&["upload", "campaign"]).status.success());
    key_file::create(&bench.folder.path().join("other.key")).unwrap();
    let output = bench.record_at("verify", &["--key", "other.key"]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        !output.status.success() && error.contains("the board is NOT PROVEN"),
        "{error}"
    );
    assert!(!bench.campaign().is_recorded("held-out"));
    assert!(
        !bench
            .folder
            .path()
            .join("campaign/verification.json")
            .exists()
    );
}

/// `--help` names the default.
#[test]
fn the_default_key_file_is_told() {
    for command in ["provision", "upload", "info"] {
        let output = Command::cargo_bin("hexsense")
            .unwrap()
            .args([command, "--help"])
            .output()
            .unwrap();
        let help = String::from_utf8(output.stdout).unwrap();
        assert!(help.contains("hexsense-UNIQUEID.key"), "{help}");
    }
}
