//! Program signals: how the base is driven so that its sensors can be calibrated.
//!
//! A *program* moves some degrees of freedom by a *signal* each, all others held at home. Its samples become six
//! jack programs through inverse kinematics ([`Program::pose`], then [`crate::kinematics::displacements`]).
//!
//! | signal | used for | file |
//! |---|---|---|
//! | ramps and holds | static tilts: gravity's projection on the holds | [`ramps`] |
//! | sine | amplitude at a drive frequency; several at once make a multisine | [`sine`] |
//!
//! Displacements are from home: metres along X, Y, Z; roll γ, yaw ψ, pitch ϑ in radians, put together as
//! A = Ry(ψ)·Rz(ϑ)·Rx(γ).

pub mod program;
pub mod ramps;
pub mod sine;

pub use program::{DegreeOfFreedom, Program, Signal};
pub use ramps::{RampShape, Ramps};
pub use sine::Sine;

/// Smooth step from 0 at s = 0 to 1 at s = 1, with zero speed and acceleration at both ends: 10s³ − 15s⁴ + 6s⁵.
///
/// Its largest slope is 15/8 and its largest curvature 10/√3.
#[must_use]
pub fn smooth_step(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}
