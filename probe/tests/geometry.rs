//! Geometry files as people have them: other units, other axes, a platform that hangs. Sources of `tests/data` are in its
//! README.

use std::fs;

use hexsense_core::kinematics::{Angles, Convention, Options, Solver, inverse};
use hexsense_probe::geometry_file::GeometryFile;
use nalgebra::Vector3;

const LEVEL_LENGTHS_M: [f64; 6] = [
    0.828602951,
    0.881106248,
    0.881071876,
    0.881071876,
    0.881106248,
    0.828602951,
];

fn data(file: &str) -> String {
    let path = format!("{}/tests/data/{file}", env!("CARGO_MANIFEST_DIR"));
    fs::read_to_string(path).unwrap()
}

fn hanging(home: &str) -> Result<GeometryFile, String> {
    let text = format!("{home}\n{}", data("hanging_base.toml"));
    GeometryFile::parse("hanging_base.toml", &text).map_err(|error| error.to_string())
}

#[test]
fn a_base_that_may_hang_is_refused_until_the_file_says_on_which_side_its_platform_is() {
    let said = hanging("").unwrap_err();
    // √(0.9² − mean of the squared horizontal distances), by hand from the file.
    for part in [
        "hanging_base.toml: home_height is missing",
        "home_height = 0.758168 (platform above)",
        "home_height = -0.758168 (platform below)",
    ] {
        assert!(said.contains(part), "{said}");
    }
}

/// Level at z = −0.715 m, as the base is built, and its mirror image at +0.715 m: the lengths are √(dx² + dy² + 0.715²)
/// from the file, by hand.
#[test]
fn a_hanging_platform_is_solved_on_its_side() {
    for side in [-1.0_f64, 1.0] {
        let home = format!("home_height = {}", side * 0.758168);
        let solver = Solver::new(&hanging(&home).unwrap().geometry, Options::default());
        let found = solver.solve(&LEVEL_LENGTHS_M).unwrap();
        let (position, angles) = Convention::Zyx.coordinates(&found.pose);
        let expected = Vector3::new(0.0, 0.0, side * 0.715);
        assert!((position - expected).amax() < 1e-8, "{position}");
        assert!(angles.pitch.abs() < 1e-8, "{angles:?}");
    }
}

/// The lower hinges too far out for any level home at mid-stroke lengths.
#[test]
fn a_home_that_cannot_be_found_asks_for_the_key() {
    let text = data("hanging_base.toml").replace("length_max = 1.0", "length_max = 0.81");
    let said = GeometryFile::parse("base.toml", &text)
        .unwrap_err()
        .to_string();
    assert!(
        said.contains("jack 1 would be 0.7669 m long") && said.contains("give home_height"),
        "{said}"
    );
}

/// The file with its hinges in other axes and units, and the lower ones 50 mm higher.
fn with_hinges(
    axes: &str,
    units: &str,
    turned: impl Fn([f64; 3]) -> [f64; 3],
    scale: f64,
) -> String {
    let file: toml::Table = data("hanging_base.toml").parse().unwrap();
    let hinges = |key: &str| {
        let hinges = file[key].as_array().unwrap().iter();
        let hinges = hinges.map(|hinge| {
            let mut c = [0, 1, 2].map(|axis| scale * hinge[axis].as_float().unwrap());
            // Off the plane, where a wrong sign shows.
            c[2] += if key == "lower" { 0.05 * scale } else { 0.0 };
            format!("{:?}", turned(c))
        });
        hinges.collect::<Vec<_>>().join(", ")
    };
    format!(
        "name = \"x\"\naxes = {axes:?}\n{units}\nlower = [{}]\nupper = [{}]\nlength_min = {}\nlength_max = {}\n\
         home_height = {}\n",
        hinges("lower"),
        hinges("upper"),
        0.8 * scale,
        1.0 * scale,
        -0.715 * scale,
    )
}

#[test]
fn millimetres_and_axes_with_z_down_make_the_same_base() {
    let metres = with_hinges("z-up", "", |c| c, 1.0);
    let base = GeometryFile::parse("m.toml", &metres).unwrap();
    for (axes, side) in [("z-up", 1.0), ("z-down", -1.0)] {
        let text = with_hinges(
            axes,
            "units = \"mm\"\nspeed_max = 600\nacceleration_max = 8000\nhinge_tolerance = 0.2",
            |[x, y, z]| [x, y * side, z * side],
            1000.0,
        );
        let file = GeometryFile::parse("mm.toml", &text).unwrap();
        for pose in [[0.0, -0.715, 0.0], [0.02, -0.7, 0.03]] {
            let angles = Angles {
                roll: 0.05,
                pitch: -0.04,
                yaw: 0.03,
            };
            let pose = Convention::Gost.pose(Vector3::from(pose), angles);
            let lengths = inverse(&file.geometry, &pose);
            for (a, b) in lengths.iter().zip(inverse(&base.geometry, &pose)) {
                assert!((a - b).abs() < 1e-12, "{axes}: {a} is not {b}");
            }
        }
        assert_eq!(file.geometry.length_max_m(), 1.0);
        assert_eq!(file.hinge_tolerance_m, 0.0002);
        assert_eq!(
            [file.speed_max_m_s, file.acceleration_max_m_s2],
            [Some(0.6), Some(8.0)]
        );
    }
}

#[test]
fn numbers_in_other_units_are_refused_with_the_key_and_the_mend() {
    let good = with_hinges("z-up", "", |c| c, 1.0);
    let mm = with_hinges("z-up", "units = \"mm\"", |c| c, 1000.0);
    for (text, parts) in [
        (
            with_hinges("z-up", "", |c| c, 1000.0),
            [
                "lower[1].x is 379.8",
                "-100 to 100 (m)",
                "add units = \"mm\"",
            ],
        ),
        (
            good.replace("length_max = 1", "length_max = 1000"),
            ["length_max is 1000", "to 100 (m)", "add units = \"mm\""],
        ),
        (
            format!("speed_max = 600\n{good}"),
            ["speed_max is 600", "to 20 (m/s)", "add units = \"mm\""],
        ),
        (
            format!("speed_max = 0.6\n{mm}"),
            ["speed_max is 0.6", "1 to 20000 (mm/s)", "leave out units"],
        ),
        (
            mm.replace("length_max = 1000", "length_max = 1"),
            ["length_max is 1", "10 to 100000 (mm)", "leave out units"],
        ),
    ] {
        let said = GeometryFile::parse("base.toml", &text)
            .map(|_| ())
            .unwrap_err()
            .to_string();
        for part in parts {
            assert!(said.contains(part), "{part:?} is not in: {said}");
        }
    }
}
