//! Bad files and bad options: each gives an error that says what is wrong, and the twin writes nothing.

use std::path::Path;
use std::process::{Command, Output};

use twin::Program;
use twin::geometry::Geometry;

fn good() -> String {
    let (_, text) = geometries::PRESETS
        .iter()
        .find(|(name, _)| *name == "tu-204")
        .unwrap();
    (*text).to_owned()
}

/// The good file with the line that begins with `key` replaced.
fn with(key: &str, line: &str) -> String {
    let mut found = false;
    let lines: Vec<String> = good()
        .lines()
        .map(|old| {
            let hit = old.starts_with(key);
            found |= hit;
            if hit { line.to_owned() } else { old.to_owned() }
        })
        .collect();
    assert!(found, "no line begins with {key}");
    lines.join("\n")
}

#[test]
fn a_bad_geometry_is_refused_with_key_value_and_limit() {
    Geometry::parse(&good()).unwrap();
    let first_hinge = "  [1.65, 0.0, 0.0],\n";
    for (text, says) in [
        (
            good().replacen(first_hinge, "", 1),
            "upper: 5 hinges, must be 6",
        ),
        (
            good().replacen(first_hinge, "  [1.65, 0.0],\n", 1),
            "upper[1]: 2 coordinates, must be 3",
        ),
        (
            good().replacen(first_hinge, "  [nan, 0.0, 0.0],\n", 1),
            "upper[1].x: NaN is outside",
        ),
        (
            good().replacen(first_hinge, "  [1650.0, 0.0, 0.0],\n", 1),
            "upper[1].x: 1650 is outside",
        ),
        (
            with("length_min", "length_min = 3.9"),
            "length_min: 3.9 m is not below length_max, 3.7 m",
        ),
        (
            with("length_max", "length_max = inf"),
            "length_max: inf is outside",
        ),
        (
            with("home_height", "home_height = 4.5"),
            "home_height: at 4.5 m jack 1 is",
        ),
        (
            with("home_height", "home_height = nan"),
            "home_height: NaN is outside",
        ),
        (
            with("hinge_tolerance", "hinge_tolerance = -1.0"),
            "hinge_tolerance: -1 is outside",
        ),
        (
            with("speed_max", "speed_max = 0.0"),
            "speed_max: 0 is outside",
        ),
        (with("axes", "axes = \"x-up\""), "unknown variant `x-up`"),
        (with("axes", ""), "missing field `axes`"),
        (
            with("axes", "axes = \"y-up\"\nunits = \"in\""),
            "unknown variant `in`, expected `m` or `mm`",
        ),
        (with("note", "remark = \"\""), "unknown field `remark`"),
        (with("name", "name = "), "TOML parse error"),
        (String::new(), "missing field"),
    ] {
        let error = Geometry::parse(&text).unwrap_err().to_string();
        assert!(error.contains(says), "want {says:?} in {error:?}");
    }
}

#[test]
fn a_file_that_does_not_say_on_which_side_the_platform_is_is_refused() {
    let error = Geometry::parse(&with("home_height", ""))
        .unwrap_err()
        .to_string();
    // Hinges in planes: the mirror image has the same lengths.
    assert!(error.contains("home_height is missing"), "{error}");
    assert!(error.contains("2.322399 m (platform above"), "{error}");
    assert!(error.contains("-2.322399 m (platform below"), "{error}");
    let lopsided = with("home_height", "").replacen("[1.65, 0.0, 0.0]", "[1.65, 0.1, 0.0]", 1);
    let error = Geometry::parse(&lopsided).unwrap_err().to_string();
    assert!(error.contains("give home_height"), "{error}");
}

#[test]
fn a_platform_may_hang_below_its_lower_hinges() {
    let hanging = Geometry::parse(&with("home_height", "home_height = -2.322399")).unwrap();
    assert!((hanging.home.position_m.0[1] + 2.322399).abs() < 1e-12);
}

/// The good file, its hinges off the plane where a wrong sign shows, in millimetres with z up and with z down.
#[test]
fn millimetres_and_axes_with_z_down_are_the_same_base() {
    let raised = good().replace(", 0.0, ", ", 0.1, ");
    let wanted = Geometry::parse(&raised).unwrap();
    let file: toml::Table = raised.parse().unwrap();
    // y and z are swapped; then z up points y to the left, z down points z downwards.
    for (axes, [y_sign, z_sign]) in [("z-up", [-1.0, 1.0]), ("z-down", [1.0, -1.0])] {
        let hinges = |key: &str| {
            let turned = file[key].as_array().unwrap().iter().map(|hinge| {
                let mm = |axis: usize| 1000.0 * hinge[axis].as_float().unwrap();
                format!("[{:?}, {:?}, {:?}]", mm(0), y_sign * mm(2), z_sign * mm(1))
            });
            turned.collect::<Vec<_>>().join(", ")
        };
        let text = format!(
            "name = \"x\"\naxes = {axes:?}\nunits = \"mm\"\nlower = [{}]\nupper = [{}]\nlength_min = 2300\n\
             length_max = 3700\nhome_height = 2322.399\nspeed_max = 1000\nhinge_tolerance = 0.5\n",
            hinges("lower"),
            hinges("upper")
        );
        let found = Geometry::parse(&text).unwrap();
        let all = |base: &Geometry| [base.nominal.lower, base.nominal.upper].concat();
        for (a, b) in all(&found).into_iter().zip(all(&wanted)) {
            let off = (0..3).map(|axis| (a.0[axis] - b.0[axis]).abs());
            assert!(
                off.fold(0.0, f64::max) < 1e-12,
                "{axes}: {a:?} is not {b:?}"
            );
        }
        assert_eq!(found.length_m, wanted.length_m);
        assert_eq!(
            [found.hinge_tolerance_m, found.speed_max_m_s.unwrap()],
            [0.0005, 1.0]
        );
        assert!((found.home.position_m.0[1] - 2.322399).abs() < 1e-12);
    }
}

