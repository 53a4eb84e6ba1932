//! Support of several tests: bases, programs made with the twin's own mechanism, and passing of time.
#![allow(dead_code)] // each test file uses its part

use twin::algebra::{Rotation, Vec3};
use twin::geometry::Geometry;
use twin::mechanism::{Mechanism, Pose};
use twin::motion::Motion;
use twin::{Bench, Program};

pub const X: Vec3 = Vec3([1.0, 0.0, 0.0]);
pub const Y: Vec3 = Vec3([0.0, 1.0, 0.0]);
pub const Z: Vec3 = Vec3([0.0, 0.0, 1.0]);

pub fn an74() -> Geometry {
    Geometry::load("an-74tk-200").unwrap()
}

/// A 1 kHz program through these poses.
pub fn program(geometry: &Geometry, duration_s: f64, pose: impl Fn(f64) -> Pose) -> Program {
    let rows = (0..=(duration_s * 1000.0) as usize).map(|row| {
        let lengths = geometry.nominal.lengths(&pose(row as f64 * 0.001));
        lengths.map(|length| length - geometry.mid_length_m())
    });
    Program::new(0.001, rows.collect()).unwrap()
}

/// From home to a turned and shifted pose in two seconds, smoothly, and held there.
pub fn to_pose(geometry: &Geometry, shift: Vec3, turn: Vec3, hold_s: f64) -> Program {
    program(geometry, 2.0 + hold_s, |time_s| {
        let s = (time_s / 2.0).min(1.0);
        displaced(
            geometry,
            shift,
            turn,
            s * s * s * (10.0 + s * (-15.0 + 6.0 * s)),
        )
    })
}

/// All six degrees of freedom at once, in proportion to the stroke, at home in the first and last moment; smaller where a
/// jack would be faster than nine tenths of its limit.
pub fn six_axes(geometry: &Geometry, periods: f64) -> Program {
    let frequency_hz = 0.5;
    let duration_s = periods / frequency_hz;
    let pose = |size: f64, time_s: f64| {
        let ramp = (time_s.min(duration_s - time_s) / 1.0).clamp(0.0, 1.0);
        let wave = (std::f64::consts::TAU * frequency_hz * time_s).sin();
        displaced(
            geometry,
            Vec3([0.06, 0.05, -0.07]) * size,
            Vec3([0.08, 0.1, -0.09]) * size,
            ramp * ramp * (3.0 - 2.0 * ramp) * wave,
        )
    };
    let size = geometry.stroke_m() / 1.3;
    let lengths = |row: i32| geometry.nominal.lengths(&pose(size, f64::from(row) * 0.01));
    let speeds = (1..(duration_s * 100.0) as i32).flat_map(|row| {
        let (before, now) = (lengths(row - 1), lengths(row));
        (0..6).map(move |jack| (now[jack] - before[jack]).abs() / 0.01)
    });
    let fastest = speeds.fold(0.0, f64::max);
    let limit = 0.9 * geometry.speed_max_m_s.unwrap_or(f64::INFINITY);
    let size = size * (limit / fastest).min(1.0);
    program(geometry, duration_s, |time_s| pose(size, time_s))
}

fn displaced(geometry: &Geometry, shift: Vec3, turn: Vec3, share: f64) -> Pose {
    let angle = turn.norm();
    let axis = if angle > 0.0 { turn * (1.0 / angle) } else { X };
    Pose {
        position_m: geometry.home.position_m + shift * share,
        attitude: Rotation::about(axis, angle * share),
    }
}

/// Lets time pass and returns the truth of every step.
pub fn pass(bench: &mut Bench, seconds: f64) -> Vec<Motion> {
    let (mut rows, mut motions) = (Vec::new(), Vec::new());
    for _ in 0..(seconds / 0.02).ceil() as usize {
        bench
            .next_chunk(&mut rows, |motion| motions.push(*motion))
            .unwrap();
    }
    motions
}

/// A platform of `data/geometries.csv`, as it stands there (z up).
pub fn published(preset: &str) -> Mechanism {
    let text = include_str!("../data/geometries.csv");
    let mut lower = Vec::new();
    let mut upper = Vec::new();
    for line in text
        .lines()
        .filter(|line| line.starts_with(&format!("{preset},")))
    {
        let v: Vec<f64> = line
            .split(',')
            .skip(4)
            .map(|x| x.parse().unwrap())
            .collect();
        lower.push(Vec3([v[0], v[1], v[2]]));
        upper.push(Vec3([v[3], v[4], v[5]]));
    }
    Mechanism {
        lower: lower.try_into().unwrap(),
        upper: upper.try_into().unwrap(),
    }
}

pub fn close(got: f64, want: f64, tolerance: f64, what: &str) {
    assert!(
        (got - want).abs() <= tolerance,
        "{what}: got {got}, want {want} ± {tolerance}"
    );
}

/// Checks three components against their wanted values.
pub fn close3(got: Vec3, want: [f64; 3], tolerance: f64, what: &str) {
    for (axis, (got, want)) in got.0.into_iter().zip(want).enumerate() {
        close(got, want, tolerance, &format!("{what}[{axis}]"));
    }
}
