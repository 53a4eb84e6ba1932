//! The motion base: hinges, stroke and home.
//!
//! Jacks k = 1..6 join the lower hinges a_k, fixed in the earth frame, to the upper hinges b_k, fixed in the body
//! frame. Hinges may coincide (6-3 and 3-6 layouts). *Home* is the pose straight above the origin of the earth
//! frame, level and without turn, that the solver starts from and small movements are counted from.
//!
//! Numbers become a [`Geometry`] only in [`super::validation`].

use nalgebra::{RealField, UnitQuaternion, Vector3, convert};
use simba::scalar::SupersetOf;

use super::pose::Pose;

/// Hinges, stroke and home of a motion base. Constructed only from values that make sense together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry<T: RealField + Copy> {
    pub(super) lower: [Vector3<T>; 6],
    pub(super) upper: [Vector3<T>; 6],
    pub(super) length_min_m: T,
    pub(super) length_max_m: T,
    pub(super) home_height_m: T,
}

impl<T: RealField + Copy> Geometry<T> {
    /// Lower hinges a_k in the earth frame, m.
    pub fn lower(&self) -> &[Vector3<T>; 6] {
        &self.lower
    }

    /// Upper hinges b_k in the body frame, m.
    pub fn upper(&self) -> &[Vector3<T>; 6] {
        &self.upper
    }

    /// Shortest hinge-to-hinge length, m.
    pub fn length_min_m(&self) -> T {
        self.length_min_m
    }

    /// Greatest hinge-to-hinge length, m.
    pub fn length_max_m(&self) -> T {
        self.length_max_m
    }

    /// Length at mid-stroke, l_mid = (l_max + l_min)/2, that displacements are counted from, m.
    pub fn mid_length_m(&self) -> T {
        (self.length_max_m + self.length_min_m) * convert(0.5)
    }

    /// Height of O above the origin of the earth frame at home, m.
    pub fn home_height_m(&self) -> T {
        self.home_height_m
    }

    /// Home: level, without turn, at the home height above the origin of the earth frame.
    pub fn home(&self) -> Pose<T> {
        Pose {
            position: Vector3::new(T::zero(), self.home_height_m, T::zero()),
            rotation: UnitQuaternion::identity(),
        }
    }
}

impl<S: RealField + Copy> Geometry<S> {
    /// The same base with its numbers rounded to another precision.
    pub fn cast<T: RealField + Copy + SupersetOf<S>>(&self) -> Geometry<T> {
        Geometry {
            lower: self.lower.map(|hinge| hinge.map(convert)),
            upper: self.upper.map(|hinge| hinge.map(convert)),
            length_min_m: convert(self.length_min_m),
            length_max_m: convert(self.length_max_m),
            home_height_m: convert(self.home_height_m),
        }
    }
}
