//! The board's own poses compared with double precision.
//!
//! The board solves in `f32`; here the same mean counts and the same coefficients are solved in `f64`, each block from
//! home. The difference of the two is what single precision costs.

mod text;

use hexsense_core::kinematics::ForwardError;
use hexsense_core::live_pose::{JackBlock, Tracker};
use hexsense_core::records::{BaseError, CoefficientSet, SetId};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::{PoseRefusal, PoseReport, pose};

use crate::capture::Capture;
pub use text::{condition, double, line, to_json};

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
    let mut tracker = Tracker::<f64>::new(&set.base, &set.jacks, set.ratiometric)?;
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
        if !is_close(distance_m, angle_rad) {
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

/// Whether a pose that is off by so much, m and rad, is the board's; what is not a number is not.
fn is_close(distance_m: f64, angle_rad: f64) -> bool {
    distance_m <= MAX_DIFFERENCE && angle_rad <= MAX_DIFFERENCE
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

#[cfg(test)]
mod tests;
