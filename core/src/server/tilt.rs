//! The live tilt that the status shows: approximate, for a person who watches the board being mounted.
//!
//! At rest the accelerometers show gravity alone, f = g·(sin ϑ, cos ϑ cos γ, −cos ϑ sin γ), so that
//!
//! ```text
//! roll γ = atan2(−az, ay)      pitch ϑ = atan2(ax, √(ay² + az²))
//! ```
//!
//! The functions are micromath's, fast and coarse (an arctangent is off by up to 3 mrad). Nothing that is stored,
//! estimated or reported as a measurement is computed here.

use crate::sampling::Values;
use micromath::F32Ext;

/// Sums of ax, ay and az over a block's calibrated values.
pub fn sums(values: &[Values]) -> [f32; 3] {
    [0, 1, 2].map(|axis| values.iter().map(|scan| scan[axis]).sum::<f32>())
}

/// Roll and pitch, rad, from a block's [`sums`]; wrong while the base accelerates. `None` for sums without a direction.
pub fn tilt([ax, ay, az]: [f32; 3]) -> Option<[f32; 2]> {
    // By the trait's name: where the standard library is linked, its exact functions have the same names.
    let radial = F32Ext::sqrt(ay * ay + az * az);
    let tilt = [F32Ext::atan2(-az, ay), F32Ext::atan2(ax, radial)];
    tilt.iter().all(|angle| angle.is_finite()).then_some(tilt)
}
