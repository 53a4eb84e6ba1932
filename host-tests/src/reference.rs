//! Reference data written out by hand: a 6-3 base, and the matrix of GOST 20058-80.

use hexsense_core::kinematics::Geometry;
use nalgebra::{Matrix3, Vector3};

/// A 6-3 layout: upper hinges at 0°, 120°, 240°, lower ones 52° to either side of them.
///
/// # Panics
/// Never: its numbers are a valid base.
#[must_use]
pub fn six_three() -> Geometry<f64> {
    let ring = |radius: f64, degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vector3::new(radius * cos, 0.0, radius * sin)
    };
    let side = |jack: usize| if jack.is_multiple_of(2) { -52.0 } else { 52.0 };
    let lower = std::array::from_fn(|jack| ring(2.2, 120.0 * (jack / 2) as f64 + side(jack)));
    let upper = std::array::from_fn(|jack| ring(1.5, 120.0 * (jack / 2) as f64));
    Geometry::new(lower, upper, 2.1, 3.4, None).expect("a valid base")
}

/// A = Ry(ψ)·Rz(ϑ)·Rx(γ), written out as in GOST 20058-80.
#[must_use]
pub fn gost(roll: f64, yaw: f64, pitch: f64) -> Matrix3<f64> {
    let ((sg, cg), (sy, cy), (st, ct)) = (roll.sin_cos(), yaw.sin_cos(), pitch.sin_cos());
    Matrix3::new(
        cy * ct,
        sy * sg - cy * st * cg,
        sy * cg + cy * st * sg,
        st,
        ct * cg,
        -ct * sg,
        -sy * ct,
        cy * sg + sy * st * cg,
        cy * cg - sy * st * sg,
    )
}
