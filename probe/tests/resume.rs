//! A campaign that breaks off: what is safe, and how it goes on.

mod fake;

use std::path::Path;

use fake::Fault;
use fake::bench::{Bench, GEOMETRY};
use hexsense_probe::coefficient_file;
use hexsense_probe::files;

/// The zero run takes about 700 blocks, so the board goes away in the run after it.
const IN_PITCH: u64 = 1_500;

fn said(output: &std::process::Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn assert_says(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{part:?} is not in: {text}");
    }
}

#[test]
fn a_board_unplugged_in_a_run_is_waited_for_and_the_run_is_recorded_again() {
    for (fault, went) in [
        (
            Fault::CutAfterBlocks(IN_PITCH),
            "it has restarted (PowerOn)",
        ),
        (Fault::LineCutAfterBlocks(IN_PITCH), "it has kept sampling"),
    ] {
        let bench = Bench::new(|board| board.fault = fault);
        let output = bench.record("calibrate");
        let text = said(&output);
        assert!(output.status.success(), "{text}");
        assert_says(
            &text,
            &[
                "run pitch: the connection to the board on",
                "waiting 60 s for the board to come back",
                went,
                "run pitch is recorded again from its start",
            ],
        );
        // The analysis refuses captures with gaps, so the new recording holds nothing of the old one.
        assert!(bench.campaign().folder.join("coefficients.toml").exists());
    }
}

#[test]
fn another_board_in_the_place_of_the_lost_one_is_refused() {
    let bench = Bench::new(|board| board.fault = Fault::SwappedAfterBlocks(IN_PITCH));
    let output = bench.record("calibrate");
    let text = said(&output);
    assert!(!output.status.success());
    let other = files::hex(b"fake board 2");
    assert_says(
        &text,
        &[
            "run pitch broke off: board",
            &other,
            "safe:    nothing on the board has changed",
            "do next:",
        ],
    );
    assert!(!bench.campaign().is_recorded("pitch"));
}

#[test]
fn a_board_that_comes_back_but_samples_nothing_is_reported() {
    let bench = Bench::new(|board| board.fault = Fault::StarvesAfterBlocks(IN_PITCH));
    let text = said(&bench.record("calibrate"));
    assert_says(
        &text,
        &["run pitch broke off: no samples have come from", "safe:"],
    );
    assert_eq!(text.matches("run pitch is recorded again").count(), 2);
}

#[test]
fn a_campaign_that_broke_off_goes_on_from_its_folder_alone() {
    let bench = Bench::new(|board| board.fault = Fault::CutAfterBlocks(IN_PITCH));
    let output = bench.record_at("calibrate", &["--rate", "2000", "--board-wait", "0"]);
    let text = said(&output);
    let go_on = format!(
        "hexsense calibrate --resume campaign --port {} --twin {} --board-wait 0",
        bench.port, bench.control
    );
    assert_says(
        &text,
        &[
            "run pitch broke off: the connection",
            "campaign is complete up to run zero",
            &go_on,
        ],
    );
    let campaign = bench.campaign();
    let zero = std::fs::read(campaign.capture_path("zero")).unwrap();
    let part = files::part_of(&campaign.capture_path("pitch"));
    let torn = std::fs::read_to_string(&part).unwrap();
    std::fs::write(&part, &torn[..torn.len() - 5]).unwrap();
    std::fs::remove_file(bench.folder.path().join("sensors.toml")).unwrap();

    let output = bench.hexsense(&[
        "calibrate",
        "--resume",
        "campaign",
        "--twin",
        &bench.control,
    ]);
    let text = said(&output);
    assert!(output.status.success(), "{text}");
    assert_says(
        &text,
        &[
            "run 1 of 7: zero is recorded already",
            "run pitch broke off before, after",
            "is torn after",
            "it is recorded again from its start",
        ],
    );
    assert!(!part.exists());
    assert_eq!(std::fs::read(campaign.capture_path("zero")).unwrap(), zero);
    assert_eq!(campaign.record("pitch-sine").unwrap().rate_hz, 2_000);
    let (set, _) = coefficient_file::load(&campaign.folder.join("coefficients.toml")).unwrap();
    assert_eq!(
        set.unix_s, 1_780_000_000,
        "the date is the one it was begun with"
    );
}

#[test]
fn what_contradicts_the_folder_is_named_beside_what_the_folder_holds() {
    let bench = Bench::new(|board| board.fault = Fault::CutAfterBlocks(IN_PITCH));
    bench.record_at("calibrate", &["--board-wait", "0"]);
    std::fs::write(
        bench.folder.path().join("others.toml"),
        twin::papers::sensor_file(99) + "\n",
    )
    .unwrap();
    let before = contents(&bench.folder.path().join("campaign"));
    for (given, held) in [
        (["--geometry", "tu-204"], "an-74tk-200 (geometry.toml)"),
        (
            ["--sensors", "others.toml"],
            "another sensor file (sensors.toml)",
        ),
        (["--rate", "4000"], "--rate 1000"),
        (["--date", "1790000000"], "--date 1780000000"),
    ] {
        let arguments = [&["calibrate", "--resume", "campaign"], &given[..]].concat();
        let text = said(&bench.hexsense(&arguments));
        let named = format!(
            "{} contradicts the campaign in campaign, which was begun with {held}",
            given.join(" ")
        );
        assert_says(&text, &[&named]);
    }
    let elsewhere = ["calibrate", "--resume", "campaign", "--out", "other"];
    assert_says(&said(&bench.hexsense(&elsewhere)), &["--resume", "--out"]);
    assert!(contents(&bench.folder.path().join("campaign")) == before);
    let same = ["--geometry", GEOMETRY, "--sensors", "sensors.toml"];
    let same = [
        &["calibrate", "--resume", "campaign", "--rate", "1000"],
        &same[..],
        &["--twin", &bench.control],
    ];
    assert!(bench.hexsense(&same.concat()).status.success());
}

#[test]
fn a_folder_without_a_begun_campaign_is_nothing_to_resume() {
    let bench = Bench::new(|_| {});
    bench.plan(|_| {});
    for folder in ["campaign", "nowhere"] {
        let text = said(&bench.hexsense(&["calibrate", "--resume", folder]));
        assert_says(
            &text,
            &[&format!("{folder} holds no campaign that was begun")],
        );
    }
}

#[test]
fn a_plan_that_lacks_a_run_is_refused_before_anything_moves() {
    for (run, says) in [
        ("zero", "add a zero run"),
        ("roll", "add ramps and holds in roll"),
        ("heave", "add a heave sine"),
        ("yaw-sine", "add a yaw sine"),
    ] {
        let bench = Bench::new(|_| {});
        bench.plan(|plan| plan.runs.retain(|planned| planned.name != run));
        let output = bench.record("calibrate");
        let text = said(&output);
        assert!(!output.status.success(), "{text}");
        assert_says(&text, &["campaign/plan.toml: ", says, "Nothing has moved"]);
        assert!(contents(&bench.folder.path().join("campaign/captures")).is_empty());
    }
}

/// All files below a folder with what they hold.
fn contents(folder: &Path) -> Vec<(std::path::PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(contents(&path));
        } else {
            all.push((path.clone(), std::fs::read(&path).unwrap()));
        }
    }
    all.sort();
    all
}
