//! The mechanism: six jacks between a floor and a platform (Gough-Stewart).
//!
//! A *pose* is the position p of O in the earth frame and the rotation A from body to earth. Jack k goes from its lower
//! hinge a (earth) to its upper hinge b (body):
//!
//! ```text
//! d = p + c − a     c = A·b     l = |d|     e = d / l
//! ```
//!
//! Differentiating d·d = l² once and twice couples the platform's motion to the jacks' motion:
//!
//! ```text
//! l'  = e·p' + (c × e)·ω
//! l'' = e·p'' + (c × e)·ω' + e·(ω × (ω × c)) + (|d'|² − l'²) / l        d' = p' + ω × c
//! ```
//!
//! The rows [e, c × e] form the Jacobian J. Pose (by Newton's method), speeds and accelerations all come from solving
//! with J; nothing is differentiated numerically. ω and ω' are in earth axes here; ω' has the same components in body
//! axes as the derivative of the body rates, because ω × ω = 0.

use thiserror::Error;

use crate::algebra::{Factors, Rotation, Vec3};

/// How closely the lengths of a solved pose must meet the jacks, m.
pub const CLOSURE_M: f64 = 1e-12;
/// Steps of the chord method before Newton's method takes over.
const CHORD_STEPS: usize = 3;
/// Newton's method doubles the number of right digits in each step; after more steps than this it has failed.
const NEWTON_STEPS: usize = 50;

/// Where the platform is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position of O in the earth frame, m.
    pub position_m: Vec3,
    /// Rotation from body to earth.
    pub attitude: Rotation,
}

/// A velocity or an acceleration of the platform, in earth axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twist {
    /// Of O: m/s or m/s².
    pub linear: Vec3,
    /// Of the body: rad/s or rad/s².
    pub angular: Vec3,
}

impl Twist {
    fn from_array([x, y, z, rx, ry, rz]: [f64; 6]) -> Self {
        Self {
            linear: Vec3([x, y, z]),
            angular: Vec3([rx, ry, rz]),
        }
    }
}

impl Pose {
    /// The pose after moving by `step` (m, rad; earth axes), for small steps.
    #[must_use]
    pub fn moved(&self, step: Twist) -> Self {
        Self {
            position_m: self.position_m + step.linear,
            attitude: Rotation::small(step.angular).after(self.attitude),
        }
    }
}

/// Why the platform cannot follow its jacks.
#[derive(Debug, Error, PartialEq)]
pub enum MechanismError {
    /// The jacks do not determine the motion here.
    #[error(
        "the mechanism is in a singular pose: the jacks no longer determine the motion of the platform"
    )]
    Singular,
    /// No pose has these lengths.
    #[error(
        "no pose found for these jacks: lengths are off by up to {residual_m:e} m, limit {CLOSURE_M:e} m"
    )]
    NotClosed {
        /// Largest difference of a length, m.
        residual_m: f64,
    },
}

/// The hinges of a base: nominal or true.
#[derive(Debug, Clone, PartialEq)]
pub struct Mechanism {
    /// Lower hinges in the earth frame, m.
    pub lower: [Vec3; 6],
    /// Upper hinges in the body frame, m.
    pub upper: [Vec3; 6],
}

/// One jack at a pose.
#[derive(Debug, Clone, Copy)]
struct PosedJack {
    /// From O to the upper hinge, earth axes, m.
    arm: Vec3,
    /// Unit vector from the lower to the upper hinge, earth axes.
    direction: Vec3,
    /// Hinge to hinge, m.
    length: f64,
}

/// The mechanism at one pose, ready to solve for motions.
#[derive(Debug, Clone)]
pub struct Linearised {
    jacks: [PosedJack; 6],
    jacobian: Factors<6>,
}

impl Mechanism {
    /// Lengths of the six jacks at a pose, m.
    #[must_use]
    pub fn lengths(&self, pose: &Pose) -> [f64; 6] {
        self.jacks(pose).map(|jack| jack.length)
    }

    /// Speeds of the six jacks for a velocity of the platform, m/s.
    #[must_use]
    pub fn length_rates(&self, pose: &Pose, velocity: &Twist) -> [f64; 6] {
        self.jacks(pose).map(|jack| {
            let [x, y, z, rx, ry, rz] = jack.row();
            Vec3([x, y, z]).dot(velocity.linear) + Vec3([rx, ry, rz]).dot(velocity.angular)
        })
    }

