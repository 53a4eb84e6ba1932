//! The base of both examples.

use hexsense_core::kinematics::Geometry;
use nalgebra::Vector3;

/// Three pairs of upper hinges: pair j lies at 120°·j from X (forward) toward Z (right), and its two jacks go to lower
/// hinges 52° to either side. Radii and stroke are those of the preset `an-74tk-200`.
pub fn base() -> Geometry<f64> {
    // Y is up. The upper hinges lie in a plane of the body frame, the lower ones in a plane of the earth frame.
    let on_circle = |radius_m: f64, angle_deg: f64| {
        let (sine, cosine) = angle_deg.to_radians().sin_cos();
        Vector3::new(radius_m * cosine, 0.0, radius_m * sine)
    };
    let pair_deg = |jack: usize| 120.0 * (jack / 2) as f64;
    let side_deg = |jack: usize| if jack.is_multiple_of(2) { -52.0 } else { 52.0 };
    let lower = std::array::from_fn(|jack| on_circle(2.20, pair_deg(jack) + side_deg(jack)));
    let upper = std::array::from_fn(|jack| on_circle(1.50, pair_deg(jack)));
    // Without a home height, home is where the jacks are at mid-stroke.
    Geometry::new(lower, upper, 2.10, 3.40, None).expect("these hinges hold a platform")
}
