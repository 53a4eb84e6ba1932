//! `hexsense calibrate` refuses a bench that is not what its files say, names the culprit, and goes on when that is
//! accepted.

mod fake;

use fake::bench::Bench;
use fake::source::{Pins, Source};
use hexsense_core::channel::Scan;
use serde_json::Value;

/// A twin's voltages with two channels exchanged.
struct Exchanged(Pins, usize, usize);

impl Source for Exchanged {
    fn scan(&mut self, rate_hz: u32) -> Scan {
        let mut scan = self.0.scan(rate_hz);
        scan.swap(self.1, self.2);
        scan
    }

    fn supply(&self) -> f32 {
        self.0.supply()
    }

    fn uid(&self) -> [u8; 12] {
        self.0.uid()
    }
}

/// What results.json holds of the check of this name.
fn noted(bench: &Bench, name: &str) -> Value {
    let path = bench.campaign().folder.join("results.json");
    let results: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let checks = results["checks"].as_array().unwrap();
    assert_eq!(checks.len(), 12);
    let check = checks.iter().find(|check| check["name"] == name);
    check.unwrap().clone()
}

#[test]
fn exchanged_gyros_end_with_status_3_and_nothing_to_upload_until_that_is_accepted() {
    // wx and wz.
    let bench = Bench::measuring(|pins| Box::new(Exchanged(pins, 6, 8)));
    let refused = bench.record("calibrate");
    assert_eq!(refused.status.code(), Some(3));
    let said = String::from_utf8(refused.stderr).unwrap();
    let last = said.lines().last().unwrap();
    assert_eq!(
        last,
        "  sensor direction: wx lies along the axis of wz: are their plugs exchanged?; \
         wz lies along the axis of wx: are their plugs exchanged?"
    );
    let folder = bench.campaign().folder;
    assert!(!folder.join("coefficients.toml").exists() && !folder.join("report.html").exists());
    let check = noted(&bench, "sensor direction");
    assert_eq!(check["verdict"], "fail");
    assert_eq!(check["unit"], "deg");
    let mut names: Vec<&str> = check["names"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(Value::as_str)
        .collect();
    names.sort();
    assert_eq!(names, ["wx", "wz"]);
    let (angle, limit) = (
        check["statistic"].as_f64().unwrap(),
        check["limit"].as_f64().unwrap(),
    );
    assert!(
        (85.0..95.0).contains(&angle) && (2.0..3.0).contains(&limit),
        "{check}"
    );
    assert_eq!(noted(&bench, "jack gain")["verdict"], "pass");

    let unknown = bench.record_at("calibrate", &["--accept", "wiring=I know"]);
    let said = String::from_utf8(unknown.stderr).unwrap();
    assert!(
        said.contains("there is no check wiring; there are movement, jacks follow,"),
        "{said}"
    );

    let reason = "the plugs are exchanged & that is known";
    let accepted = bench.record_at(
        "calibrate",
        &["--accept", &format!("sensor direction={reason}")],
    );
    assert_eq!(accepted.status.code(), Some(0));
    assert_eq!(noted(&bench, "sensor direction")["accepted"], reason);
    assert!(folder.join("coefficients.toml").exists());
    let report = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(report.contains("fail, accepted") && report.contains("exchanged &amp; that is known"));
    let again = bench.without_board(&["report", "campaign"]);
    let said = String::from_utf8(again.stderr).unwrap();
    assert!(said.contains("the numbers of results.json again"), "{said}");
}

#[test]
fn exchanged_jacks_are_named_although_no_numbers_come_out_and_a_run_can_be_repeated() {
    let bench = Bench::measuring(|pins| Box::new(Exchanged(pins, 10, 13)));
    let refused = bench.record("calibrate");
    assert_eq!(refused.status.code(), Some(3));
    let said = String::from_utf8(refused.stderr).unwrap();
    let named = "jack2 follows the program of jack5: are their plugs exchanged?; jack5 follows the program of jack2";
    assert!(said.contains(named), "{said}");
    assert!(!bench.campaign().folder.join("coefficients.toml").exists());

    let recorded = |run: &str| {
        let path = bench.campaign().folder.join(format!("captures/{run}.json"));
        std::fs::metadata(path).unwrap().modified().unwrap()
    };
    let before = ["heave", "zero"].map(recorded);
    assert_eq!(
        bench
            .record_at("calibrate", &["--repeat", "heave"])
            .status
            .code(),
        Some(3)
    );
    let after = ["heave", "zero"].map(recorded);
    assert!(
        after[0] > before[0] && after[1] == before[1],
        "heave alone is recorded again"
    );

    let unknown = bench.record_at("calibrate", &["--repeat", "surge"]);
    assert_eq!(unknown.status.code(), Some(1));
    let said = String::from_utf8(unknown.stderr).unwrap();
    assert!(
        said.contains("the plan has no run surge; it has zero,"),
        "{said}"
    );
}