    /// The pose whose jacks have these lengths (m), near `start`, to [`CLOSURE_M`].
    ///
    /// Uses Newton's method on l(pose) = `lengths`, and computes the lengths again from the pose that it returns.
    ///
    /// # Errors
    /// [`MechanismError`] at a singular pose, or when the lengths are not met.
    pub fn solve_pose(&self, lengths: &[f64; 6], start: Pose) -> Result<Pose, MechanismError> {
        let mut pose = start;
        let mut missing = [f64::NAN; 6];
        for _ in 0..NEWTON_STEPS {
            let jacks = self.jacks(&pose);
            missing = std::array::from_fn(|k| lengths[k] - jacks[k].length);
            if missing.iter().all(|m| m.abs() <= CLOSURE_M) {
                return Ok(pose);
            }
            let jacobian =
                Factors::new(jacks.map(|jack| jack.row())).ok_or(MechanismError::Singular)?;
            pose = pose.moved(Twist::from_array(jacobian.solve(missing)));
        }
        Err(MechanismError::NotClosed {
            residual_m: missing.iter().fold(0.0, |max, m| m.abs().max(max)),
        })
    }

    /// The pose whose jacks have these lengths (m), a moment after the pose of `near`, and the mechanism linearised
    /// there. This is a chord method: it uses the Jacobian of the moment before, which hardly differs. It computes only
    /// one set of factors, those of the new pose, which its motions need.
    ///
    /// # Errors
    /// [`MechanismError`] at a singular pose, or when the lengths are not met.
    pub fn follow(
        &self,
        lengths: &[f64; 6],
        start: Pose,
        near: &Linearised,
    ) -> Result<(Pose, Linearised), MechanismError> {
        let mut pose = start;
        for _ in 0..CHORD_STEPS {
            let jacks = self.jacks(&pose);
            let missing: [f64; 6] = std::array::from_fn(|k| lengths[k] - jacks[k].length);
            if missing.iter().all(|m| m.abs() <= CLOSURE_M) {
                return Ok((pose, Linearised::new(jacks)?));
            }
            pose = pose.moved(Twist::from_array(near.jacobian.solve(missing)));
        }
        let pose = self.solve_pose(lengths, pose)?;
        Ok((pose, self.linearised(&pose)?))
    }

    /// Prepares to solve for motions at a pose.
    ///
    /// # Errors
    /// [`MechanismError::Singular`].
    pub fn linearised(&self, pose: &Pose) -> Result<Linearised, MechanismError> {
        Linearised::new(self.jacks(pose))
    }

    fn jacks(&self, pose: &Pose) -> [PosedJack; 6] {
        std::array::from_fn(|k| {
            let arm = pose.attitude.to_earth(self.upper[k]);
            let span = pose.position_m + arm - self.lower[k];
            let length = span.norm();
            PosedJack {
                arm,
                direction: span * (1.0 / length),
                length,
            }
        })
    }
}

impl PosedJack {
    /// The jack's row of the Jacobian.
    fn row(&self) -> [f64; 6] {
        let [x, y, z] = self.direction.0;
        let [rx, ry, rz] = self.arm.cross(self.direction).0;
        [x, y, z, rx, ry, rz]
    }
}

impl Linearised {
    fn new(jacks: [PosedJack; 6]) -> Result<Self, MechanismError> {
        let jacobian =
            Factors::new(jacks.map(|jack| jack.row())).ok_or(MechanismError::Singular)?;
        Ok(Self { jacks, jacobian })
    }

    /// Velocity of the platform from the speeds of the jacks (m/s).
    #[must_use]
    pub fn velocity(&self, rates: &[f64; 6]) -> Twist {
        Twist::from_array(self.jacobian.solve(*rates))
    }

    /// Acceleration of the platform from the speeds (m/s) and accelerations (m/s²) of the jacks, at the velocity
    /// that [`Linearised::velocity`] found for the same speeds.
    #[must_use]
    pub fn acceleration(
        &self,
        velocity: &Twist,
        rates: &[f64; 6],
        accelerations: &[f64; 6],
    ) -> Twist {
        let omega = velocity.angular;
        let driving = std::array::from_fn(|k| {
            let jack = &self.jacks[k];
            let swing = omega.cross(jack.arm);
            let hinge = velocity.linear + swing;
            let centripetal = jack.direction.dot(omega.cross(swing));
            let turning = (hinge.dot(hinge) - rates[k] * rates[k]) / jack.length;
            accelerations[k] - centripetal - turning
        });
        Twist::from_array(self.jacobian.solve(driving))
    }
}
