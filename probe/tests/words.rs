//! Messages name the likeliest cause, with the key, the value and the limit, and nothing that was not asked.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpListener;
use std::thread;

use assert_cmd::Command;
use hexsense_probe::geometry_file::GeometryFile;
use hexsense_probe::plan::campaign;
use tempfile::TempDir;

const GEOMETRY: &str = "an-74tk-200";

/// What `hexsense` says on both outputs, and whether it succeeds.
fn said(folder: &TempDir, arguments: &str) -> (bool, String) {
    let output = Command::cargo_bin("hexsense")
        .unwrap()
        .current_dir(folder.path())
        .args(arguments.split_whitespace())
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8(text).unwrap())
}

fn refused(folder: &TempDir, arguments: &str, words: &[&str], never: &str) {
    let (success, said) = said(folder, arguments);
    assert!(!success, "{arguments}: {said}");
    for words in words {
        assert!(said.contains(words), "{arguments}: no {words:?} in {said}");
    }
    assert!(!said.contains(never), "{arguments}: {never:?} in {said}");
}

/// A folder with the twin's sensor file, changed, and the default plan, changed.
fn folder(sensors: impl Fn(&str) -> String, plan: impl Fn(&str) -> String) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let text = sensors(&twin::papers::sensor_file(1));
    fs::write(folder.path().join("sensors.toml"), text).unwrap();
    let geometry = GeometryFile::load(GEOMETRY).unwrap();
    let text = plan(&campaign::plan(&geometry).unwrap().to_toml());
    fs::write(folder.path().join("plan.toml"), text).unwrap();
    folder
}

const PLAN: &str = "plan --geometry an-74tk-200 --plan plan.toml --sensors sensors.toml";

#[test]
fn a_sensitivity_ten_times_too_large_is_named_by_its_key_and_its_volts_and_no_wiring_is_blamed() {
    // The first table is that of the accelerometers: gravity alone is 7.5 V above the zero of 1.65 V.
    let ten_times = |text: &str| {
        let line = text
            .lines()
            .find(|line| line.starts_with("volts_per_unit"))
            .unwrap();
        text.replacen(line, "volts_per_unit = 0.7647871597334462", 1)
            .replacen("full_scale = 19.6133", "full_scale = 1.96133", 1)
    };
    let folder = folder(ten_times, str::to_owned);
    let words = [
        "ay has 9.15 V at 0.00 s",
        "0 to 3.3 V of the converter",
        "linear_acceleration.volts_per_unit",
    ];
    refused(&folder, PLAN, &words, "wiring");
}

#[test]
fn a_sine_that_is_estimated_over_less_than_a_period_is_refused_before_anything_is_asked_of_hardware()
 {
    let slow = |text: &str| text.replace("frequency_hz = 0.5", "frequency_hz = 0.03");
    let folder = folder(str::to_owned, slow);
    let words = [
        "run heave: sine.estimate_s is 6",
        "at 0.03 Hz it must be at least one period, 33.3333 s",
    ];
    refused(&folder, PLAN, &words, "connected");
}

#[test]
fn a_plan_prints_the_gravity_that_it_uses_and_where_it_comes_from() {
    let with = |keys: &'static str| {
        folder(
            move |text| text.replacen("gravity_m_s2 = 9.80665", keys, 1),
            str::to_owned,
        )
    };
    let value = "gravity_m_s2 = 9.80665";
    let (success, text) = said(&with(value), PLAN);
    assert!(success, "{text}");
    assert!(
        text.contains("gravity: 9.80665 ± 0.0005 m/s² (1σ), gravity_m_s2 of the sensor file"),
        "{text}"
    );
    assert!(!text.contains("warning"), "{text}");
    let (success, text) = said(&with("latitude_deg = 0.973\nheight_m = 150.0"), PLAN);
    assert!(
        success && text.contains("at latitude 0.973° and height 150 m"),
        "{text}"
    );
    assert!(
        text.contains("warning: latitude_deg is 0.973: is it in radians?"),
        "{text}"
    );
    // `calibrate` says so before it asks for the board.
    let nobody =
        "calibrate --port tcp:127.0.0.1:1 --geometry an-74tk-200 --sensors sensors.toml --out c";
    let (_, text) = said(&with(value), nobody);
    assert!(text.contains("gravity: 9.80665 ± 0.0005 m/s²"), "{text}");
    // At 55.75° normal gravity is 9.815.
    let both = with("gravity_m_s2 = 9.80665\nlatitude_deg = 55.75\nheight_m = 150.0");
    let words = [
        "gravity_m_s2 is 9.80665",
        "latitude_deg and height_m give 9.815",
        "leave one out",
    ];
    refused(&both, PLAN, &words, "given alone");
}

#[test]
fn a_port_that_is_there_but_is_none_or_is_an_address_is_named_as_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("device"), "").unwrap();
    let words = ["device is there but cannot be opened", "other programs"];
    refused(
        &folder,
        "info --port device",
        &words,
        "there is no serial port",
    );
    let words = ["an address is written tcp:localhost:4000"];
    refused(&folder, "info --port localhost:4000", &words, "plugged in");
    let words = ["there is no serial port /dev/tty_none"];
    refused(
        &folder,
        "info --port /dev/tty_none",
        &words,
        "cannot be opened",
    );
}

#[test]
fn the_control_port_of_the_twin_as_the_boards_port_is_named_and_no_cable_is_blamed() {
    let folder = tempfile::tempdir().unwrap();
    for scheme in ["lockstep", "tcp"] {
        let control = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = format!("{scheme}:{}", control.local_addr().unwrap());
        // As the twin does: a line of JSON for whatever ends like a line.
        let answers = thread::spawn(move || {
            let (mut host, _) = control.accept().unwrap();
            let mut bytes = [0; 64];
            while host.read(&mut bytes).unwrap_or(0) > 0 {
                let _ = host.write_all(b"{\"ok\":false,\"error\":\"not a request\"}\n");
            }
        });
        refused(
            &folder,
            &format!("info --port {port}"),
            &["twin", "--twin"],
            "cable",
        );
        answers.join().unwrap();
    }
}
