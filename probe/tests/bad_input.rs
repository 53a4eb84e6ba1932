//! Bad input through the command line: a clear message, a status that is not zero, and nothing written.

mod fake;

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use fake::line::lockstep;
use fake::set::set;
use fake::source::{Source, Still};
use fake::{FakeBoard, Fault};
use geometries::PRESETS;
use hexsense_core::wire::VERSION;
use hexsense_probe::coefficient_file;
use tempfile::TempDir;

/// Runs `hexsense` in `folder`; what it says on failure.
fn refusal(folder: &TempDir, arguments: &[&str]) -> String {
    let before = listing(folder.path());
    let output = Command::cargo_bin("hexsense")
        .unwrap()
        .current_dir(folder.path())
        .args(arguments)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success(), "{arguments:?} succeeded: {text}");
    assert_eq!(
        listing(folder.path()),
        before,
        "{arguments:?} wrote something"
    );
    assert!(!text.contains("panicked"), "{text}");
    text
}

/// Every path below `folder`.
fn listing(folder: &Path) -> Vec<String> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            paths.extend(listing(&path));
        }
        paths.push(path.display().to_string());
    }
    paths.sort();
    paths
}

/// A folder with `sensors.toml`, and with `geometry.toml` as `change` makes it of a preset.
fn folder(change: impl FnOnce(&str) -> String) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let (_, text) = PRESETS
        .iter()
        .find(|(name, _)| *name == "an-74tk-200")
        .unwrap();
    fs::write(folder.path().join("geometry.toml"), change(text)).unwrap();
    fs::write(
        folder.path().join("sensors.toml"),
        twin::papers::sensor_file(1),
    )
    .unwrap();
    fake::key::save(folder.path(), &Still.uid());
    folder
}

fn port(change: impl FnOnce(&mut FakeBoard)) -> String {
    let mut board = FakeBoard::new(Box::new(Still));
    change(&mut board);
    lockstep(board)
}

const PLAN: [&str; 5] = ["plan", "--geometry", "geometry.toml", "--out", "campaign"];

fn calibrate(port: &str) -> Vec<&str> {
    let rest = [
        "--geometry",
        "geometry.toml",
        "--sensors",
        "sensors.toml",
        "--out",
        "campaign",
    ];
    ["calibrate", "--port", port]
        .into_iter()
        .chain(rest)
        .collect()
}

#[test]
fn geometry_files_that_are_no_motion_base() {
    let cases: [(&str, &str, &[&str]); 6] = [
        (
            "  [1.5, 0.0, 0.0],\n",
            "",
            &["geometry.toml: upper", "a list of 4", "6 hinges"],
        ),
        (
            "lower = [\n  [",
            "lower = [\n  [nan, ",
            &["geometry.toml: lower[1]", "a list of 4"],
        ),
        (
            "lower = [\n  [1.354455246,",
            "lower = [\n  [nan,",
            &["geometry.toml: lower[1].x", "NaN", "-100 to 100 (m)"],
        ),
        (
            "length_min = 2.10",
            "length_min = 3.50",
            &["geometry.toml", "length_min, 3.5 m", "length_max, 3.4 m"],
        ),
        (
            "home_height = 2.129757",
            "home_height = 5.0",
            &[
                "geometry.toml",
                "home height of 5.0000 m",
                "jack 1",
                "3.4 m",
            ],
        ),
        (
            "home_height = 2.129757",
            "home_hight = 2.1",
            &["geometry.toml", "line", "home_hight"],
        ),
    ];
    for (from, to, expected) in cases {
        let folder = folder(|text| {
            assert!(text.contains(from), "the preset holds {from:?}");
            text.replace(from, to)
        });
        let text = refusal(&folder, &PLAN);
        for part in expected {
            assert!(text.contains(part), "{part:?} is not in: {text}");
        }
        let port = port(|_| {});
        refusal(&folder, &calibrate(&port));
    }
}

#[test]
fn a_geometry_that_is_neither_preset_nor_file() {
    let folder = folder(str::to_owned);
    let text = refusal(&folder, &["plan", "--geometry", "tu-154"]);
    assert!(
        text.contains("tu-154") && text.contains("an-74tk-200"),
        "{text}"
    );
}

#[test]
fn ports_that_lead_nowhere() {
    let folder = folder(str::to_owned);
    let closed = format!("tcp:{}", fake::source::address(&fake::source::listener()));
    for (port, expected) in [
        (
            "/dev/no-such-port",
            "there is no serial port /dev/no-such-port",
        ),
        ("tcp:nonsense", "write tcp:HOST:PORT"),
        (closed.as_str(), "cannot connect to"),
    ] {
        for arguments in [
            calibrate(port),
            vec!["info", "--port", port],
            vec!["show", "--port", port],
        ] {
            let text = refusal(&folder, &arguments);
            assert!(text.contains(expected), "{text}");
        }
    }
}

