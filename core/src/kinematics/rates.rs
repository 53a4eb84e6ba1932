//! Velocities and accelerations: of the body from those of the jacks and back, and the body rates.
//!
//! With v the velocity of O and ω the angular velocity, both in the earth frame, d_k the jack, e_k = d_k/l_k and
//! c_k = A·b_k, differentiating l_k² = |d_k|² once and twice gives
//!
//! ```text
//! ḋ_k = v + ω × c_k                    d̈_k = a + α × c_k + ω × (ω × c_k)
//! l̇_k = e_k·ḋ_k = row k of J · (v, ω)
//! l̈_k = e_k·d̈_k + (|ḋ_k|² − l̇_k²)/l_k = row k of J · (a, α) + e_k·(ω × (ω × c_k)) + (|ḋ_k|² − l̇_k²)/l_k
//! ```
//!
//! so that twist and acceleration come from one and the same matrix J; the last two terms of the second line are
//! J̇·(v, ω). Angular velocity in body axes is Aᵀ·ω, and angular acceleration there is Aᵀ·α, since ω turns with
//! itself. Angles and their rates enter only by the formulas of [`body_rates`].

use nalgebra::{Matrix3, RealField, Vector3, Vector6};
use thiserror::Error;

use super::{
    convention::Angles, geometry::Geometry, inverse::jacks, jacobian::jacobian, pose::Pose,
};

/// Velocity of the body, earth frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist<T: RealField + Copy> {
    /// Velocity of O, m/s.
    pub linear: Vector3<T>,
    /// Angular velocity, rad/s.
    pub angular: Vector3<T>,
}

/// Acceleration of the body, earth frame, without gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acceleration<T: RealField + Copy> {
    /// Acceleration of O, m/s².
    pub linear: Vector3<T>,
    /// Angular acceleration, rad/s².
    pub angular: Vector3<T>,
}

/// The Jacobian has no inverse at this pose, so that jack speeds do not determine the movement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "the Jacobian is singular at this pose: jack speeds do not determine the movement of the body"
)]
pub struct SingularPose;

/// Speed l̇_k of each jack, m/s, while the body at `pose` moves with `twist`.
pub fn jack_speeds<T: RealField + Copy>(
    geometry: &Geometry<T>,
    pose: &Pose<T>,
    twist: &Twist<T>,
) -> [T; 6] {
    (jacobian(geometry, pose) * stacked(&twist.linear, &twist.angular)).into()
}

/// Acceleration l̈_k of each jack, m/s², while the body at `pose` moves with `twist` and `acceleration`.
pub fn jack_accelerations<T: RealField + Copy>(
    geometry: &Geometry<T>,
    pose: &Pose<T>,
    twist: &Twist<T>,
    acceleration: &Acceleration<T>,
) -> [T; 6] {
    let linear = jacobian(geometry, pose) * stacked(&acceleration.linear, &acceleration.angular);
    (linear + velocity_terms(geometry, pose, twist)).into()
}

/// The twist of the body at `pose` from the speed of each jack, m/s.
///
/// # Errors
/// [`SingularPose`] where J has no inverse.
pub fn twist<T: RealField + Copy>(
    geometry: &Geometry<T>,
    pose: &Pose<T>,
    jack_speeds: &[T; 6],
) -> Result<Twist<T>, SingularPose> {
    let (linear, angular) = solve(geometry, pose, Vector6::from(*jack_speeds))?;
    Ok(Twist { linear, angular })
}

/// The acceleration of the body at `pose`, moving with `twist`, from the acceleration of each jack, m/s².
///
/// # Errors
/// [`SingularPose`] where J has no inverse.
pub fn acceleration<T: RealField + Copy>(
    geometry: &Geometry<T>,
    pose: &Pose<T>,
    twist: &Twist<T>,
    jack_accelerations: &[T; 6],
) -> Result<Acceleration<T>, SingularPose> {
    let right = Vector6::from(*jack_accelerations) - velocity_terms(geometry, pose, twist);
    let (linear, angular) = solve(geometry, pose, right)?;
    Ok(Acceleration { linear, angular })
}

/// Body rates (ωx, ωy, ωz), rad/s, from `gost` angles, rad, and their rates, rad/s:
///
/// ```text
/// ωx = γ̇ + ψ̇·sin ϑ
/// ωy = ψ̇·cos ϑ·cos γ + ϑ̇·sin γ
/// ωz = −ψ̇·cos ϑ·sin γ + ϑ̇·cos γ
/// ```
pub fn body_rates<T: RealField + Copy>(angles: &Angles<T>, rates: &Angles<T>) -> Vector3<T> {
    rate_matrix(angles) * Vector3::new(rates.roll, rates.yaw, rates.pitch)
}

/// Rates of the `gost` angles, rad/s, from body rates, rad/s: the inverse of [`body_rates`]. `None` in gimbal lock,
/// where the cosine of the pitch is zero.
pub fn angle_rates<T: RealField + Copy>(
    angles: &Angles<T>,
    body_rates: &Vector3<T>,
) -> Option<Angles<T>> {
    let (sin_roll, cos_roll) = angles.roll.sin_cos();
    let (sin_pitch, cos_pitch) = angles.pitch.sin_cos();
    if cos_pitch.abs() <= T::default_epsilon() {
        return None;
    }
    let yaw = (body_rates.y * cos_roll - body_rates.z * sin_roll) / cos_pitch;
    Some(Angles {
        roll: body_rates.x - yaw * sin_pitch,
        pitch: body_rates.y * sin_roll + body_rates.z * cos_roll,
        yaw,
    })
}

/// The matrix of [`body_rates`], with columns for the rates of roll, yaw and pitch.
fn rate_matrix<T: RealField + Copy>(angles: &Angles<T>) -> Matrix3<T> {
    let (sin_roll, cos_roll) = angles.roll.sin_cos();
    let (sin_pitch, cos_pitch) = angles.pitch.sin_cos();
    let (zero, one) = (T::zero(), T::one());
    Matrix3::new(
        one,
        sin_pitch,
        zero,
        zero,
        cos_pitch * cos_roll,
        sin_roll,
        zero,
        -cos_pitch * sin_roll,
        cos_roll,
    )
}

/// J̇·(v, ω): the jacks' accelerations while the twist stays as it is, m/s².
fn velocity_terms<T: RealField + Copy>(
    geometry: &Geometry<T>,
    pose: &Pose<T>,
    twist: &Twist<T>,
) -> Vector6<T> {
    let jacks = jacks(geometry, pose);
    Vector6::from_fn(|k, _| {
        let (length, hinge) = (jacks[k].norm(), pose.rotation * geometry.upper()[k]);
        let direction = jacks[k] / length;
        let swing = twist.angular.cross(&hinge);
        let velocity = twist.linear + swing;
        let speed = direction.dot(&velocity);
        direction.dot(&twist.angular.cross(&swing))
            + (velocity.norm_squared() - speed * speed) / length
    })
}

fn stacked<T: RealField + Copy>(linear: &Vector3<T>, angular: &Vector3<T>) -> Vector6<T> {
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

fn solve<T: RealField + Copy>(
    geometry: &Geometry<T>,
    pose: &Pose<T>,
    right: Vector6<T>,
) -> Result<(Vector3<T>, Vector3<T>), SingularPose> {
    match jacobian(geometry, pose).lu().solve(&right) {
        Some(q) if q.iter().all(T::is_finite) => Ok((
            Vector3::new(q[0], q[1], q[2]),
            Vector3::new(q[3], q[4], q[5]),
        )),
        _ => Err(SingularPose),
    }
}
