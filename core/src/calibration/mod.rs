//! From what was measured on a moving base to offsets, matrices and their uncertainties.
//!
//! Words: the *truth* is the specific force, angular acceleration and angular rate at the sensor block that follow
//! from the pose, and the pose follows from the jacks; *counts* are a sensor's readings at nominal supply; the
//! *sensitivity* S is counts per physical unit, and what the board stores is its inverse M.
//!
//! ```text
//! u = S·truth + u0        value = M·(u − u0)        M = S⁻¹
//! ```
//!
//! | step | file |
//! |---|---|
//! | zero: the base stands still at home, and must | [`zero`] |
//! | truth on a hold: gravity's projection by the pose | [`truth::specific_force_at_rest`] |
//! | truth of a sine run: rates and accelerations of the fitted pose | [`truth`] |
//! | sensitivity and delay of a triad from holds and sine runs | [`triad`] |
//! | gravity where nobody has measured it | [`gravity`] |
//! | standard uncertainty from all its terms | [`budget`] |
//!
//! The method is that of design section 3: k = A_p / A_1 with A_p = A_u(2πf)² or A_u·2πf, generalised from one axis
//! to three by complex amplitudes, so that the sign and size of cross-axis sensitivity come out too.

pub mod budget;
pub mod gravity;
pub mod triad;
pub mod truth;
pub mod zero;

/// Axes of a triad.
pub const AXES: usize = 3;
