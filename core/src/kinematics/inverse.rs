//! Inverse kinematics: the length of each jack from the pose, equation (1).
//!
//! With a_k the lower hinge in the earth frame and b_k the upper hinge in the body frame,
//!
//! ```text
//! d_k = p + A·b_k − a_k        the jack, from its lower to its upper hinge
//! l_k = |d_k|                  its length
//! Δl_k = l_k − l_mid           its displacement, l_mid = (l_max + l_min)/2
//! ```
//!
//! The lengths may lie outside the stroke: a planner needs to see by how much.

use nalgebra::{RealField, Vector3};

use super::{geometry::Geometry, pose::Pose};

/// Hinge-to-hinge length l_k of each jack at `pose`, m.
pub fn inverse<T: RealField + Copy>(geometry: &Geometry<T>, pose: &Pose<T>) -> [T; 6] {
    jacks(geometry, pose).map(|d| d.norm())
}

/// Displacement Δl_k of each jack from mid-stroke at `pose`, m.
pub fn displacements<T: RealField + Copy>(geometry: &Geometry<T>, pose: &Pose<T>) -> [T; 6] {
    inverse(geometry, pose).map(|length| length - geometry.mid_length_m())
}

/// The vectors d_k from the lower to the upper hinge of each jack at `pose`, earth frame, m.
pub fn jacks<T: RealField + Copy>(geometry: &Geometry<T>, pose: &Pose<T>) -> [Vector3<T>; 6] {
    let rotation = pose.rotation.to_rotation_matrix();
    core::array::from_fn(|k| pose.position + rotation * geometry.upper()[k] - geometry.lower()[k])
}