#[test]
fn firmware_that_speaks_another_wire_version() {
    let folder = folder(str::to_owned);
    let port = port(|board| board.wire = VERSION + 1);
    let text = refusal(&folder, &calibrate(&port));
    assert!(
        text.contains(&format!(
            "firmware 9.8.7 speaks wire version {}",
            VERSION + 1
        )),
        "{text}"
    );
    assert!(text.contains("update hexsense"), "{text}");
}

#[test]
fn a_board_without_its_crystal_is_not_fit_to_calibrate() {
    let folder = folder(str::to_owned);
    let port = port(|board| board.crystal = false);
    assert!(refusal(&folder, &calibrate(&port)).contains("crystal"));
}

#[test]
fn a_plan_that_leaves_the_stroke_names_jack_time_length_and_limit() {
    let folder = folder(str::to_owned);
    Command::cargo_bin("hexsense")
        .unwrap()
        .current_dir(folder.path())
        .args(PLAN)
        .assert()
        .success();
    let path = folder.path().join("campaign/plan.toml");
    let plan = fs::read_to_string(&path).unwrap();
    fs::write(&path, plan.replace("20.0", "44.0")).unwrap();
    let check = [
        "plan",
        "--geometry",
        "geometry.toml",
        "--plan",
        "campaign/plan.toml",
    ];
    let port = port(|_| {});
    for arguments in [check.to_vec(), calibrate(&port)] {
        let text = refusal(&folder, &arguments);
        for part in [
            "campaign/plan.toml: run pitch",
            "s the length of jack",
            "limit 3.4000 m",
        ] {
            assert!(text.contains(part), "{part:?} is not in: {text}");
        }
    }
}

#[test]
fn a_coefficient_file_cut_in_half() {
    let folder = folder(str::to_owned);
    let text = coefficient_file::to_text("", &set(0), &fake::set::sources()).unwrap();
    // Apart from the sensor file, which is that of another campaign.
    fs::create_dir(folder.path().join("set")).unwrap();
    let file = folder.path().join("set/coefficients.toml");
    fs::write(&file, &text[..text.len() / 2]).unwrap();
    let port = port(|_| {});
    let upload = ["upload", "--port", &port, "set"];
    let message = refusal(&folder, &upload);
    assert!(
        message.contains("coefficients.toml is not a whole coefficient file"),
        "{message}"
    );

    fs::write(&file, &text).unwrap();
    Command::cargo_bin("hexsense")
        .unwrap()
        .current_dir(folder.path())
        .args(upload)
        .assert()
        .success();
}

#[test]
fn sensor_files_with_impossible_numbers() {
    let folder = folder(str::to_owned);
    let path = folder.path().join("sensors.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(
        &path,
        text.replace("gravity_m_s2 = 9.80665", "gravity_m_s2 = 980.665"),
    )
    .unwrap();
    let port = port(|_| {});
    let message = refusal(&folder, &calibrate(&port));
    assert!(
        message.contains("sensors.toml: gravity_m_s2 is 980.665; it must be 9.764 to 9.834"),
        "{message}"
    );
}

#[test]
fn a_base_that_does_not_move_is_reported_with_what_to_check() {
    let folder = folder(str::to_owned);
    let port = port(|_| {});
    let output = Command::cargo_bin("hexsense")
        .unwrap()
        .current_dir(folder.path())
        .args(calibrate(&port))
        .write_stdin("\n\n")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success());
    for part in [
        "load campaign/programs/pitch.csv into the motion controller",
        "Start run pitch NOW",
        "no jack has moved within 30 s",
        "campaign is complete up to run zero",
    ] {
        assert!(text.contains(part), "{part:?} is not in: {text}");
    }
}

#[test]
fn a_virtual_board_that_hangs_is_reported_within_five_seconds() {
    let folder = folder(str::to_owned);
    let listener = fake::source::listener();
    let port = format!("lockstep:{}", fake::source::address(&listener));
    let start = std::time::Instant::now();
    let text = refusal(&folder, &["info", "--port", &port]);
    assert!(text.contains("has not answered for 4 s"), "{text}");
    assert!(start.elapsed() < std::time::Duration::from_secs(5));
    drop(listener);
}

#[test]
fn a_board_that_dies_during_a_run_says_what_is_safe_and_how_to_go_on() {
    let folder = folder(str::to_owned);
    // The zero run takes ten seconds, 625 blocks; the board dies in it.
    let port = port(|board| board.fault = Fault::CutAfterBlocks(300));
    let output = Command::cargo_bin("hexsense")
        .unwrap()
        .current_dir(folder.path())
        .args(calibrate(&port))
        .args(["--board-wait", "0"])
        .write_stdin("\n")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success());
    for part in [
        "run zero broke off: the connection to the board",
        "nothing on the board has changed",
        "campaign holds no complete run yet",
        "hexsense calibrate --resume campaign --port lockstep:",
    ] {
        assert!(text.contains(part), "{part:?} is not in: {text}");
    }
    let written = listing(&folder.path().join("campaign/captures"));
    assert!(
        written.iter().all(|path| path.ends_with(".part")),
        "{written:?}"
    );
}
