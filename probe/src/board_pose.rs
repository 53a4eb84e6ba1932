//! The board's own poses, held against double precision.
//!
//! The board solves in `f32`; here the same mean counts and the same coefficients are solved in `f64`, each block from
//! home. What is between the two is what the board's precision costs.

use hexsense_core::kinematics::{Angles, Convention, ForwardError, Pose};
use hexsense_core::live_pose::{JackBlock, Tracker};
use hexsense_core::records::{BaseError, CoefficientSet, SetId};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::{BoardPose, PoseRefusal, PoseReport, pose};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde_json::json;

use crate::capture::Capture;

/// Most that a board's pose may be off, m and rad: what the solver promises in single precision.
pub const MAX_DIFFERENCE: f64 = 5e-7;

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
        "only {poses} poses came where {due} were due; check that nothing else loads the link, then verify again"
    )]
    Missing {
        /// Poses that belong to a block of the capture.
        poses: usize,
        /// Poses that the board makes in that time.
        due: usize,
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
         {MAX_DIFFERENCE:.0e} m and rad; firmware and hexsense are of different builds, or single precision does not do for \
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

/// Compares the poses that came beside `capture`, all made with `set`, with those of double precision; the scans were
/// taken at a rate, Hz, and so many at a time.
///
/// # Errors
/// [`BoardPoseError`], with the first scan that is wrong.
pub fn compare(
    capture: &Capture,
    (rate_hz, block_size): (u32, BlockSize),
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
        let Some(block) = block(capture, scan, report.block) else {
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
        if !(distance_m <= MAX_DIFFERENCE && angle_rad <= MAX_DIFFERENCE) {
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
    let due = capture.scans.len() / scans_of_pose(block_size, rate_hz);
    let poses = difference.poses;
    // Some may be late while the link is busy.
    if poses == 0 || poses < due / 10 * 9 {
        return Err(BoardPoseError::Missing { poses, due });
    }
    Ok(difference)
}

/// Scans from one pose to the next: a whole number of blocks that takes at least as long as a pose may.
fn scans_of_pose(block: BlockSize, rate_hz: u32) -> usize {
    let least = rate_hz.div_ceil(pose::MAX_RATE_HZ) as usize;
    least.next_multiple_of(block.scans())
}

/// The block of so many scans of a capture that begins with `first_scan`, if it is there without a gap.
fn block(capture: &Capture, first_scan: u64, size: BlockSize) -> Option<JackBlock> {
    let window = capture.window(first_scan, size.scans())?;
    let supply = capture.supply[window.start];
    JackBlock::new(first_scan, supply, &capture.counts[window])
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry_file::GeometryFile;
    use hexsense_core::channel::INERTIAL;
    use hexsense_core::kinematics::displacements;
    use hexsense_core::records::{JackCoefficients, MotionBase, TriadCoefficients};

    const ID: SetId = SetId([3; 8]);

    fn set() -> CoefficientSet {
        let triad = TriadCoefficients {
            offset: [32_768.0; 3],
            matrix: [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]],
            offset_uncertainty: [1.0; 3],
            matrix_uncertainty: [[1e-7; 3]; 3],
            delay_s: 0.0,
        };
        let geometry = GeometryFile::load("an-74tk-200").unwrap().geometry;
        CoefficientSet {
            board: [1; 12],
            geometry: "base".try_into().unwrap(),
            geometry_hash: [1; 8],
            unix_s: 0,
            temperature_c: 30.0,
            provenance: [2; 32],
            triads: [triad; 3],
            base: MotionBase::new(&geometry),
            jacks: JackCoefficients {
                zero_length_m: geometry.mid_length_m() as f32,
                zero_counts: [31_000.25; 6],
                metres_per_count: [2.3e-5; 6],
            },
        }
    }

    /// Ten blocks in which the base rises and turns, with counts that are not whole blocks of one number.
    fn moving(set: &CoefficientSet) -> (Capture, Vec<PoseReport>) {
        let geometry = GeometryFile::load("an-74tk-200").unwrap().geometry;
        let mut capture = Capture::default();
        for scan in 0..160_u64 {
            let turn = Vector3::new(0.1, -0.05, 0.15) * scan as f64 / 160.0;
            let pose = Pose {
                position: geometry.home().position
                    + Vector3::new(0.1, 0.2, -0.1) * scan as f64 / 160.0,
                rotation: UnitQuaternion::from_scaled_axis(turn),
            };
            let counts =
                displacements(&geometry, &pose).map(|metres| (metres / 2.3e-5 + 31_000.25) / 0.998);
            capture.scans.push(5_000 + scan);
            capture.supply.push(0.998);
            capture.temperature_c.push(30.0);
            let mut row = [0; 15];
            for (count, there) in row[INERTIAL..].iter_mut().zip(counts) {
                *count = there.round() as u16;
            }
            capture.counts.push(row);
        }
        let mut board = Tracker::<f32>::new(&set.base, &set.jacks).unwrap();
        let reports = (0..10).map(|index| {
            let scan = 5_000 + 16 * index;
            let outcome = board.next(&block(&capture, scan, BlockSize::default()).unwrap());
            PoseReport {
                block: BlockSize::default(),
                first_scan: scan,
                set: ID,
                outcome: outcome.map(Into::into).map_err(Into::into),
            }
        });
        let reports = reports.collect();
        (capture, reports)
    }

    #[test]
    fn single_precision_follows_a_moving_base_within_the_limit() {
        let set = set();
        let (capture, reports) = moving(&set);
        let difference =
            compare(&capture, (1_000, BlockSize::Sixteen), &reports, &set, ID).unwrap();
        assert_eq!(difference.poses, 10);
        assert!(difference.largest_m > 0.0, "{difference:?}");
        // The last block's middle is at 151.5 of 160 steps; whole counts are a hundredth of a millimetre each.
        let pose = double(&reports[9].outcome.unwrap());
        let expected = Vector3::y() * 2.129757 + Vector3::new(0.1, 0.2, -0.1) * 151.5 / 160.0;
        assert!((pose.position - expected).norm() < 2e-5, "{pose:?}");
    }

    #[test]
    fn a_pose_that_is_off_missing_refused_or_of_another_set_is_found() {
        let set = set();
        let (capture, good) = moving(&set);
        let spoilt = |change: &dyn Fn(&mut Vec<PoseReport>)| {
            let mut reports = good.clone();
            change(&mut reports);
            compare(&capture, (1_000, BlockSize::Sixteen), &reports, &set, ID).unwrap_err()
        };
        let off = spoilt(&|reports| {
            let mut pose = reports[7].outcome.unwrap();
            pose.position_m[2] += 1e-6;
            reports[7].outcome = Ok(pose);
        });
        assert!(
            matches!(off, BoardPoseError::Off { scan: 5112, .. }),
            "{off}"
        );
        let turned = spoilt(&|reports| {
            let mut pose = reports[7].outcome.unwrap();
            pose.rotation[1] += 1e-6;
            reports[7].outcome = Ok(pose);
        });
        assert!(matches!(turned, BoardPoseError::Off { .. }), "{turned}");
        let missing = spoilt(&|reports| drop(reports.drain(..3)));
        let expected = BoardPoseError::Missing { poses: 7, due: 10 };
        assert_eq!(missing, expected);
        let refused = spoilt(&|reports| reports[0].outcome = Err(PoseRefusal::Singular));
        assert!(matches!(
            refused,
            BoardPoseError::Refused { scan: 5000, .. }
        ));
        let other = spoilt(&|reports| reports[2].set = SetId([4; 8]));
        assert!(matches!(other, BoardPoseError::OtherSet { scan: 5032, .. }));
    }

    #[test]
    fn people_read_metres_and_degrees_or_why_there_is_no_pose() {
        let set = set();
        let (_, reports) = moving(&set);
        let text = line(&reports[9], &set).unwrap();
        assert!(
            text.contains("m; roll 5.") && text.contains("condition number"),
            "{text}"
        );
        let none = PoseReport {
            outcome: Err(PoseRefusal::OutsideStroke {
                jack: 3,
                length_m: 4.5,
            }),
            ..reports[0]
        };
        assert!(
            line(&none, &set)
                .unwrap()
                .contains("none: jack 3 reads 4.5 m")
        );
        assert!(to_json(&none, &set).unwrap()["refused"].is_string());
    }
}