#[test]
fn a_platform_that_its_jacks_do_not_hold_is_refused() {
    // All six jacks vertical and parallel: the platform can swing.
    let row = "[[1,0,0],[2,0,0],[3,0,1],[0,0,2],[1,0,3],[2,0,1]]";
    let text = format!(
        "name = \"x\"\naxes = \"y-up\"\nlower = {row}\nupper = {row}\nlength_min = 1\nlength_max = 3\n"
    );
    let error = Geometry::parse(&text).unwrap_err().to_string();
    assert!(error.contains("singular"), "{error}");
}

#[test]
fn a_bad_program_is_refused_with_its_line() {
    let header = twin::program::HEADER;
    let row = |t: &str| format!("{t},0,0,0,0,0,0\n");
    for (text, says) in [
        (String::new(), "line 1: column 1 of the header is \"\""),
        ("time_s,jack1_mm\n".to_owned(), "must be \"jack1_m\""),
        (format!("{header}\n"), "0 rows, must be at least 2"),
        (
            format!("{header}\n{}", row("0")),
            "1 rows, must be at least 2",
        ),
        (
            format!("{header}\n{}0.001,0,0\n", row("0")),
            "line 3: 3 cells; there must be 7",
        ),
        (
            format!("{header}\n{}0.001,0,0,NaN,0,0,0\n", row("0")),
            "line 3: \"NaN\" is not a finite number",
        ),
        (
            format!("{header}\n{}0.001,0,0,0,0,0,x\n", row("0")),
            "line 3: \"x\" is not a finite number",
        ),
        (
            format!("{header}\n{}{}{}", row("0"), row("0.001"), row("0.003")),
            "line 3: time 0.001 s",
        ),
        (
            format!("{header}\n{}{}", row("1"), row("0")),
            "line 2: time 1 s",
        ),
        (
            format!("{header}\n{}{}", row("0"), row("0")),
            "constant period of 0.000000 s",
        ),
    ] {
        let error = Program::parse(&text).unwrap_err().to_string();
        assert!(error.contains(says), "want {says:?} in {error:?}");
    }
}

fn twin(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_twin"))
        .args(arguments)
        .output()
        .unwrap()
}

#[test]
fn bad_options_fail_with_a_reason_and_write_nothing() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("never.toml");
    let _ = std::fs::remove_file(&out);
    let out = out.to_str().unwrap();
    for (arguments, says) in [
        (
            vec!["truth", "--seed", "1", "--geometry", "b-737"],
            "presets: il-96-300, tu-204",
        ),
        (
            vec!["truth", "--seed", "-1", "--geometry", "tu-204"],
            "--seed",
        ),
        (
            vec!["papers", "--seed", "1", "--geometry", "b-737", "--out", out],
            "b-737",
        ),
        (
            vec![
                "papers",
                "--seed",
                "1",
                "--geometry",
                "tu-204",
                "--out",
                "/no/dir/x",
            ],
            "/no/dir/x",
        ),
        (
            vec![
                "serve",
                "--seed",
                "1",
                "--geometry",
                "tu-204",
                "--pins",
                "nowhere",
                "--control",
                "x",
            ],
            "--pins nowhere",
        ),
    ] {
        let output = twin(&arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success(), "{arguments:?}");
        assert!(error.contains(says), "want {says:?} in {error:?}");
        assert!(output.stdout.is_empty());
    }
    assert!(!Path::new(out).exists());
}

#[test]
fn a_bad_geometry_file_is_named() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bad.toml");
    std::fs::write(&path, with("length_min", "length_min = 3.9")).unwrap();
    let output = twin(&["truth", "--seed", "1", "--geometry", path.to_str().unwrap()]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("bad.toml: length_min"), "{error}");
}

#[test]
fn the_sensor_file_has_nominal_values_and_a_measured_lever_arm() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("papers.toml");
    let file = path.to_str().unwrap();
    assert!(
        twin(&[
            "papers",
            "--seed",
            "9",
            "--geometry",
            "tu-204",
            "--out",
            file
        ])
        .status
        .success()
    );
    let papers: toml::Table = std::fs::read_to_string(&path).unwrap().parse().unwrap();
    let number = |section: &str, key: &str| papers[section][key].as_float().unwrap();
    for (section, key, value) in [
        ("linear_acceleration", "full_scale", 19.6133),
        ("linear_acceleration", "bias_tolerance", 0.294),
        ("linear_acceleration", "noise_density", 9.8e-4),
        ("angular_acceleration", "full_scale", 10.0),
        ("angular_acceleration", "gain_tolerance", 0.05),
        ("angular_acceleration", "volts_per_unit", 0.15),
        ("angular_rate", "full_scale", 1.74533),
        ("angular_rate", "bias_walk_5min", 3.4907e-4),
        ("jacks", "full_stroke_volts", 3.1),
        ("jacks", "noise_rms_m", 1e-4),
        ("adc", "clock_tolerance_ppm", 50.0),
    ] {
        let got = number(section, key);
        assert!((got / value - 1.0).abs() < 1e-3, "{section}.{key} = {got}");
    }
    let truth = twin::truth::lever_arm_m(9).0;
    for (axis, value) in papers["lever_arm_m"].as_array().unwrap().iter().enumerate() {
        let off = (value.as_float().unwrap() - truth[axis]).abs();
        assert!(off <= 0.05 && off > 0.0, "axis {axis} is off by {off} m");
    }
}
