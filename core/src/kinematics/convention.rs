//! Angles and axes at the edges: four conventions that people read and write.
//!
//! The core keeps a pose as position and quaternion in the frames of the body and the earth with Y up. Files, tables
//! and command lines use angles, and the same three numbers mean different rotations:
//!
//! | convention | axes of its coordinates | rotation, body to earth |
//! |---|---|---|
//! | [`Convention::Gost`] | X forward, Y up, Z right (GOST 20058-80) | A = Ry(yaw)·Rz(pitch)·Rx(roll) |
//! | [`Convention::Zyx`] | x forward, y left, z up | R = Rz(yaw)·Ry(pitch)·Rx(roll) |
//! | [`Convention::Xyz`] | x forward, y left, z up | R = Rx(roll)·Ry(pitch)·Rz(yaw) |
//! | [`Convention::ZDown`] | x forward, y right, z down (NED, AGARD-AR-144) | R = Rz(yaw)·Ry(pitch)·Rx(roll) |
//!
//! Axes with z up become axes with Y up by (x, y, z) → (x, z, −y), axes with z down by (x, y, z) → (x, −z, y). So the
//! y axis of z up is −Z and the z axis of z down is −Y, and every convention is `Gost` in another order or with other
//! signs:
//!
//! | convention | A |
//! |---|---|
//! | `Zyx` | Ry(yaw)·Rz(−pitch)·Rx(roll) |
//! | `Xyz` | Rx(roll)·Rz(−pitch)·Ry(yaw), the transpose of Ry(−yaw)·Rz(pitch)·Rx(−roll) |
//! | `ZDown` | Ry(−yaw)·Rz(pitch)·Rx(roll) |
//!
//! Where the middle angle is ±90° (gimbal lock) roll and yaw turn about one line; roll is then reported as 0.

use nalgebra::{Matrix3, RealField, UnitQuaternion, Vector3};

use super::pose::Pose;

/// How a pose is written as numbers: order of the turns and direction of the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Convention {
    /// A = Ry(yaw)·Rz(pitch)·Rx(roll), Y up: roll γ about X, yaw ψ about Y, pitch ϑ about Z.
    #[default]
    Gost,
    /// R = Rz(yaw)·Ry(pitch)·Rx(roll), z up.
    Zyx,
    /// R = Rx(roll)·Ry(pitch)·Rz(yaw), z up.
    Xyz,
    /// R = Rz(yaw)·Ry(pitch)·Rx(roll), z down.
    ZDown,
}

/// Three angles, rad; the [`Convention`] says what they mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angles<T> {
    /// Turn about the x axis (γ in `gost`).
    pub roll: T,
    /// Turn about the y axis, in `gost` about Z (ϑ).
    pub pitch: T,
    /// Turn about the z axis, in `gost` about Y (ψ): the upward axis, and the downward one where z is down.
    pub yaw: T,
}

/// Coordinates with Y up of the point or vector `v` given with z up: (x, y, z) → (x, z, −y).
pub fn from_z_up<T: RealField + Copy>(v: Vector3<T>) -> Vector3<T> {
    Vector3::new(v.x, v.z, -v.y)
}

/// Coordinates with z up of the point or vector `v` given with Y up: the inverse of [`from_z_up`].
pub fn to_z_up<T: RealField + Copy>(v: Vector3<T>) -> Vector3<T> {
    Vector3::new(v.x, -v.z, v.y)
}

/// Coordinates with Y up of the point or vector `v` given with z down: (x, y, z) → (x, −z, y).
pub fn from_z_down<T: RealField + Copy>(v: Vector3<T>) -> Vector3<T> {
    Vector3::new(v.x, -v.z, v.y)
}

/// Coordinates with z down of the point or vector `v` given with Y up: the inverse of [`from_z_down`].
pub fn to_z_down<T: RealField + Copy>(v: Vector3<T>) -> Vector3<T> {
    Vector3::new(v.x, v.z, -v.y)
}

impl Convention {
    /// The pose whose position and angles, in this convention and its axes, are given (m, rad).
    pub fn pose<T: RealField + Copy>(self, position: Vector3<T>, angles: Angles<T>) -> Pose<T> {
        let position = match self {
            Self::Gost => position,
            Self::Zyx | Self::Xyz => from_z_up(position),
            Self::ZDown => from_z_down(position),
        };
        Pose {
            position,
            rotation: self.rotation(angles),
        }
    }

    /// Position (m) and angles (rad) of `pose` in this convention and its axes: the inverse of [`Convention::pose`].
    pub fn coordinates<T: RealField + Copy>(self, pose: &Pose<T>) -> (Vector3<T>, Angles<T>) {
        let position = match self {
            Self::Gost => pose.position,
            Self::Zyx | Self::Xyz => to_z_up(pose.position),
            Self::ZDown => to_z_down(pose.position),
        };
        (position, self.angles(&pose.rotation))
    }

    /// The rotation, body to earth with Y up, that `angles` mean in this convention.
    pub fn rotation<T: RealField + Copy>(self, angles: Angles<T>) -> UnitQuaternion<T> {
        let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
        let roll = about(Vector3::x_axis(), angles.roll);
        let pitch = about(Vector3::z_axis(), angles.pitch);
        let yaw = about(Vector3::y_axis(), angles.yaw);
        match self {
            Self::Gost => yaw * pitch * roll,
            Self::Zyx => yaw * pitch.inverse() * roll,
            Self::Xyz => roll * pitch.inverse() * yaw,
            Self::ZDown => yaw.inverse() * pitch * roll,
        }
    }

    /// The angles of `rotation` (body to earth, Y up) in this convention: roll and yaw in −π..=π, pitch in
    /// −π/2..=π/2.
    pub fn angles<T: RealField + Copy>(self, rotation: &UnitQuaternion<T>) -> Angles<T> {
        let a = *rotation.to_rotation_matrix().matrix();
        match self {
            Self::Gost => gost(&a),
            Self::Zyx => {
                let Angles { roll, pitch, yaw } = gost(&a);
                let pitch = -pitch;
                Angles { roll, pitch, yaw }
            }
            Self::Xyz => {
                let Angles { roll, pitch, yaw } = gost(&a.transpose());
                let (roll, yaw) = (-roll, -yaw);
                Angles { roll, pitch, yaw }
            }
            Self::ZDown => {
                let Angles { roll, pitch, yaw } = gost(&a);
                let yaw = -yaw;
                Angles { roll, pitch, yaw }
            }
        }
    }
}

/// The angles of A = Ry(yaw)·Rz(pitch)·Rx(roll). Near ±90° of pitch the yaw is what rounding leaves of it. Roll is
/// therefore taken from Ry(−yaw)·A = Rz(pitch)·Rx(roll), so that the three together are A whatever the yaw is.
fn gost<T: RealField + Copy>(a: &Matrix3<T>) -> Angles<T> {
    let cosine = a.m11.hypot(a.m31);
    let pitch = a.m21.atan2(cosine);
    // The cosine is then too small to tell the other two angles apart.
    if cosine <= T::default_epsilon() * nalgebra::convert(16.0) {
        let (roll, yaw) = (T::zero(), a.m13.atan2(a.m33));
        return Angles { roll, pitch, yaw };
    }
    let yaw = (-a.m31).atan2(a.m11);
    let (sine, cosine) = yaw.sin_cos();
    let roll = (sine * a.m12 + cosine * a.m32).atan2(sine * a.m13 + cosine * a.m33);
    Angles { roll, pitch, yaw }
}
