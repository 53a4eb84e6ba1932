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
//! | means, amplitudes and their noise | [`observation`] |
//! | sensitivity and delay of a triad from holds and sine runs | [`triad`] |
//! | gravity where nobody has measured it | [`gravity`] |
//! | standard uncertainty from all its terms | [`budget`] |
//!
//! On one axis that is driven by a sine of frequency f, the method is k = A_p / A_1: A_1 is the amplitude of the
//! sensor's first harmonic in counts, and A_p the true amplitude, A_u·(2πf)² for an angular acceleration and A_u·2πf for
//! an angular rate, from the amplitude A_u of the pose. Here complex amplitudes of all three axes take the place of
//! A_p and A_1, so that the sign and the size of the cross-axis sensitivity come out too.

pub mod budget;
pub mod gravity;
pub mod observation;
pub mod triad;
pub mod truth;
pub mod zero;

/// Axes of a triad.
pub const AXES: usize = 3;
