//! Kinematics of the motion base: jack lengths from a pose and a pose from jack lengths.
//!
//! | file | what |
//! |---|---|
//! | [`geometry`] | hinges, stroke, home |
//! | [`validation`] | which numbers describe a base |
//! | [`pose`], [`convention`] | where the body is, and how people write it down |
//! | [`inverse`](mod@inverse) | jack lengths from a pose, equation (1) |
//! | [`jacobian`](mod@jacobian) | how lengths change with the pose, equation (2), and how well that can be undone |
//! | [`forward`] | a pose from jack lengths, equation (3): what is asked and answered |
//! | [`tracker`] | pose after pose of a moving base |
//! | `refusal.rs` | what it refuses |
//! | `excursion.rs` | the equations of forward kinematics, counted from home |
//! | `newton.rs` | Newton's method on them |
//! | `path.rs` | following the branch, or descending, where Newton's method does not contract |
//! | `linear.rs`, `six.rs`, `exact.rs` | the 6×6 system of a step; six jacks at a time; sums with their errors |
//!
//! Frames: OXYZ is fixed to the body, its origin O in the plane of the upper hinges; the earth frame's origin lies
//! below O at home. Both have X forward, Y up, Z right. Lengths are in metres, angles in radians. Everything is
//! generic over `f32` and `f64`, needs no heap and never panics on numbers.

pub mod convention;
mod exact;
mod excursion;
pub mod forward;
pub mod geometry;
pub mod inverse;
pub mod jacobian;
mod linear;
mod newton;
mod outcome;
mod path;
pub mod pose;
mod refusal;
mod six;
pub mod tracker;
pub mod validation;

pub use convention::{Angles, Convention};
pub use forward::{ForwardError, Options, Solution, Solver};
pub use geometry::Geometry;
pub use inverse::{displacements, inverse};
pub use jacobian::jacobian;
pub use pose::Pose;
pub use tracker::{PoseTracker, ReportFailure, SolveFromHome, SolveJumpsFromHome};
pub use validation::GeometryError;
