//! Angles and axes at the edges: three conventions that people read and write.
//!
//! The core keeps a pose as position and quaternion in the frames of the body and the earth with Y up. Files, tables
//! and command lines use angles, and the same three numbers mean different rotations:
//!
//! | convention | axes of its coordinates | rotation, body to earth |
//! |---|---|---|
//! | [`Convention::Gost`] | X forward, Y up, Z right (GOST 20058-80) | A = Ry(yaw)·Rz(pitch)·Rx(roll) |
//! | [`Convention::Zyx`] | z up | R = Rz(yaw)·Ry(pitch)·Rx(roll) |
//! | [`Convention::Xyz`] | z up | R = Rx(roll)·Ry(pitch)·Rz(yaw) |
//!
//! Axes with z up become axes with Y up by C: (x, y, z) → (x, z, −y), and a rotation by A = C·R·Cᵀ. With this,
//! `Zyx` is `Gost` with the sign of the pitch reversed; `Xyz` is a different rotation altogether: at 10° angles the
//! two are 3e-2 apart.
//!
//! Where the middle angle is ±90° (gimbal lock) roll and yaw turn about one line; roll is then reported as 0.

use nalgebra::{Matrix3, RealField, Rotation3, UnitQuaternion, Vector3};

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
}

/// Three angles, rad; the [`Convention`] says what they mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angles<T> {
    /// Turn about the x axis (γ in `gost`).
    pub roll: T,
    /// Turn about the y axis in `zyx` and `xyz`, about Z (ϑ) in `gost`.
    pub pitch: T,
    /// Turn about the upward axis (ψ in `gost`).
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

impl Convention {
    /// The pose whose position and angles, in this convention and its axes, are given (m, rad).
    pub fn pose<T: RealField + Copy>(self, position: Vector3<T>, angles: Angles<T>) -> Pose<T> {
        let position = match self {
            Self::Gost => position,
            Self::Zyx | Self::Xyz => from_z_up(position),
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
        };
        (position, self.angles(&pose.rotation))
    }

    /// The rotation, body to earth with Y up, that `angles` mean in this convention.
    pub fn rotation<T: RealField + Copy>(self, angles: Angles<T>) -> UnitQuaternion<T> {
        let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
        // The axes x, y, z of a z-up frame are X, −Z, Y of the frame with Y up.
        let roll = about(Vector3::x_axis(), angles.roll);
        let pitch = about(Vector3::z_axis(), angles.pitch);
        let yaw = about(Vector3::y_axis(), angles.yaw);
        match self {
            Self::Gost => yaw * pitch * roll,
            Self::Zyx => yaw * pitch.inverse() * roll,
            Self::Xyz => roll * pitch.inverse() * yaw,
        }
    }

    /// The angles of `rotation` (body to earth, Y up) in this convention: roll and yaw in −π..=π, pitch in
    /// −π/2..=π/2.
    pub fn angles<T: RealField + Copy>(self, rotation: &UnitQuaternion<T>) -> Angles<T> {
        let a = rotation.to_rotation_matrix();
        match self {
            Self::Gost => gost_angles(a.matrix()),
            Self::Zyx => zyx_angles(z_up(&a).matrix()),
            Self::Xyz => xyz_angles(z_up(&a).matrix()),
        }
    }
}

/// R = Cᵀ·A·C: the same rotation in axes with z up.
fn z_up<T: RealField + Copy>(a: &Rotation3<T>) -> Rotation3<T> {
    let columns = [Vector3::x(), Vector3::y(), Vector3::z()].map(|e| to_z_up(a * from_z_up(e)));
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns))
}

/// Whether the cosine of the middle angle is too small to tell the outer two angles apart.
fn locked<T: RealField + Copy>(cosine: T) -> bool {
    cosine <= T::default_epsilon() * nalgebra::convert(16.0)
}

fn gost_angles<T: RealField + Copy>(a: &Matrix3<T>) -> Angles<T> {
    let cosine = a.m11.hypot(a.m31);
    let pitch = a.m21.atan2(cosine);
    let (roll, yaw) = if locked(cosine) {
        (T::zero(), a.m13.atan2(a.m33))
    } else {
        ((-a.m23).atan2(a.m22), (-a.m31).atan2(a.m11))
    };
    Angles { roll, pitch, yaw }
}

fn zyx_angles<T: RealField + Copy>(r: &Matrix3<T>) -> Angles<T> {
    let cosine = r.m11.hypot(r.m21);
    let pitch = (-r.m31).atan2(cosine);
    let (roll, yaw) = if locked(cosine) {
        (T::zero(), (-r.m12).atan2(r.m22))
    } else {
        (r.m32.atan2(r.m33), r.m21.atan2(r.m11))
    };
    Angles { roll, pitch, yaw }
}

fn xyz_angles<T: RealField + Copy>(r: &Matrix3<T>) -> Angles<T> {
    let cosine = r.m11.hypot(r.m12);
    let pitch = r.m13.atan2(cosine);
    let (roll, yaw) = if locked(cosine) {
        (T::zero(), r.m21.atan2(r.m22))
    } else {
        ((-r.m23).atan2(r.m33), (-r.m12).atan2(r.m11))
    };
    Angles { roll, pitch, yaw }
}
