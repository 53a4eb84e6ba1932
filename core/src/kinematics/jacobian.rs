//! The Jacobian of the jack lengths and its condition number.
//!
//! For a small movement (δp, δφ), position in m and rotation vector in rad, both in the earth frame, equation (2) is
//!
//! ```text
//! δl_k = e_k·δp + (c_k × e_k)·δφ        e_k = d_k/|d_k|,  c_k = A·b_k
//! ```
//!
//! so that row k of J is [e_k, c_k × e_k]. A rotation vector has no gimbal lock: J loses rank only where the base
//! itself does.
//!
//! The condition number is that of J as it stands, with metres and radians as units. Exact values cost a singular
//! value decomposition, and the solver needs none: with r² the mean of |b_k|², the rows of J with the rotation
//! scaled by 1/r have squares that sum to at most 12, and for any 6×6 matrix
//!
//! ```text
//! cond(M) < 2/|det M|·(‖M‖²/6)³        H. W. Guggenheimer, A. S. Edelman, C. R. Johnson, "A simple estimate of the
//!                                      condition number of a linear system", College Math. J. 26 (1995)
//! cond(J) < 16·r³·max(r, 1/r)/|det J|  with that scaling undone
//! ```

use nalgebra::{Matrix6, RealField, SVD, Vector3, convert};

use super::{
    geometry::Geometry,
    inverse::jacks,
    linear::Rows,
    pose::Pose,
    six::{Six, cross},
};

/// A 6×6 decomposition takes about ten; the limit only makes sure that it ends.
const SVD_ITERATIONS: usize = 1000;

/// Jacobian of the jack lengths at `pose`: row k is jack k, columns 0..3 are m per m of position, columns 3..6 m per
/// rad of rotation vector, both in the earth frame.
///
/// A jack of length zero has no direction; its row is not a number.
pub fn jacobian<T: RealField + Copy>(geometry: &Geometry<T>, pose: &Pose<T>) -> Matrix6<T> {
    let directions = jacks(geometry, pose).map(|d| d / d.norm());
    let mut jacobian = Matrix6::zeros();
    for (k, e) in directions.iter().enumerate() {
        let moment = (pose.rotation * geometry.upper()[k]).cross(e);
        for axis in 0..3 {
            jacobian[(k, axis)] = e[axis];
            jacobian[(k, axis + 3)] = moment[axis];
        }
    }
    jacobian
}

/// Condition number of `matrix` in the 2-norm, 1 at best; infinite if the matrix is singular or not finite.
pub fn condition<T: RealField + Copy>(matrix: &Matrix6<T>) -> T {
    if !matrix.iter().all(T::is_finite) {
        return infinity();
    }
    let accuracy = T::default_epsilon() * convert(5.0);
    match SVD::try_new(*matrix, false, false, accuracy, SVD_ITERATIONS) {
        Some(svd) if svd.singular_values.min() > T::zero() => {
            svd.singular_values.max() / svd.singular_values.min()
        }
        _ => infinity(),
    }
}

/// The module's upper bound of the condition number of the Jacobian at `pose`, by its determinant; infinite or not a
/// number if the Jacobian is singular or not finite.
pub fn condition_bound<T: RealField + Copy>(geometry: &Geometry<T>, pose: &Pose<T>) -> T {
    let squares = geometry.upper().iter().map(|b| b.norm_squared());
    let radius_squared = squares.fold(T::zero(), |sum, square| sum + square) / convert(6.0);
    let jacks = jacks(geometry, pose);
    let directions = jacks.map(|d| d / d.norm());
    let by_coordinate = |v: [Vector3<T>; 6]| [0, 1, 2].map(|axis| Six(v.map(|v| v[axis])));
    let direction = by_coordinate(directions);
    let hinge = by_coordinate(geometry.upper().map(|b| pose.rotation * b));
    let rows = Rows {
        direction,
        moment: cross(&hinge, &direction),
    };
    let determinant = rows.ordered(&rows.best_order()).factor().determinant;
    bound_times_determinant(radius_squared) / determinant.abs()
}

/// The constant 16·r³·max(r, 1/r) of the bound.
pub(super) fn bound_times_determinant<T: RealField + Copy>(radius_squared: T) -> T {
    let radius = radius_squared.sqrt();
    radius_squared * radius * radius.max(T::one() / radius) * convert(16.0)
}

fn infinity<T: RealField>() -> T {
    T::one() / T::zero()
}
