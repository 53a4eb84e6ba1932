//! The base's motion at the drive frequency, and the calibration factors straight from the board's sums.
//!
//! One number for a driven sensor needs only two amplitudes: that of the pose, which the harmonics of the six jacks give,
//! and that of the sensor:
//!
//! ```text
//! jack sums ──▶ harmonics ──▶ lengths at points of one period ──▶ poses ──▶ A_p of each coordinate
//! sensor sums ──▶ harmonics ──▶ A in counts             k = A_p·(2πf)² / A   or, for a rate,  A_p·2πf / A
//! ```
//!
//! The coordinates are position of O and rotation vector: X and roll, Y and yaw, Z and pitch. A factor is meaningful for
//! the driven axis, about a level pose. The factors of the linear accelerations count the movement of O alone; gravity,
//! which a tilt brings in, and the lever arm are left to the calibration.

use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::channel::{INERTIAL, JACKS, Ratiometric};
use crate::harmonics::table::{ONE, Waves};
use crate::harmonics::{Harmonic, Harmonics};
use crate::kinematics::{ForwardError, Pose};
use crate::live_pose::Tracker;

/// Points of a period at which poses are found: many more than five harmonics and their products need.
const POINTS: u32 = 64;
/// Coordinates of a pose.
const COORDINATES: usize = 6;

/// First harmonics of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Amplitude along X, Y, Z (m), then of roll, yaw, pitch (rad).
    pub amplitude: [f32; COORDINATES],
    /// Calibration factor of each inertial channel, unit per count at nominal supply; 0 for a channel without a signal.
    pub factors: [f32; INERTIAL],
}

impl Motion {
    /// From the harmonics of all jacks and the amplitudes of the inertial channels (counts), all at supply factor
    /// `supply`, which does not act on the ratiometric channels; driven at `omega` rad/s.
    ///
    /// # Errors
    /// [`ForwardError`] when the jacks give no pose.
    pub fn new(
        tracker: &Tracker<f32>,
        jacks: &[Harmonics; JACKS],
        sensors: &[f64; INERTIAL],
        (supply, ratiometric): (f32, Ratiometric),
        omega: f64,
    ) -> Result<Self, ForwardError<f32>> {
        let amplitude = amplitudes(tracker, jacks, supply)?;
        let factor = |channel: usize| {
            let (kind, axis) = (channel / 3, channel % 3);
            let moved = match kind {
                0 => amplitude[axis] * omega * omega,
                1 => amplitude[3 + axis] * omega * omega,
                _ => amplitude[3 + axis] * omega,
            };
            let counts = sensors[channel] * f64::from(ratiometric.factor(channel, supply));
            let factor = (moved / counts) as f32;
            // A channel that stands still has no factor.
            if factor.is_finite() { factor } else { 0.0 }
        };
        Ok(Self {
            amplitude: amplitude.map(|amplitude| amplitude as f32),
            factors: core::array::from_fn(factor),
        })
    }
}

#[inline(never)]
fn amplitudes(
    tracker: &Tracker<f32>,
    jacks: &[Harmonics; JACKS],
    supply: f32,
) -> Result<[f64; COORDINATES], ForwardError<f32>> {
    let (solver, transducers) = (tracker.solver(), tracker.transducers());
    let mut harmonics = [Harmonic::default(); COORDINATES];
    for point in 0..POINTS {
        let waves = Waves::at(point * (u32::MAX / POINTS + 1));
        let counts = jacks.each_ref().map(|jack| value(jack, &waves));
        let lengths = transducers.lengths_of_doubles_m(&counts, supply);
        let pose = solver.solve(&lengths)?.pose;
        let cosine = f64::from(waves.cosine[0]) / f64::from(ONE);
        let sine = f64::from(waves.sine[0]) / f64::from(ONE);
        for (harmonic, value) in harmonics.iter_mut().zip(coordinates(&pose)) {
            harmonic.cosine += value * cosine * 2.0 / f64::from(POINTS);
            harmonic.sine += value * sine * 2.0 / f64::from(POINTS);
        }
    }
    Ok(harmonics.map(|harmonic| harmonic.amplitude()))
}

/// A signal at the phase of `waves`, without its drift.
#[inline(never)]
fn value(signal: &Harmonics, waves: &Waves) -> f64 {
    let parts = signal
        .harmonics
        .iter()
        .zip(waves.cosine.iter().zip(waves.sine));
    let parts = parts.map(|(harmonic, (cosine, sine))| {
        harmonic.cosine * f64::from(*cosine) + harmonic.sine * f64::from(sine)
    });
    signal.offset + parts.sum::<f64>() / f64::from(ONE)
}

/// Position and rotation vector of a pose.
#[inline(never)]
fn coordinates(pose: &Pose<f32>) -> [f64; COORDINATES] {
    let (place, turn) = (pose.position, rotation_vector(&pose.rotation));
    [place.x, place.y, place.z, turn.x, turn.y, turn.z].map(f64::from)
}

/// 2·asin(|v|)/|v|·v of a unit quaternion's vector part v, by the series of the arc sine: to 1e-5 at 40°.
fn rotation_vector(rotation: &UnitQuaternion<f32>) -> Vector3<f32> {
    let sign = if rotation.w < 0.0 { -1.0 } else { 1.0 };
    let vector = rotation.imag() * sign;
    let square = vector.norm_squared();
    let beyond = 3.0 / 40.0 + square * (15.0 / 336.0 + square * 105.0 / 3_456.0);
    vector * (2.0 * (1.0 + square * (1.0 / 6.0 + square * beyond)))
}
