//! A plan is judged before anything moves.

use assert_cmd::Command;
use hexsense_probe::geometry_file::GeometryFile;
use hexsense_probe::plan::forecast::{Forecast, forecast};
use hexsense_probe::plan::{Plan, campaign};
use hexsense_probe::sensor_file::SensorFile;

const GEOMETRY: &str = "an-74tk-200";

fn geometry() -> GeometryFile {
    GeometryFile::load(GEOMETRY).unwrap()
}

/// The forecast of the default plan as `change` leaves it.
fn forecast_of(change: impl FnOnce(&mut Plan)) -> Forecast {
    let geometry = geometry();
    let sensors = SensorFile::parse("sensors.toml", &twin::papers::sensor_file(7)).unwrap();
    let mut plan = campaign::plan(&geometry).unwrap();
    change(&mut plan);
    forecast(&plan, &geometry, &sensors).unwrap()
}

fn without(run: &str) -> impl FnOnce(&mut Plan) {
    move |plan| plan.runs.retain(|kept| kept.name != run)
}

#[test]
fn the_default_plan_determines_all_nine_gains() {
    let forecast = forecast_of(|_| {});
    assert_eq!(forecast.gains.len(), 9);
    for gain in &forecast.gains {
        assert!((1e-4..0.01).contains(&gain.uncertainty), "{gain:?}");
    }
    assert!(forecast.advice.is_empty(), "{:?}", forecast.advice);
}

#[test]
fn without_heave_ay_errs_by_the_tangent_of_half_the_tilt_and_a_heave_sine_is_advised() {
    let forecast = forecast_of(without("heave"));
    // ay sees 1 − cos ϑ only: an error δ of the tilt ϑ changes that by δ/tan(ϑ/2).
    let by_hand = 0.1f64.to_radians() / 10f64.to_radians().tan();
    let ay = forecast.gains[1];
    assert!(
        (ay.tilt_change.abs() / by_hand - 1.0).abs() < 0.02,
        "{ay:?}"
    );
    // ax sees sin ϑ.
    let by_hand = 0.1f64.to_radians() / 20f64.to_radians().tan();
    let ax = forecast.gains[0];
    assert!(
        (ax.tilt_change.abs() / by_hand - 1.0).abs() < 0.02,
        "{ax:?}"
    );
    assert_eq!(
        forecast.advice,
        ["ay is ill-determined: 1.0 % per 0.1° of pitch and roll error; add a heave sine"]
    );
}

#[test]
fn a_missing_turn_and_a_missing_tilt_are_named_with_their_channels() {
    let advice = forecast_of(without("yaw-sine")).advice;
    assert_eq!(
        advice,
        ["ey and wy are not determined: nothing turns about Y; add a yaw sine"]
    );
    let advice = forecast_of(without("roll")).advice;
    assert!(advice[0].starts_with("az is not determined"), "{advice:?}");
}

#[test]
fn a_tiny_turn_is_ill_determined() {
    let forecast = forecast_of(|plan| {
        let run = plan.runs.iter_mut().find(|run| run.name == "roll-sine");
        run.unwrap().sine[0].amplitude_deg = Some(0.05);
    });
    let advised: Vec<&str> = forecast.advice.iter().map(|line| &line[..2]).collect();
    assert_eq!(advised, ["ex", "wx"], "{:?}", forecast.advice);
    assert!(forecast.advice[0].contains("make the roll sine larger"));
}

#[test]
fn the_command_prints_forecast_and_advice_and_draws_the_margins() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("sensors.toml", &twin::papers::sensor_file(7));
    let mut plan = campaign::plan(&geometry()).unwrap();
    without("heave")(&mut plan);
    write("edited.toml", &plan.to_toml());
    let mut command = Command::cargo_bin("hexsense").unwrap();
    let base = ["plan", "--geometry", GEOMETRY, "--out", "campaign"];
    let files = ["--plan", "edited.toml", "--sensors", "sensors.toml"];
    let output = command
        .current_dir(folder.path())
        .args(base)
        .args(files)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("advice: ay is ill-determined"), "{text}");
    assert!(text.contains("largest cond(J): run"), "{text}");
    let figure = std::fs::read_to_string(folder.path().join("campaign/margins.svg")).unwrap();
    assert!(figure.starts_with("<svg xmlns=") && figure.contains("pitch: acceleration"));
    let base = std::fs::read_to_string(folder.path().join("campaign/base.svg")).unwrap();
    assert!(base.starts_with("<svg xmlns=") && base.contains("Jack k runs from lower hinge k"));
}

