//! The board's own poses, held against double precision.
//!
//! The board solves in `f32`; here the same mean counts and the same coefficients are solved in `f64`, each block from
//! home. What is between the two is what the board's precision costs.

use hexsense::channel::Scan;
use hexsense::kinematics::{Angles, Convention, ForwardError, Pose};
use hexsense::live_pose::{JackBlock, Tracker};
use hexsense::sampling::BLOCK;
use hexsense::store::{BaseError, CoefficientSet, SetId};
use hexsense::wire::{BoardPose, PoseRefusal, PoseReport};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde_json::json;

use crate::capture::Capture;

/// Most that a board's pose may be off, m and rad: what the solver promises in single precision.
pub const LIMIT: f64 = 5e-7;

/// What the board's precision costs over a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Poses compared.
    pub poses: usize,
    /// Largest distance between the board's O and that of double precision, m.
    pub largest_m: f64,
    /// Largest angle between the two rotations, rad.
    pub largest_rad: f64,
    /// Scan counter of the block with the largest distance.
    pub scan: u64,
}

/// Why the board's poses cannot be trusted.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum BoardPoseError {
    /// The set is not one that poses come from.
    #[error("the coefficient set gives no pose: {0}")]
    Base(#[from] BaseError),
    /// Poses are missing.
    #[error(
        "only {poses} poses came for {blocks} blocks of samples; check that nothing else loads the link, then verify \
         again"
    )]
    Missing {
        /// Poses that belong to a block of the capture.
        poses: usize,
        /// Blocks in it.
        blocks: usize,
    },
    /// A pose was made with other coefficients.
    #[error(
        "scan {scan}: the board made its pose with set {found} instead of {expected}; the set was changed during the \
         run: verify again"
    )]
    OtherSet {
        /// First scan of the block.
        scan: u64,
        /// Set of the pose.
        found: SetId,
        /// Set that is judged.
        expected: SetId,
    },
    /// The board found no pose where there is one.
    #[error(
        "scan {scan}: the board found no pose where double precision finds one: {refusal}; firmware and hexsense are \
         of different builds, or single precision does not do for this base"
    )]
    Refused {
        /// First scan of the block.
        scan: u64,
        /// What the board says.
        refusal: PoseRefusal,
    },
    /// There is no pose to compare with.
    #[error("scan {scan}: double precision finds no pose: {reason}")]
    NoPose {
        /// First scan of the block.
        scan: u64,
        /// Why.
        reason: ForwardError<f64>,
    },
    /// The board's pose is off.
    #[error(
        "scan {scan}: the board's pose is off by {distance_m:.2e} m and {angle_rad:.2e} rad, over the limit of \
         {LIMIT:.0e} m and rad; firmware and hexsense are of different builds, or single precision does not do for \
         this base: do not use the board's pose"
    )]
    Off {
        /// First scan of the block.
        scan: u64,
        /// Distance of O, m.
        distance_m: f64,
        /// Angle, rad.
        angle_rad: f64,
    },
}

/// Compares the poses that came beside `capture`, all made with `set`, with those of double precision.
///
/// # Errors
/// [`BoardPoseError`], with the first scan that is wrong.
pub fn compare(
    capture: &Capture,
    poses: &[PoseReport],
    set: &CoefficientSet,
    id: SetId,
) -> Result<Difference, BoardPoseError> {
    let mut tracker = Tracker::<f64>::new(&set.base, &set.jacks)?;
    let mut difference = Difference {
        poses: 0,
        largest_m: 0.0,
        largest_rad: 0.0,
        scan: 0,
    };
    for report in poses {
        let scan = report.first_scan;
        // The base comes to rest before the capture begins.
        let Some(block) = block(capture, scan) else {
            continue;
        };
        if report.set != id {
            let (found, expected) = (report.set, id);
            return Err(BoardPoseError::OtherSet {
                scan,
                found,
                expected,
            });
        }
        tracker.restart();
        let ours = tracker
            .next(&block)
            .map_err(|reason| BoardPoseError::NoPose { scan, reason })?;
        let theirs = report
            .outcome
            .map_err(|refusal| BoardPoseError::Refused { scan, refusal })?;
        let (distance_m, angle_rad) = double(&theirs).distance(&ours.pose);
        // Negated, so that what is not a number does not pass.
        if !(distance_m <= LIMIT && angle_rad <= LIMIT) {
            return Err(BoardPoseError::Off {
                scan,
                distance_m,
                angle_rad,
            });
        }
        if distance_m > difference.largest_m {
            (difference.largest_m, difference.scan) = (distance_m, scan);
        }
        difference.largest_rad = difference.largest_rad.max(angle_rad);
        difference.poses += 1;
    }
    let (poses, blocks) = (difference.poses, capture.scans.len() / BLOCK);
    // At 1 kHz every block has a pose; some may be late while the link is busy.
    if poses == 0 || poses < blocks / 10 * 9 {
        return Err(BoardPoseError::Missing { poses, blocks });
    }
    Ok(difference)
}

/// The block of a capture that begins with `first_scan`, if it is there without a gap.
fn block(capture: &Capture, first_scan: u64) -> Option<JackBlock> {
    let index = capture.scans.binary_search(&first_scan).ok()?;
    let scans: &[Scan; BLOCK] = capture.counts.get(index..)?.first_chunk()?;
    let last = *capture.scans.get(index + BLOCK - 1)?;
    let whole = last == first_scan + BLOCK as u64 - 1;
    whole.then(|| JackBlock::new(first_scan, capture.supply[index], scans))
}

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
    let tracker = Tracker::<f64>::new(&set.base, &set.jacks)?;
    Ok(tracker.solver().condition(&double(pose)))
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
        "pose      x {:.4} m, y {:.4} m, z {:.4} m; roll {:.3}°, yaw {:.3}°, pitch {:.3}°; condition number {:.2}\n",
        position.x,
        position.y,
        position.z,
        angles.roll.to_degrees(),
        angles.yaw.to_degrees(),
        angles.pitch.to_degrees(),
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
        "iterations": pose.iterations,
    }))
}

/// Position, m, and angles, rad, by GOST 20058-80.
fn coordinates(pose: &BoardPose) -> (Vector3<f64>, Angles<f64>) {
    Convention::Gost.coordinates(&double(pose))
}
