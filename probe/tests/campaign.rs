//! A whole campaign through the command line: the twin moves and feels, a board made of the core's parts measures.

mod fake;

use std::path::Path;

use fake::bench::Bench;
use fake::line::lockstep;
use fake::source::Still;
use fake::{FakeBoard, Fault};
use hexsense_probe::campaign::Campaign;
use hexsense_probe::replay::replay;

/// The board's sums of a run are those that its capture gives, over whole periods at full amplitude.
fn assert_replay(campaign: &Campaign, run: &str) {
    let (record, capture) = (
        campaign.record(run).unwrap(),
        campaign.capture(run).unwrap(),
    );
    let [sums] = record.board_sums.as_slice() else {
        panic!("{record:?}")
    };
    replay(sums, &capture).unwrap();
    let (_, sine) = campaign.plan.run(run).unwrap().single_sine().unwrap();
    let period_s = 1.0 / f64::from(record.rate_hz);
    let block_s = record.block.scans() as f64 * period_s;
    let start_s = (sums.first_scan - record.onset_scan.unwrap()) as f64 * period_s;
    let length_s = f64::from(sums.drive.blocks) * block_s;
    assert!(start_s > sine.fade_s && (start_s - sine.estimate_start_s()).abs() < 0.2);
    assert!((length_s - sine.estimate_s).abs() <= 0.51 * block_s);
}

fn report(campaign: &Campaign) -> String {
    std::fs::read_to_string(campaign.folder.join("report.html")).unwrap()
}

/// From the folder alone comes the very page that the run made.
fn render_again(bench: &Bench, campaign: &Campaign) {
    let path = campaign.folder.join("report.html");
    let made = std::fs::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let again = bench.without_board(&["report", "campaign"]);
    let said = String::from_utf8(again.stderr).unwrap();
    assert!(again.status.success(), "{said}");
    assert!(said.contains("the numbers of results.json again"), "{said}");
    assert!(std::fs::read(&path).unwrap() == made, "another page");
}

#[test]
fn a_campaign_is_recorded_uploaded_shown_and_proved() {
    let bench = Bench::new(|_| {});
    assert!(bench.record("calibrate").status.success());
    let campaign = bench.campaign();
    assert_replay(&campaign, "roll-sine");
    let file = campaign.folder.join("coefficients.toml");
    let (set, _) = hexsense_probe::coefficient_file::load(Path::new(&file)).unwrap();
    assert_eq!(set.unix_s, 1_780_000_000);

    render_again(&bench, &campaign);

    let early = String::from_utf8(bench.record("verify").stderr).unwrap();
    assert!(early.contains("the board has no coefficients"), "{early}");

    assert!(bench.hexsense(&["upload", "campaign"]).status.success());
    let shown = bench.hexsense(&["show", "--json"]).stdout;
    let shown: serde_json::Value = serde_json::from_slice(&shown).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    let shown_id = shown["id"].as_str().map(str::to_owned);
    assert!(text.contains(shown["id"].as_str().unwrap()));
    // The base is at home, 2.13 m high, to the millimetres that its hinges and transducers are off.
    let height = shown["pose"]["y"].as_f64().unwrap();
    assert!((height - 2.129757).abs() < 0.005, "{shown}");
    assert!(shown["pose"]["condition"].as_f64().unwrap() < 5.0);
    let shown = String::from_utf8(bench.hexsense(&["show"]).stdout).unwrap();
    assert!(
        shown.contains("pose      x ") && shown.contains("jack6"),
        "{shown}"
    );

    let verified = bench.record("verify");
    assert!(verified.status.success());
    let said = String::from_utf8(verified.stdout).unwrap();
    assert!(said.contains("poses of the board: at most"), "{said}");
    let capture = campaign.capture("held-out").unwrap();
    assert!(capture.values.is_some());
    let record = campaign.record("held-out").unwrap();
    let sums = &record.board_sums;
    assert_eq!(sums.len(), 3, "six sines, three analysers");
    assert!(sums.iter().all(|sums| replay(sums, &capture).is_ok()));
    assert_eq!(record.set.as_deref(), shown_id.as_deref());
    let report = report(&campaign);
    assert!(report.contains("held-out") && report.contains("<svg"));
    render_again(&bench, &campaign);
    let again = bench.record("calibrate");
    assert!(String::from_utf8_lossy(&again.stderr).contains("finished campaign"));
}

#[test]
fn a_campaign_at_four_kilohertz_is_calibrated_and_not_mixed_with_another_rate() {
    let bench = Bench::new(|_| {});
    let text = String::from_utf8(bench.record_at("calibrate", &["--rate", "4000"]).stderr).unwrap();
    let campaign = bench.campaign();
    for run in ["heave", "roll-sine"] {
        assert_eq!(campaign.record(run).unwrap().rate_hz, 4_000, "{text}");
        assert_replay(&campaign, run);
    }
    let again = bench.record_at("calibrate", &["--rate", "1000"]);
    let text = String::from_utf8(again.stderr).unwrap();
    assert!(
        text.contains("--rate 1000 contradicts the campaign in campaign")
            && text.contains("begun with --rate 4000"),
        "{text}"
    );
}

#[test]
fn a_board_whose_pose_is_off_by_a_micrometre_does_not_pass() {
    let bench = Bench::new(|board| board.fault = Fault::PoseOff(1e-6));
    assert!(bench.record("calibrate").status.success());
    assert!(bench.hexsense(&["upload", "campaign"]).status.success());
    let verified = bench.record("verify");
    let said = String::from_utf8(verified.stderr).unwrap();
    assert!(!verified.status.success());
    assert!(
        said.contains("the board's pose is off by") && said.contains("limit of 5e-7 m"),
        "{said}"
    );
}

#[test]
fn a_campaign_is_not_mixed_with_another_board_or_another_plan() {
    let bench = Bench::new(|_| {});
    bench.record("calibrate");
    std::fs::remove_file(bench.campaign().folder.join("coefficients.toml")).unwrap();
    let other = lockstep(FakeBoard::new(Box::new(Still)));
    let other = Bench {
        port: other,
        ..bench
    };
    let text = String::from_utf8(other.record("calibrate").stderr).unwrap();
    assert!(text.contains("holds a campaign with board"), "{text}");

    let mut campaign = other.campaign();
    let heave = campaign.plan.runs.iter_mut();
    let heave = heave.filter(|run| run.name == "heave");
    heave.for_each(|run| run.sine[0].amplitude_m = Some(0.1));
    let error = campaign.record("heave").unwrap_err().to_string();
    assert!(
        error.contains("run heave recorded before its plan was changed"),
        "{error}"
    );
}

#[test]
fn the_same_seed_gives_the_same_captures() {
    let heave = || {
        let bench = Bench::new(|_| {});
        bench.record("calibrate");
        std::fs::read(bench.campaign().capture_path("heave")).unwrap()
    };
    assert!(heave() == heave());
}

#[test]
fn lost_blocks_are_a_gap_in_the_capture_and_refused_by_the_analysis() {
    let bench = Bench::new(|board| board.lose_blocks = 100..102);
    let output = bench.record("calibrate");
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success());
    assert!(text.contains("run zero: 32 of"), "{text}");
    assert!(text.contains("run zero: 32 scans are missing"), "{text}");
    let capture = bench.campaign().capture("zero").unwrap();
    assert_eq!(
        capture
            .gaps()
            .iter()
            .map(|gap| gap.scans)
            .collect::<Vec<_>>(),
        [32]
    );
    assert!(
        !bench
            .folder
            .path()
            .join("campaign/coefficients.toml")
            .exists()
    );
}