/// The run that the README adds to a plan.
const MULTISINE: &str = include_str!("../../docs/multisine-run.toml");

/// The default plan with a run of three multisines, as a file.
fn with_multisine() -> String {
    let plan = campaign::plan(&geometry()).unwrap().to_toml();
    plan + MULTISINE
}

#[test]
fn a_multisine_survives_its_file_and_the_estimate_holds_whole_periods_of_all_lines() {
    let plan = Plan::parse("plan.toml", &with_multisine()).unwrap();
    assert_eq!(Plan::parse("again.toml", &plan.to_toml()).unwrap(), plan);
    let run = plan.run("together").unwrap();
    assert!((run.duration_s() - 40.0).abs() < 1e-9);
    let timing = run.multisine.as_ref().unwrap().timing();
    let program = run.program();
    let start_s = timing.estimate_start_s();
    for (freedom, line) in [(1, 0.3), (1, 1.5), (3, 0.4), (3, 1.6), (5, 0.5), (5, 1.7)] {
        let periods = timing.estimate_s() * line;
        assert!((periods - periods.round()).abs() < 1e-9, "{line} Hz");
        let (one, after) = (start_s + 3.0, start_s + 3.0 + 1.0 / timing.fundamental_hz);
        let there = program.displacement(one)[freedom] - program.displacement(after)[freedom];
        assert!(there.abs() < 1e-12, "{freedom}: {there}");
    }
}

#[test]
fn the_command_plans_a_multisine_and_writes_its_six_jack_programs() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("edited.toml"), with_multisine()).unwrap();
    let plan = |file: &str| {
        Command::cargo_bin("hexsense")
            .unwrap()
            .current_dir(folder.path())
            .args(["plan", "--geometry", GEOMETRY, "--plan", file])
            .args(["--out", "campaign"])
            .output()
            .unwrap()
    };
    let output = plan("edited.toml");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{:?}", output.stderr);
    assert!(text.contains("heave 3 lines, crest 1.19"), "{text}");
    assert!(text.contains("pitch 3 lines, crest 1."), "{text}");
    let program = folder.path().join("campaign/programs/together.csv");
    let program = std::fs::read_to_string(program).unwrap();
    assert_eq!(program.lines().count(), 1 + 40 * 500 + 1);
    let figure = std::fs::read_to_string(folder.path().join("campaign/margins.svg")).unwrap();
    assert!(figure.contains("together: speed"));

    // Twenty times faster it is a movement of the same size that no jack can follow.
    let fast = with_multisine().replace("fundamental_hz = 0.1", "fundamental_hz = 2.0");
    std::fs::write(folder.path().join("fast.toml"), fast).unwrap();
    let output = plan("fast.toml");
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success());
    assert!(
        text.contains("run together") && text.contains("speed of jack"),
        "{text}"
    );
}

#[test]
fn a_run_that_nothing_could_be_fitted_to_may_verify_but_not_calibrate() {
    let refused = |text: &str| Plan::parse("plan.toml", text).unwrap_err().to_string();
    let error = refused(&with_multisine().replace("\"verify\"", "\"calibrate\""));
    assert!(
        error.starts_with(
            "plan.toml: run held-out: purpose is \"calibrate\"; coefficients are fitted to"
        ),
        "{error}"
    );
    let together = MULTISINE.replace("\"verify\"", "\"calibrate\"");
    let error = refused(&(campaign::plan(&geometry()).unwrap().to_toml() + &together));
    assert!(
        error.contains("run together: purpose") && error.contains("make its purpose \"verify\""),
        "{error}"
    );

    let mut plan = campaign::plan(&geometry()).unwrap();
    let again = |name: &str| {
        let mut run = plan.run(name).unwrap().clone();
        run.name = "again".to_owned();
        let mut plan = plan.clone();
        plan.runs.push(run);
        Plan::parse("plan.toml", &plan.to_toml())
    };
    for once in ["zero", "pitch", "roll", "heave"] {
        let error = again(once).unwrap_err().to_string();
        assert!(
            error.contains(&format!("the same movement as run {once}")),
            "{error}"
        );
    }
    for turn in ["roll-sine", "yaw-sine", "pitch-sine", "held-out"] {
        again(turn).unwrap();
    }
    plan.runs[3].sine[0].freedom = hexsense_probe::plan::Freedom::Surge;
    assert!(refused(&plan.to_toml()).contains("run heave: purpose"));
}

