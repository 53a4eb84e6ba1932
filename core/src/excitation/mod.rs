//! Program signals: the movements of the base for the calibration of its sensors.
//!
//! A *program* moves some degrees of freedom by a *signal* each, all others held at home. Its samples become six
//! jack programs through inverse kinematics ([`Program::jack_rows`]).
//!
//! | signal | used for | file |
//! |---|---|---|
//! | ramps and holds | static tilts: gravity's projection on the holds | [`ramps`] |
//! | sine | amplitude at a drive frequency | [`sine`] |
//! | multisine | many frequencies, and several degrees of freedom, at once | [`multisine`], phases by [`crest`] |
//!
//! Displacements are from home: metres along X, Y, Z; roll γ, yaw ψ, pitch ϑ in radians, put together as
//! A = Ry(ψ)·Rz(ϑ)·Rx(γ).
//!
//! Every signal can start and end without a jolt: ramps by their shape, sines and multisines by their fades, all along
//! [`smooth_step`], whose jerk is bounded.

pub mod crest;
pub mod multisine;
pub mod program;
pub mod ramps;
pub mod sine;

pub use multisine::Multisine;
pub use program::{DegreeOfFreedom, Program, Signal};
pub use ramps::{RampShape, Ramps};
pub use sine::Sine;

/// Smooth step from 0 at s = 0 to 1 at s = 1, with zero speed and acceleration at both ends: 10s³ − 15s⁴ + 6s⁵.
///
/// Its largest slope is 15/8, its largest curvature 10/√3 and its largest third derivative 60.
#[must_use]
pub fn smooth_step(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

/// The part of a signal of `duration_s` seconds at `t_s`, 0 to 1: it rises over `fade_s` along a [`smooth_step`], stays
/// one and falls as it rose; without a fade it is one at once.
fn envelope(t_s: f64, duration_s: f64, fade_s: f64) -> f64 {
    let faded = |time_s: f64| {
        if fade_s > 0.0 {
            smooth_step(time_s / fade_s)
        } else {
            f64::from(u8::from(time_s >= 0.0))
        }
    };
    faded(t_s) * faded(duration_s - t_s)
}
