//! The true motion of the platform at one moment, and the quantities that sensors on it feel.
//!
//! An accelerometer feels specific force: the acceleration of its place minus gravity. With O at p, the sensor block at
//! r from O (body axes) and the body rates ω,
//!
//! ```text
//! f = Aᵀ(p'' + g·up) + ω' × r + ω × (ω × r)
//! ```
//!
//! so that at rest and level f = (0, +g, 0): up is positive.

use crate::algebra::Vec3;
use crate::jack::JackMotion;
use crate::mechanism::{Pose, Twist};

/// Up, in the earth frame.
const UP: Vec3 = Vec3([0.0, 1.0, 0.0]);

/// Where the sensors are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The sensor block from O, body axes, m.
    pub lever_arm_m: Vec3,
    /// Local gravity g, m/s².
    pub gravity_m_s2: f64,
}

/// What the sensors feel, in body axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Felt {
    /// Specific force at the sensor block, m/s².
    pub specific_force: Vec3,
    /// Angular acceleration, rad/s².
    pub angular_acceleration: Vec3,
    /// Angular rate, rad/s.
    pub angular_rate: Vec3,
}

impl Felt {
    /// The quantities felt at a place on a platform with this motion.
    #[must_use]
    pub fn at(pose: &Pose, velocity: &Twist, acceleration: &Twist, place: &Place) -> Self {
        let lever_arm_m = place.lever_arm_m;
        let to_body = |earth: Vec3| pose.attitude.to_body(earth);
        let rate = to_body(velocity.angular);
        let turning = to_body(acceleration.angular);
        let at_origin = to_body(acceleration.linear + UP * place.gravity_m_s2);
        Self {
            specific_force: at_origin
                + turning.cross(lever_arm_m)
                + rate.cross(rate.cross(lever_arm_m)),
            angular_acceleration: turning,
            angular_rate: rate,
        }
    }

    /// The three vectors in the order of the triads.
    #[must_use]
    pub fn triads(&self) -> [Vec3; 3] {
        [
            self.specific_force,
            self.angular_acceleration,
            self.angular_rate,
        ]
    }
}

/// The truth of one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// True time since the board was connected, s.
    pub time_s: f64,
    /// The jacks, vibration included.
    pub jacks: JackMotion,
    /// Where the platform is.
    pub pose: Pose,
    /// Its velocity, earth axes.
    pub velocity: Twist,
    /// Its acceleration, earth axes.
    pub acceleration: Twist,
    /// What the sensors feel.
    pub felt: Felt,
}
