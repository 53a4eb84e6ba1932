//! A whole campaign through the command line: the twin moves and feels, a board made of the core's parts measures.

mod fake;

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use fake::line::lockstep;
use fake::source::{self, Pins, Still};
use fake::{FakeBoard, Fault};
use hexsense_probe::campaign::Campaign;
use hexsense_probe::plan::Plan;
use hexsense_probe::replay::replay;

const GEOMETRY: &str = "an-74tk-200";
const SEED: u64 = 7;

struct Bench {
    folder: tempfile::TempDir,
    port: String,
    control: String,
}

impl Bench {
    fn new(change: impl FnOnce(&mut FakeBoard)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(
            folder.path().join("sensors.toml"),
            twin::papers::sensor_file(SEED),
        )
        .unwrap();
        fake::key::save(folder.path());
        let (pins, control) = source::twin(SEED, GEOMETRY);
        let mut board = FakeBoard::new(Box::new(Pins::connect(&pins)));
        change(&mut board);
        Self {
            folder,
            port: lockstep(board),
            control,
        }
    }

    fn hexsense(&self, arguments: &[&str]) -> Output {
        let output = Command::cargo_bin("hexsense")
            .unwrap()
            .current_dir(self.folder.path())
            .args(arguments)
            .args(["--port", &self.port])
            .output()
            .unwrap();
        eprintln!(
            "{}{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
        output
    }

    fn record(&self, command: &str) -> Output {
        self.record_at(command, &[])
    }

    fn record_at(&self, command: &str, rate: &[&str]) -> Output {
        let base = [
            command,
            "--geometry",
            GEOMETRY,
            "--sensors",
            "sensors.toml",
            "--out",
            "campaign",
        ];
        let rest = ["--twin", self.control.as_str(), "--date", "1780000000"];
        self.hexsense(&[base.as_slice(), rest.as_slice(), rate].concat())
    }

    /// Plans only these runs, which is less than a calibration needs but enough to record.
    fn plan_only(&self, runs: &[&str]) {
        let mut command = Command::cargo_bin("hexsense").unwrap();
        command.current_dir(self.folder.path());
        command
            .args(["plan", "--geometry", GEOMETRY, "--out", "campaign"])
            .assert()
            .success();
        let path = self.folder.path().join("campaign/plan.toml");
        let mut plan = Plan::load(&path).unwrap();
        plan.runs.retain(|run| runs.contains(&run.name.as_str()));
        std::fs::write(&path, plan.to_toml()).unwrap();
    }

    fn campaign(&self) -> Campaign {
        Campaign::open(&self.folder.path().join("campaign")).unwrap()
    }
}

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

#[test]
fn a_campaign_is_recorded_uploaded_shown_and_proved() {
    let bench = Bench::new(|_| {});
    assert!(bench.record("calibrate").status.success());
    let campaign = bench.campaign();
    assert_replay(&campaign, "roll-sine");
    let file = campaign.folder.join("coefficients.toml");
    let set = hexsense_probe::coefficient_file::load(Path::new(&file)).unwrap();
    assert_eq!(set.unix_s, 1_780_000_000);

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
    let report = std::fs::read_to_string(campaign.folder.join("report.html")).unwrap();
    assert!(report.contains("held-out") && report.contains("<svg"));
    let again = bench.record("calibrate");
    assert!(String::from_utf8_lossy(&again.stderr).contains("finished campaign"));
}

#[test]
fn a_campaign_at_four_kilohertz_is_calibrated_and_not_mixed_with_another_rate() {
    let bench = Bench::new(|_| {});
    bench.plan_only(&["heave", "roll-sine"]);
    let text = String::from_utf8(bench.record_at("calibrate", &["--rate", "4000"]).stderr).unwrap();
    let campaign = bench.campaign();
    for run in ["heave", "roll-sine"] {
        assert_eq!(campaign.record(run).unwrap().rate_hz, 4_000, "{text}");
        assert_replay(&campaign, run);
    }
    let text = String::from_utf8(bench.record("calibrate").stderr).unwrap();
    assert!(
        text.contains("run heave is recorded at 4000 Hz") && text.contains("--rate 4000"),
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
fn a_campaign_that_broke_off_goes_on_where_it_was() {
    // The zero run takes 625 blocks; the board dies in the run after it.
    // The zero run takes about 700 blocks; the board dies in the run after it, and the base goes home meanwhile.
    let bench = Bench::new(|board| board.fault = Fault::CutAfterBlocks(1_500));
    bench.plan_only(&["zero", "pitch", "heave"]);
    let text = String::from_utf8(bench.record("calibrate").stderr).unwrap();
    assert!(text.contains("run pitch broke off"), "{text}");
    assert!(
        text.contains("campaign is complete up to run zero"),
        "{text}"
    );
    let campaign = bench.campaign();
    let zero = std::fs::read(campaign.capture_path("zero")).unwrap();
    assert!(!campaign.is_recorded("pitch"));

    let text = String::from_utf8(bench.record("calibrate").stderr).unwrap();
    assert!(text.contains("zero is recorded already"), "{text}");
    assert!(campaign.is_recorded("pitch") && campaign.is_recorded("heave"));
    assert_eq!(std::fs::read(campaign.capture_path("zero")).unwrap(), zero);
    assert!(
        text.contains("the campaign has no"),
        "what was not planned is missed: {text}"
    );
}

#[test]
fn a_campaign_is_not_mixed_with_another_board_or_another_plan() {
    let bench = Bench::new(|_| {});
    bench.plan_only(&["heave"]);
    bench.record("calibrate");
    let other = lockstep(FakeBoard::new(Box::new(Still)));
    let other = Bench {
        port: other,
        ..bench
    };
    let text = String::from_utf8(other.record("calibrate").stderr).unwrap();
    assert!(text.contains("holds a campaign with board"), "{text}");

    let mut campaign = other.campaign();
    campaign.plan.runs[0].sine[0].amplitude_m = Some(0.1);
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
        bench.plan_only(&["heave"]);
        bench.record("calibrate");
        std::fs::read(bench.campaign().capture_path("heave")).unwrap()
    };
    assert!(heave() == heave());
}

#[test]
fn lost_blocks_are_a_gap_in_the_capture_and_refused_by_the_analysis() {
    let bench = Bench::new(|board| board.lose_blocks = 100..102);
    bench.plan_only(&["zero"]);
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
            .map(|gap| gap.missing)
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
