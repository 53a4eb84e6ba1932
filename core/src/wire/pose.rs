//! The board's own pose, sent beside the blocks while it streams.
//!
//! A report belongs to one block, by its scan counter, and names the set behind it. It carries a pose or the reason why
//! there is none: a missing pose is always reported.

use serde::{Deserialize, Serialize};

use super::frame::{self, FrameError, Kind};
use crate::kinematics::{ForwardError, Solution};
use crate::records::{BaseError, SetId};
use crate::sampling::BlockSize;

/// Most reports in a second; if blocks come faster, the latest counts.
pub const MAX_RATE_HZ: u32 = 100;
/// Upper bound of an encoded report, bytes: scan 10, block 1, set 8, variant 1, pose 37.
pub const MAX_REPORT: usize = 57;

/// The pose over one block, or why there is none.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoseReport {
    /// Scan counter of the first scan of the block.
    pub first_scan: u64,
    /// Scans of the block.
    pub block: BlockSize,
    /// Set whose base and transducers were used.
    pub set: SetId,
    /// The pose, or why there is none.
    pub outcome: Result<BoardPose, PoseRefusal>,
}

/// A pose in the frames of [`crate::kinematics`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BoardPose {
    /// Position of O in the earth frame, m.
    pub position_m: [f32; 3],
    /// Unit quaternion [w, x, y, z] that turns body coordinates into earth coordinates.
    pub rotation: [f32; 4],
    /// Bound of the greatest difference between a jack's length and that of the pose, m.
    pub residual_m: f32,
    /// Bound of the condition number of the Jacobian, within ten times the number.
    pub condition_bound: f32,
    /// Steps of the solver.
    pub iterations: u8,
}

/// Why a block has no pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum PoseRefusal {
    /// The set's base or transducers are not usable.
    #[error("the base in the coefficient set is not usable: {0}")]
    Base(BaseError),
    /// A length is not a number.
    #[error("the length of jack {jack} is not a finite number; check the supply of the board")]
    NotFinite {
        /// The jack, 1 to 6.
        jack: u8,
    },
    /// A jack reads beyond its stroke.
    #[error(
        "jack {jack} reads {length_m} m, outside its stroke; check that transducer and the sensor file"
    )]
    OutsideStroke {
        /// The jack, 1 to 6, that is farthest from mid-stroke.
        jack: u8,
        /// Its length, m.
        length_m: f32,
    },
    /// The pose is singular, or nearly.
    #[error(
        "the base is in a singular pose, where its jacks do not hold it; bring it towards home"
    )]
    Singular,
    /// No pose has these lengths.
    #[error(
        "no pose has these jack lengths, off by {short_m} m at best; check transducers and geometry file"
    )]
    Unreachable {
        /// Greatest error of a length at the last pose of the solver, m.
        short_m: f32,
    },
    /// The iterations were used up.
    #[error("the solver did not come to an end, lengths off by {short_m} m; check the transducers")]
    NoConvergence {
        /// Greatest error of a length at the last pose of the solver, m.
        short_m: f32,
    },
    /// Only a pose on another assembly branch was found.
    #[error("only a pose on another assembly branch has these jack lengths; check the transducers")]
    BranchChanged,
    /// The pose is too far from the last one.
    #[error(
        "the pose jumped by {distance_m} m and {angle_rad} rad from one block to the next; check the transducers"
    )]
    Jump {
        /// Distance from the last position, m.
        distance_m: f32,
        /// Angle from the last rotation, rad.
        angle_rad: f32,
    },
}

impl From<Solution<f32>> for BoardPose {
    fn from(solution: Solution<f32>) -> Self {
        let q = solution.pose.rotation.quaternion();
        Self {
            position_m: solution.pose.position.into(),
            rotation: [q.w, q.i, q.j, q.k],
            residual_m: solution.residual_m,
            condition_bound: solution.condition_bound,
            // The solver stops at 200.
            iterations: u8::try_from(solution.iterations).unwrap_or(u8::MAX),
        }
    }
}

impl From<ForwardError<f32>> for PoseRefusal {
    fn from(error: ForwardError<f32>) -> Self {
        match error {
            ForwardError::NotFinite { jack, .. } => Self::NotFinite { jack },
            ForwardError::OutsideStroke { jack, length_m, .. } => {
                Self::OutsideStroke { jack, length_m }
            }
            // A tracker starts from poses that the solver made, which are finite.
            ForwardError::Singular { .. } | ForwardError::StartNotFinite => Self::Singular,
            ForwardError::Unreachable { short_m } => Self::Unreachable { short_m },
            ForwardError::NoConvergence { short_m, .. } => Self::NoConvergence { short_m },
            ForwardError::BranchChanged => Self::BranchChanged,
            ForwardError::Jump {
                distance_m,
                angle_rad,
                ..
            } => Self::Jump {
                distance_m,
                angle_rad,
            },
        }
    }
}

/// Encodes a report as a frame into `out` and returns its length.
///
/// # Errors
/// [`FrameError::Long`] when `out` is shorter than the frame.
pub fn encode(report: &PoseReport, sequence: u16, out: &mut [u8]) -> Result<usize, FrameError> {
    frame::encode(Kind::Pose, sequence, out, |payload| {
        postcard::to_slice(report, payload)
            .ok()
            .map(|used| used.len())
    })
}

/// Decodes the payload of a pose frame; `None` when it is not a report of this version.
#[must_use]
pub fn decode(payload: &[u8]) -> Option<PoseReport> {
    let (report, rest) = postcard::take_from_bytes(payload).ok()?;
    rest.is_empty().then_some(report)
}
