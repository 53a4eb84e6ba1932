//! Where the body is: position and rotation of OXYZ in the earth frame.
//!
//! A point with body coordinates b lies at p + A·b in the earth frame. The rotation is a unit quaternion, so no
//! attitude is special; angles exist only at the edges, in [`super::convention`].

use nalgebra::{RealField, UnitQuaternion, Vector3};

/// Position and rotation of the body frame OXYZ in the earth frame OgXgYgZg (X forward, Y up, Z right).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<T: RealField + Copy> {
    /// Position p of O in the earth frame, m: O itself, not its displacement from home.
    pub position: Vector3<T>,
    /// Rotation A that turns body coordinates into earth coordinates.
    pub rotation: UnitQuaternion<T>,
}

impl<T: RealField + Copy> Pose<T> {
    /// Earth coordinates p + A·b of the point with body coordinates `point`, m.
    pub fn transform(&self, point: &Vector3<T>) -> Vector3<T> {
        self.position + self.rotation * point
    }

    /// Distance of the two origins, m, and angle of the rotation between them, rad in 0..=π.
    pub fn distance(&self, other: &Self) -> (T, T) {
        let position = (self.position - other.position).norm();
        (position, self.rotation.angle_to(&other.rotation))
    }

    /// The pose reached along the straight path from here by `fraction` of the way to `other`: the position moves on
    /// a line and the rotation about one axis.
    pub fn along(&self, other: &Self, fraction: T) -> Self {
        let turn = (self.rotation.inverse() * other.rotation).scaled_axis() * fraction;
        Self {
            position: self.position.lerp(&other.position, fraction),
            rotation: self.rotation * UnitQuaternion::from_scaled_axis(turn),
        }
    }

    /// Whether every coordinate is a finite number.
    pub fn is_finite(&self) -> bool {
        let rotation = self.rotation.coords.iter();
        self.position.iter().chain(rotation).all(T::is_finite)
    }
}
