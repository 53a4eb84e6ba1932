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

use hexsense::sampling::{BLOCK, Values};
use micromath::F32Ext;

/// Roll and pitch, rad, from a block's calibrated values; wrong while the base accelerates.
pub fn tilt(values: &[Values; BLOCK]) -> [f32; 2] {
    let sum = |axis: usize| values.iter().map(|scan| scan[axis]).sum::<f32>();
    let (ax, ay, az) = (sum(0), sum(1), sum(2));
    [(-az).atan2(ay), ax.atan2((ay * ay + az * az).sqrt())]
}
