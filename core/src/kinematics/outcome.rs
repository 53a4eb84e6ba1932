//! What forward kinematics is asked for and what it answers.

use nalgebra::{RealField, convert};
use thiserror::Error;

use super::pose::Pose;

/// How far a measured jack may read beyond its stroke, m: a transducer is off by some millimetres at most.
const MEASURED_STROKE_MARGIN_M: f64 = 0.01;

/// How exact a solution must be and what is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<T> {
    /// Greatest difference between a wanted length and that of the solution, m. Not taken below four units in the
    /// last place of the greatest length: 4e-15 m in `f64` and 2e-6 m in `f32` for jacks of 4 m. One more step is
    /// made beyond it, so that errors are usually much smaller.
    pub tolerance_m: T,
    /// Iterations in all, before a solution is given up.
    pub max_iterations: u32,
    /// Greatest condition number of the Jacobian of a solution; see [`super::jacobian`](mod@super::jacobian).
    pub max_condition: T,
    /// How far a length may lie outside the stroke, m: measured lengths have errors, and a base at rest on its stops
    /// is not broken.
    pub stroke_margin_m: T,
    /// How far O may move from one tracked pose to the next, m.
    pub jump_m: T,
    /// How far the body may turn from one tracked pose to the next, rad, less than π.
    pub jump_rad: T,
}

impl<T: RealField + Copy> Default for Options<T> {
    /// 1e-10 m, 200 iterations, condition number 1e5, 1 µm outside the stroke, and jumps of 0.05 m and 0.05 rad: at
    /// 1 kHz no base moves a hundredth of that between samples.
    fn default() -> Self {
        Self {
            tolerance_m: convert(1e-10),
            max_iterations: 200,
            max_condition: convert(1e5),
            stroke_margin_m: convert(1e-6),
            jump_m: convert(0.05),
            jump_rad: convert(0.05),
        }
    }
}

impl<T: RealField + Copy> Options<T> {
    /// The default, but for lengths that transducers measure: 10 mm outside the stroke.
    #[must_use]
    pub fn measured() -> Self {
        Self {
            stroke_margin_m: convert(MEASURED_STROKE_MARGIN_M),
            ..Self::default()
        }
    }
}

/// A pose with the lengths that were asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T: RealField + Copy> {
    /// The pose.
    pub pose: Pose<T>,
    /// Steps it took to bring the residual below the tolerance.
    pub iterations: u32,
    /// Upper bound of the greatest difference between a wanted length and that of the pose, m, as measured before the
    /// last correction.
    pub residual_m: T,
    /// Upper bound of the condition number of the Jacobian, for a base of some metres within ten times the number.
    /// [`Solver::condition`](super::forward::Solver::condition) computes the number.
    pub condition_bound: T,
}

/// Why there is no pose to return.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ForwardError<T: RealField + Copy> {
    /// A length is infinite or not a number.
    #[error("the length of jack {jack} is {length_m}: give a finite number of metres")]
    NotFinite {
        /// The jack, 1..=6.
        jack: u8,
        /// Its length.
        length_m: T,
    },
    /// The pose to start from has a coordinate that is infinite or not a number.
    #[error("the pose to start from has a coordinate that is not a finite number")]
    StartNotFinite,
    /// A length is outside the stroke, and so would be any solution.
    #[error(
        "jack {jack} is {length_m} m long, outside its stroke of {length_min_m} m to {length_max_m} m: \
         check the transducer and the geometry"
    )]
    OutsideStroke {
        /// The jack, 1..=6, that is farthest from mid-stroke.
        jack: u8,
        /// Its length, m.
        length_m: T,
        /// The shortest length, m.
        length_min_m: T,
        /// The greatest length, m.
        length_max_m: T,
    },
    /// The Jacobian is singular, or nearly, at the solution or at the start.
    #[error("the Jacobian is singular: its condition number is {condition}, the limit {limit}")]
    Singular {
        /// Condition number.
        condition: T,
        /// The limit, [`Options::max_condition`].
        limit: T,
    },
    /// The branch of the start, or the neighbourhood of the guess, has no pose with these lengths.
    #[error(
        "no pose that can be reached from the start has these lengths: at best they are off by up to {short_m} m; \
         check the transducers, or start nearer"
    )]
    Unreachable {
        /// How far, at the last pose on the way, a length is from what was wanted, m.
        short_m: T,
    },
    /// The iterations were used up.
    #[error(
        "no pose after {iterations} iterations, lengths still off by up to {short_m} m: start nearer"
    )]
    NoConvergence {
        /// Iterations made, the limit [`Options::max_iterations`].
        iterations: u32,
        /// How far, at the last pose on the way, a length is from what was wanted, m.
        short_m: T,
    },
    /// A pose has these lengths, but only one on another assembly branch was found.
    #[error(
        "the pose with these lengths is on another assembly branch: det J changes its sign on the way there"
    )]
    BranchChanged,
    /// The pose is too far from the last one.
    #[error(
        "the pose jumped by {distance_m} m and {angle_rad} rad, over the limit of {limit_m} m or {limit_rad} rad: \
         a sample was lost, a transducer is broken, or this is another assembly branch"
    )]
    Jump {
        /// Distance from the last position, m.
        distance_m: T,
        /// Angle from the last rotation, rad.
        angle_rad: T,
        /// The limit, [`Options::jump_m`].
        limit_m: T,
        /// The limit, [`Options::jump_rad`].
        limit_rad: T,
    },
}
