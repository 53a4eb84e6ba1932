//! A campaign after it is recorded: rendered again without a board, and its motion system measured beside it.

mod fake;

use std::fs;
use std::path::Path;

use fake::bench::Bench;
use hexsense_probe::characteristics::Characteristics;
use hexsense_probe::plan::{Freedom, Purpose, Run, SineEntry};

/// A sine that no coefficient is fitted to: at a frequency of its own, in a freedom that the fit takes once.
fn slow_heave() -> Run {
    Run {
        name: "slow-heave".to_owned(),
        purpose: Purpose::Characterise,
        rest_s: None,
        ramps: Vec::new(),
        sine: vec![SineEntry {
            freedom: Freedom::Heave,
            amplitude_deg: None,
            amplitude_m: Some(0.1),
            frequency_hz: 0.25,
            fade_s: 2.0,
            settle_s: 4.0,
            estimate_s: 12.0,
        }],
        multisine: None,
    }
}

fn characteristics(folder: &Path) -> Characteristics {
    let text = fs::read_to_string(folder.join("characteristics.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn a_run_that_characterises_is_measured_beside_the_calibration_and_touches_no_coefficient() {
    let bench = Bench::new(|_| {});
    bench.plan(|plan| plan.runs.insert(1, slow_heave()));
    let folder = bench.folder.path().join("campaign");
    let early = bench.without_board(&["report", "campaign"]);
    assert!(String::from_utf8_lossy(&early.stderr).contains("holds no campaign that was begun"));

    assert!(bench.record("calibrate").status.success());
    assert!(!bench.campaign().is_recorded("slow-heave"));
    let calibrated = characteristics(&folder).frequency_response;
    let runs = ["heave", "roll-sine", "yaw-sine", "pitch-sine"];
    assert!(
        calibrated
            .iter()
            .map(|response| response.run.as_str())
            .eq(runs)
    );

    let result = |name: &str| fs::read(folder.join(name)).unwrap();
    let before = ["coefficients.toml", "results.json"].map(result);
    let control = bench.control.as_str();
    let measured = bench.hexsense(&["characterise", "campaign", "--twin", control]);
    assert!(measured.status.success());
    assert!(["coefficients.toml", "results.json"].map(result) == before);
    let all = characteristics(&folder).frequency_response;
    assert_eq!(all[..4], calibrated);
    let slow = &all[4];
    assert_eq!((slow.run.as_str(), all.len()), ("slow-heave", 5));
    assert!(
        (slow.frequency_hz - 0.25).abs() < 1e-3 && (slow.ratio - 1.0).abs() < 0.02,
        "{slow:?}"
    );

    assert!(
        bench
            .without_board(&["report", "campaign"])
            .status
            .success()
    );
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.contains("0.2500") && page.contains("<td>characterise</td>"));
}

#[test]
fn what_is_missing_or_changed_is_named_with_what_to_run() {
    let bench = Bench::new(|_| {});
    assert!(bench.record("calibrate").status.success());
    let folder = bench.folder.path().join("campaign");
    let refused = |file: &str, change: &dyn Fn(&Path)| {
        let path = folder.join(file);
        let kept = fs::read(&path).unwrap();
        change(&path);
        let output = bench.without_board(&["report", "campaign"]);
        assert_eq!(output.status.code(), Some(1), "{file}");
        fs::write(&path, kept).unwrap();
        String::from_utf8(output.stderr).unwrap()
    };
    let removed = |file: &str| refused(file, &|path| fs::remove_file(path).unwrap());
    for file in ["coefficients.toml", "results.json"] {
        let said = removed(file);
        assert!(
            said.contains(&format!("campaign/{file} is missing"))
                && said.contains("hexsense calibrate --resume campaign"),
            "{said}"
        );
    }
    let said = removed("captures/heave.json");
    assert!(
        said.contains("no recording of run heave") && said.contains("hexsense calibrate"),
        "{said}"
    );
    assert!(removed("geometry.toml").contains("geometry.toml: cannot be read"));
    assert!(removed("board.json").contains("board.json: cannot be read"));
    let said = refused("captures/heave.csv", &|path| {
        let text = fs::read_to_string(path).unwrap();
        fs::write(path, text.trim_end().rsplit_once('\n').unwrap().0).unwrap();
    });
    assert!(
        said.contains("campaign/captures is not what the coefficients were found from"),
        "{said}"
    );
    let none = bench.hexsense(&["characterise", "campaign"]);
    let said = String::from_utf8(none.stderr).unwrap();
    assert!(said.contains("plans no run to characterise with"), "{said}");
}
