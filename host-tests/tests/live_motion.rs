//! The board's amplitude of the pose and its calibration factors, from jacks that move a base along a known sine.

use std::f64::consts::TAU;

use hexsense_core::channel::{INERTIAL, Ratiometric};
use hexsense_core::harmonics::{Harmonics, Series};
use hexsense_core::kinematics::{Pose, inverse};
use hexsense_core::live_motion::Motion;
use hexsense_core::live_pose::Tracker;
use hexsense_core::records::{JackCoefficients, MotionBase};
use hexsense_probe::geometry_file::{GeometryFile, preset_names};
use nalgebra::{UnitQuaternion, Vector3};

const SUPPLY: f32 = 1.000_7;
const OMEGA: f64 = TAU * 0.5;
/// Points of the period at which the jacks are read.
const POINTS: usize = 360;

/// The board's result for a base that moves by `amplitude` along coordinate `driven` (X, Y, Z, roll, yaw, pitch), while
/// every sensor shows 2000 counts.
fn found(preset: &str, driven: usize, amplitude: f64) -> Motion {
    let geometry = GeometryFile::load(preset).unwrap().geometry;
    let jacks = JackCoefficients {
        zero_length_m: geometry.mid_length_m() as f32,
        zero_counts: [32_768.0, 32_700.3, 32_812.7, 32_768.0, 32_650.9, 32_790.1],
        metres_per_count: [2e-5, -2e-5, 2.1e-5, 1.9e-5, 2e-5, 2e-5],
    };
    let counts = (0..POINTS).map(|point| {
        let moved = amplitude * (TAU * point as f64 / POINTS as f64 - 0.7).cos();
        let mut vectors = [Vector3::zeros(); 2];
        vectors[driven / 3][driven % 3] = moved;
        let home = Vector3::y() * geometry.home_height_m();
        let pose = Pose {
            position: home + vectors[0],
            rotation: UnitQuaternion::from_scaled_axis(vectors[1]),
        };
        let lengths = inverse(&geometry, &pose);
        std::array::from_fn::<f64, 6, _>(|jack| {
            let excess = lengths[jack] - f64::from(jacks.zero_length_m);
            let counts = excess / f64::from(jacks.metres_per_count[jack]);
            (counts + f64::from(jacks.zero_counts[jack])) / f64::from(SUPPLY)
        })
    });
    let counts: Vec<_> = counts.collect();
    let fits: [Harmonics; 6] = Series::fit_all(TAU / POINTS as f64, counts.into_iter()).unwrap();
    let tracker = Tracker::new(&MotionBase::new(&geometry), &jacks, Ratiometric::NONE).unwrap();
    let supply = (SUPPLY, Ratiometric::NONE);
    Motion::new(&tracker, &fits, &[2_000.0; INERTIAL], supply, OMEGA).unwrap()
}

#[test]
fn the_amplitude_of_the_driven_coordinate_is_found_and_the_others_stand_still() {
    for preset in preset_names() {
        let geometry = GeometryFile::load(preset).unwrap().geometry;
        let stroke_m = geometry.length_max_m() - geometry.length_min_m();
        // Small against the drive of a calibration: an eighth of the stroke, and 6° in rotation.
        for (driven, amplitude) in (0..6).flat_map(|axis| {
            let most = if axis < 3 { stroke_m / 8.0 } else { 0.1 };
            [(axis, 0.1 * most), (axis, most)]
        }) {
            let motion = found(preset, driven, amplitude);
            for (axis, moved) in motion.amplitude.iter().enumerate() {
                let truth = if axis == driven { amplitude } else { 0.0 };
                let off = (f64::from(*moved) - truth).abs();
                // Products of more than five harmonics, single precision and a table of 20 bits.
                assert!(
                    off < 2e-5 * amplitude + 3e-7,
                    "{preset}, {driven}: {motion:?}"
                );
            }
        }
    }
}

#[test]
fn factors_are_the_truth_over_what_the_sensor_shows() {
    let counts = 2_000.0 * f64::from(SUPPLY);
    for axis in 0..3 {
        let (shift, turn) = (
            found("an-74tk-200", axis, 0.1),
            found("an-74tk-200", 3 + axis, 0.1),
        );
        let near = |factor: f32, truth: f64| (f64::from(factor) / truth - 1.0).abs() < 3e-5;
        assert!(near(shift.factors[axis], 0.1 * OMEGA * OMEGA / counts));
        assert!(near(turn.factors[3 + axis], 0.1 * OMEGA * OMEGA / counts));
        assert!(near(turn.factors[6 + axis], 0.1 * OMEGA / counts));
    }
}
