//! The motion bases of the tests, and random poses of them.

use geometries::PRESETS;
use hexsense_core::kinematics::convention::from_z_up;
use hexsense_core::kinematics::{Geometry, Pose, inverse, jacobian};
use hexsense_probe::geometry_file::GeometryFile;
use nalgebra::{UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardUniform, UnitBall};

/// Rows of a table in `tests/data`, the cells of each as text, without the header.
pub fn rows(file: &str) -> Vec<Vec<String>> {
    let path = format!("{}/tests/data/{file}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    text.lines().skip(1).map(cells).collect()
}

pub fn numbers(cells: &[String]) -> Vec<f64> {
    cells.iter().map(|cell| cell.parse().unwrap()).collect()
}

pub fn preset(name: &str) -> Geometry<f64> {
    GeometryFile::load(name).unwrap().geometry
}

pub fn presets() -> Vec<(&'static str, Geometry<f64>)> {
    PRESETS
        .iter()
        .map(|(name, _)| (*name, preset(name)))
        .collect()
}

/// Lower and upper hinges of a platform of `geometries.csv` with Y up, in metres where the table is in millimetres
/// and in the table's unit otherwise.
pub fn hinges(name: &str) -> [[Vector3<f64>; 6]; 2] {
    let mut hinges = [[Vector3::zeros(); 6]; 2];
    for row in rows("geometries.csv").iter().filter(|row| row[0] == name) {
        let scale = if row[1] == "mm" { 1e-3 } else { 1.0 };
        let jack: usize = row[3].parse().unwrap();
        let c: Vec<f64> = numbers(&row[4..]).iter().map(|c| c * scale).collect();
        hinges[0][jack - 1] = from_z_up(Vector3::new(c[0], c[1], c[2]));
        hinges[1][jack - 1] = from_z_up(Vector3::new(c[3], c[4], c[5]));
    }
    hinges
}

/// A platform of `geometries.csv` with a stroke wide enough for the tests.
pub fn published(name: &str, lengths: [f64; 2], home_height: Option<f64>) -> Geometry<f64> {
    let [lower, upper] = hinges(name);
    Geometry::new(lower, upper, lengths[0], lengths[1], home_height).unwrap()
}

pub fn dietmaier() -> Geometry<f64> {
    published("dietmaier40", [0.0, 5.0], Some(1.0))
}

/// The published platforms that have no stroke, at plausible heights.
pub fn without_stroke() -> Vec<(&'static str, Geometry<f64>)> {
    vec![
        (
            "nasa_msfc_cdsl",
            published("nasa_msfc_cdsl", [50.0, 300.0], Some(-111.31)),
        ),
        (
            "mathworks_demo",
            published("mathworks_demo", [1.0, 6.0], Some(2.0)),
        ),
        (
            "linuxcnc_genhexkins",
            published("linuxcnc_genhexkins", [5.0, 80.0], Some(20.0)),
        ),
        (
            "nategh_agheli_nominal",
            published("nategh_agheli_nominal", [0.3, 0.9097304], None),
        ),
    ]
}

/// Uniform in −1..1.
pub fn signed(random: &mut ChaCha8Rng) -> f64 {
    let unit: f64 = StandardUniform.sample(random);
    2.0 * unit - 1.0
}

/// Uniform in the unit ball.
pub fn ball(random: &mut ChaCha8Rng) -> Vector3<f64> {
    let point: [f64; 3] = UnitBall.sample(random);
    point.into()
}

/// `pose` moved by up to `distance` and turned by up to `angle`.
pub fn disturbed(
    pose: &Pose<f64>,
    distance: f64,
    angle: f64,
    random: &mut ChaCha8Rng,
) -> Pose<f64> {
    Pose {
        position: pose.position + ball(random) * distance,
        rotation: pose.rotation * UnitQuaternion::from_scaled_axis(ball(random) * angle),
    }
}

/// A pose that a straight path joins to home, inside the stroke and without a change of the sign of det J. The path
/// goes up to `distance` and `angle` from home in a random direction; every other pose lies within the last
/// twentieth before the path leaves the stroke or meets a singular pose.
pub fn joined_to_home(
    geometry: &Geometry<f64>,
    distance: f64,
    angle: f64,
    random: &mut ChaCha8Rng,
) -> Pose<f64> {
    const STEPS: u32 = 100;
    let home = geometry.home();
    let end = disturbed(&home, distance, angle, random);
    let sign = jacobian(geometry, &home).determinant().signum();
    let stroke = geometry.length_min_m()..=geometry.length_max_m();
    let sound = |step: u32| {
        let pose = home.along(&end, f64::from(step) / f64::from(STEPS));
        inverse(geometry, &pose)
            .iter()
            .all(|length| stroke.contains(length))
            && jacobian(geometry, &pose).determinant() * sign > 0.0
    };
    let steps = (1..=STEPS)
        .take_while(|&step| sound(step))
        .last()
        .unwrap_or(0);
    let draw = signed(random);
    let share = if draw < 0.0 {
        -draw
    } else {
        0.95 + 0.05 * draw
    };
    home.along(&end, f64::from(steps) / f64::from(STEPS) * share)
}

/// Greatest difference between the lengths at `pose` and `lengths`.
pub fn misfit(geometry: &Geometry<f64>, pose: &Pose<f64>, lengths: &[f64; 6]) -> f64 {
    let there = inverse(geometry, pose);
    there
        .iter()
        .zip(lengths)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}
