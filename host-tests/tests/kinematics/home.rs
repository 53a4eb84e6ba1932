//! The representative bases are those of the design table, and home is at the right height.

use approx::assert_abs_diff_eq;
use hexsense_core::kinematics::forward::{Options, Solver};
use hexsense_core::kinematics::{Geometry, GeometryError, Pose, displacements, inverse};
use nalgebra::{UnitQuaternion, Vector3};

use crate::bases::{preset, presets};

/// Name, radius of the upper and of the lower hinges, shortest and longest jack, home height, m.
const TABLE: [(&str, f64, f64, f64, f64, f64); 3] = [
    ("il-96-300", 1.80, 2.60, 2.45, 3.95, 2.4500),
    ("tu-204", 1.65, 2.40, 2.30, 3.70, 2.3224),
    ("an-74tk-200", 1.50, 2.20, 2.10, 3.40, 2.1298),
];

/// The hinge at `degrees` from X toward Z.
fn on_circle(radius: f64, degrees: f64) -> Vector3<f64> {
    let angle = degrees.to_radians();
    Vector3::new(radius * angle.cos(), 0.0, radius * angle.sin())
}

#[test]
fn representative_bases_have_the_hinges_of_the_table() {
    for (name, upper, lower, length_min, length_max, height) in TABLE {
        let geometry = preset(name);
        for jack in 0..6 {
            let angle = 120.0 * (jack / 2) as f64;
            let side = if jack % 2 == 0 { -52.0 } else { 52.0 };
            assert_abs_diff_eq!(
                geometry.upper()[jack],
                on_circle(upper, angle),
                epsilon = 1e-9
            );
            assert_abs_diff_eq!(
                geometry.lower()[jack],
                on_circle(lower, angle + side),
                epsilon = 1e-9
            );
        }
        assert_eq!(
            [geometry.length_min_m(), geometry.length_max_m()],
            [length_min, length_max]
        );
        assert_abs_diff_eq!(geometry.home_height_m(), height, epsilon = 5e-5);
    }
}

#[test]
fn representative_bases_move_as_far_as_the_design_says() {
    for (name, ..) in TABLE {
        let geometry = preset(name);
        let condition = Solver::new(&geometry, Options::default()).condition(&geometry.home());
        assert!((2.1..2.65).contains(&condition), "{name}: {condition}");
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            for side in [1.0, -1.0] {
                let metres = reach(&geometry, |q| (axis * side * q, Vector3::zeros()));
                assert!((0.6..1.2).contains(&metres), "{name} {axis:?}: {metres} m");
                let degrees =
                    reach(&geometry, |q| (Vector3::zeros(), axis * side * q)).to_degrees();
                assert!(
                    (25.0..45.0).contains(&degrees),
                    "{name} {axis:?}: {degrees} deg"
                );
            }
        }
    }
}

/// The distance from home along `way` until a jack ends.
fn reach(geometry: &Geometry<f64>, way: impl Fn(f64) -> (Vector3<f64>, Vector3<f64>)) -> f64 {
    let home = geometry.home();
    let inside = |q: &f64| {
        let (shift, turn) = way(*q);
        let pose = Pose {
            position: home.position + shift,
            rotation: UnitQuaternion::from_scaled_axis(turn),
        };
        let stroke = geometry.length_min_m()..=geometry.length_max_m();
        inverse(geometry, &pose)
            .iter()
            .all(|length| stroke.contains(length))
    };
    (0..2000)
        .map(|step| f64::from(step) * 1e-3)
        .take_while(inside)
        .last()
        .unwrap()
}

#[test]
fn home_is_at_mid_stroke() {
    for (name, geometry) in presets() {
        for displacement in displacements(&geometry, &geometry.home()) {
            assert!(displacement.abs() < 1e-6, "{name}: {displacement}");
        }
    }
}

/// The hinges need not lie in the planes through the two origins.
#[test]
fn home_rises_by_as_much_as_the_upper_hinges_sink() {
    let flat = preset("tu-204");
    let sunk = flat.upper().map(|hinge| hinge - Vector3::y() * 0.3);
    let geometry = Geometry::new(*flat.lower(), sunk, 2.3, 3.7, None).unwrap();
    assert_abs_diff_eq!(
        geometry.home_height_m(),
        flat.home_height_m() + 0.3,
        epsilon = 1e-6
    );
}

#[test]
fn every_impossible_base_is_refused_with_its_reason() {
    let good = preset("tu-204");
    let (lower, upper) = (*good.lower(), *good.upper());
    let new = |lower, min, max, height| Geometry::new(lower, upper, min, max, height).unwrap_err();

    let mut broken = lower;
    broken[4].z = f64::NAN;
    let message = new(broken, 2.3, 3.7, None).to_string();
    assert!(
        message.starts_with("the lower hinge of jack 5 is NaN"),
        "{message}"
    );
    assert!(matches!(
        new(lower, 2.3, f64::INFINITY, None),
        GeometryError::NotFinite { .. }
    ));
    assert!(matches!(
        new(lower, -0.1, 3.7, None),
        GeometryError::NegativeLength { .. }
    ));
    assert!(matches!(
        new(lower, 3.7, 3.7, None),
        GeometryError::NoStroke { .. }
    ));
    assert!(matches!(
        new(lower, 0.5, 1.0, None),
        GeometryError::HomeUnreachable { .. }
    ));
    let outside = new(lower, 2.3, 3.7, Some(4.0));
    assert!(
        matches!(outside, GeometryError::HomeOutsideStroke { jack: 1, .. }),
        "{outside}"
    );
    // Similar hexagons above one another can always be turned a little.
    let flat = Geometry::new(upper.map(|b| b * 1.5), upper, 2.3, 3.7, None).unwrap_err();
    assert!(matches!(flat, GeometryError::HomeSingular { .. }), "{flat}");
}