#[test]
fn every_bad_multisine_is_refused_with_file_key_value_and_limit() {
    let cases = [
        (
            "fundamental_hz = 0.1",
            "fundamental_hz = 0.0",
            "multisine.fundamental_hz",
        ),
        (
            "fundamental_hz = 0.1",
            "fundamental_hz = nan",
            "multisine.fundamental_hz",
        ),
        ("fade_s = 5.0", "fade_s = 0.0", "multisine.fade_s"),
        (
            "estimate_periods = 2",
            "estimate_periods = 0",
            "multisine.estimate_periods",
        ),
        (
            "estimate_periods = 2",
            "estimate_periods = -1",
            "estimate_periods",
        ),
        (
            "estimate_periods = 2",
            "estimate_periods = 60000",
            "length in seconds",
        ),
        (
            "[4, 10, 16]",
            "[4, 9, 16]",
            "multisine.lines.harmonics is 9 twice",
        ),
        ("[4, 10, 16]", "[0, 10, 16]", "multisine.lines.harmonics"),
        ("[4, 10, 16]", "[4, 10, 501]", "multisine.lines.harmonics"),
        ("[4, 10, 16]", "[4, 10]", "multisine.lines.amplitudes"),
        ("[4, 10, 16]", "[]", "multisine.lines.harmonics"),
        (
            "freedom = \"roll\"",
            "freedom = \"pitch\"",
            "multisine.lines.freedom",
        ),
        (
            "freedom = \"roll\"",
            "freedom = \"sway\"",
            "multisine.lines.amplitudes_m",
        ),
        (
            "amplitudes_m = [0.04",
            "amplitudes_m = [-0.04",
            "multisine.lines.amplitudes",
        ),
        (
            "amplitudes_m = [0.04",
            "amplitudes_m = [40.0",
            "multisine.lines.amplitudes",
        ),
        ("fade_s = 5.0", "fade_s = 5.0\nphase = 3", "phase"),
    ];
    for (good, bad, key) in cases {
        let text = with_multisine();
        let at = text.find("together").unwrap();
        let text = text[..at].to_owned() + &text[at..].replacen(good, bad, 1);
        let error = Plan::parse("edited.toml", &text).unwrap_err().to_string();
        assert!(
            error.contains("edited.toml") && error.contains(key),
            "{bad}: {error}"
        );
    }
}

#[test]
fn limits_of_hinges_come_from_the_geometry_file_and_are_printed_drawn_and_enforced() {
    let folder = tempfile::tempdir().unwrap();
    let preset = include_str!("../../geometries/an-74tk-200.toml");
    let with = |keys: &str| preset.replace("length_min", &format!("{keys}\nlength_min"));
    let plan = |text: String| {
        std::fs::write(folder.path().join("base.toml"), text).unwrap();
        Command::cargo_bin("hexsense")
            .unwrap()
            .current_dir(folder.path())
            .args(["plan", "--geometry", "base.toml", "--out", "campaign"])
            .output()
            .unwrap()
    };
    let output = plan(with("upper_hinge_angle_max_deg = 30"));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("closest to a limit: run pitch, jack") && text.contains("upper hinge 22."),
        "{text}"
    );
    let figure = std::fs::read_to_string(folder.path().join("campaign/margins.svg")).unwrap();
    assert!(figure.contains("pitch: angle of the upper hinges"));
    for bad in ["0.5", "91", "nan", "-30"] {
        let output = plan(with(&format!("lower_hinge_angle_max_deg = {bad}")));
        let text = String::from_utf8(output.stderr).unwrap();
        let said = "base.toml: lower_hinge_angle_max_deg is ";
        assert!(text.contains(said) && text.contains("1 to 90"), "{text}");
    }
    let output = plan(with("hinge_angle_max = 30"));
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.contains("hinge_angle_max"), "{text}");
}
