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
}
