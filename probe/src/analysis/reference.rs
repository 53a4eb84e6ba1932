//! What the sensors should feel on a held-out movement, by the pose from the jacks.

use hexsense_core::calibration::truth::{Site, coordinates};
use hexsense_core::channel::{INERTIAL, JACKS};
use nalgebra::{UnitQuaternion, Vector3};

use super::AnalysisError;
use super::RecordedRun;
use super::assumptions::Assumptions;
use super::filter::zero_phase_low_pass;
use super::poses::RunPoses;
use super::results::Results;
use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// Corner of the low-pass, Hz.
pub const CORNER_HZ: f64 = 2.0;
/// Rate at which values and reference are compared, Hz.
pub const RATE_HZ: f64 = 100.0;

/// Values of all nine channels at [`RATE_HZ`], in their units.
pub type Signals = [Vec<f64>; INERTIAL];

/// Values that follow from the mean counts of the jacks, one row for each value: the pose is smoothed first, then
/// differentiated.
///
/// # Errors
/// [`AnalysisError::Pose`] and [`AnalysisError::Tolerance`].
pub fn reference(
    base: &GeometryFile,
    sensors: &SensorFile,
    run: &RecordedRun,
    results: &Results,
    jacks: &[[f64; JACKS]],
) -> Result<Signals, AnalysisError> {
    let assumptions = Assumptions::new(base, sensors);
    let mut poses = RunPoses::new(&assumptions, &run.name)?;
    let mut series: [Vec<f64>; 6] = Default::default();
    for counts in jacks {
        let pose = poses.next(counts)?;
        for (series, value) in series.iter_mut().zip(coordinates(&pose)) {
            series.push(value);
        }
    }
    let smooth = series.map(|series| zero_phase_low_pass(&series, CORNER_HZ, RATE_HZ));
    let vector = |from: usize, index: usize| Vector3::from_fn(|axis, _| smooth[from + axis][index]);
    let attitude: Vec<UnitQuaternion<f64>> = (0..jacks.len())
        .map(|index| UnitQuaternion::from_scaled_axis(vector(3, index)))
        .collect();
    let position: Vec<Vector3<f64>> = (0..jacks.len()).map(|index| vector(0, index)).collect();
    let lever_arm_m = Vector3::from(results.lever_arm_m.map(|place| place.estimate));
    Ok(felt(
        &position,
        &attitude,
        &Site {
            lever_arm_m,
            ..assumptions.site
        },
    ))
}

/// Specific force, angular acceleration and rate along a path sampled at [`RATE_HZ`].
fn felt(position: &[Vector3<f64>], attitude: &[UnitQuaternion<f64>], site: &Site) -> Signals {
    let last = position.len().saturating_sub(1);
    let around = |index: usize| (index.saturating_sub(1), (index + 1).min(last));
    let rate: Vec<Vector3<f64>> = (0..position.len())
        .map(|index| {
            let (before, after) = around(index);
            let turn = attitude[before].rotation_to(&attitude[after]);
            // The turn is about an earth axis; the sensors feel it in body axes.
            attitude[index].inverse_transform_vector(&turn.scaled_axis()) * RATE_HZ
                / (after - before).max(1) as f64
        })
        .collect();
    let mut signals: Signals = Default::default();
    for index in 0..position.len() {
        let (before, after) = around(index);
        let angular = (rate[after] - rate[before]) * RATE_HZ / (after - before).max(1) as f64;
        let linear =
            (position[after] - position[index] * 2.0 + position[before]) * RATE_HZ * RATE_HZ;
        let arm = site.lever_arm_m;
        let force = attitude[index]
            .inverse_transform_vector(&(linear + Vector3::y() * site.gravity_m_s2))
            + angular.cross(&arm)
            + rate[index].cross(&rate[index].cross(&arm));
        for axis in 0..3 {
            signals[axis].push(force[axis]);
            signals[3 + axis].push(angular[axis]);
            signals[6 + axis].push(rate[index][axis]);
        }
    }
    signals
}
