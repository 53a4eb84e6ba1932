//! A pose of the board in double precision, for people and as JSON.

use hexsense_core::kinematics::{Angles, Convention, Pose};
use hexsense_core::live_pose::Tracker;
use hexsense_core::records::{BaseError, CoefficientSet};
use hexsense_core::wire::{BoardPose, PoseReport};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde_json::json;

use crate::plan::conditioning::condition_at;

/// The board's pose in double precision.
#[must_use]
pub fn double(pose: &BoardPose) -> Pose<f64> {
    let [w, x, y, z] = pose.rotation.map(f64::from);
    Pose {
        position: Vector3::from(pose.position_m.map(f64::from)),
        rotation: UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
    }
}

/// Condition number of the Jacobian of `set`'s base at the board's pose.
///
/// # Errors
/// [`BaseError`].
pub fn condition(pose: &BoardPose, set: &CoefficientSet) -> Result<f64, BaseError> {
    let tracker = Tracker::<f64>::new(&set.base, &set.jacks, set.ratiometric)?;
    Ok(tracker.solver().condition(&double(pose)))
}

/// The same with metres counted in radii of the upper hinges, as `hexsense plan` prints it.
fn condition_in_radii(pose: &BoardPose, set: &CoefficientSet) -> Result<f64, BaseError> {
    let tracker = Tracker::<f64>::new(&set.base, &set.jacks, set.ratiometric)?;
    Ok(condition_at(tracker.solver().geometry(), &double(pose)))
}

/// A report as a line for people.
///
/// # Errors
/// [`BaseError`].
pub fn line(report: &PoseReport, set: &CoefficientSet) -> Result<String, BaseError> {
    let pose = match &report.outcome {
        Ok(pose) => pose,
        Err(refusal) => return Ok(format!("pose      none: {refusal}\n")),
    };
    let (position, angles) = coordinates(pose);
    Ok(format!(
        "pose      x {:.4} m, y {:.4} m, z {:.4} m; roll {:.3}°, yaw {:.3}°, pitch {:.3}°; cond(J) {:.2}, as in plan, with lengths over \
         the mean radius of the upper hinges ({:.2} in metres and radians)\n",
        position.x,
        position.y,
        position.z,
        angles.roll.to_degrees(),
        angles.yaw.to_degrees(),
        angles.pitch.to_degrees(),
        condition_in_radii(pose, set)?,
        condition(pose, set)?,
    ))
}

/// A report as JSON: position in m and angles in rad, or the reason why there is none.
///
/// # Errors
/// [`BaseError`].
pub fn to_json(report: &PoseReport, set: &CoefficientSet) -> Result<serde_json::Value, BaseError> {
    let pose = match &report.outcome {
        Ok(pose) => pose,
        Err(refusal) => return Ok(json!({"refused": refusal.to_string()})),
    };
    let (position, angles) = coordinates(pose);
    Ok(json!({
        "x": position.x, "y": position.y, "z": position.z,
        "roll": angles.roll, "pitch": angles.pitch, "yaw": angles.yaw,
        "residual": pose.residual_m,
        "condition": condition(pose, set)?,
        "condition_in_radii": condition_in_radii(pose, set)?,
        "iterations": pose.iterations,
    }))
}

/// Position, m, and angles, rad, by GOST 20058-80.
fn coordinates(pose: &BoardPose) -> (Vector3<f64>, Angles<f64>) {
    Convention::Gost.coordinates(&double(pose))
}
