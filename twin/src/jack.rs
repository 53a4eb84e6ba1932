//! The six jacks: each follows its command with a delay and softly, and friction acts when it turns around.
//!
//! ```text
//! x'' = Ω²·(u(t − τ) − x) − 2·ζ·Ω·x' − c·x' / √(x'² + v²)
//! ```
//!
//! x is the displacement from mid-stroke, u the command, Ω the servo's natural frequency, ζ its damping, τ its delay.
//! The last term is dry friction c, smoothed below the creep speed v: it changes its sign when the jack reverses, which
//! is the *turn-around bump* of 2c in the acceleration. At rest it lets the jack creep to its command.
//!
//! The equation is integrated by the classical Runge-Kutta method. x, x' and x'' of a moment are consistent, because
//! x'' is the right-hand side itself.

use std::f64::consts::TAU;

use crate::controller::Controller;
use crate::random::Stream;

/// Natural frequency of a servo, Hz.
pub const FREQUENCY_HZ: [f64; 2] = [4.0, 10.0];
/// Damping of a servo.
pub const DAMPING: [f64; 2] = [0.6, 0.9];
/// Delay of a servo, s.
pub const DELAY_S: [f64; 2] = [0.005, 0.020];
/// Dry friction, as acceleration of the jack, m/s².
const FRICTION_M_S2: [f64; 2] = [0.02, 0.10];
/// Speed below which friction gives way to creep, m/s.
const CREEP_M_S: f64 = 0.002;
/// Spread of the six jacks: a part of the width of a quantity's range, to either side.
const JACK_SPREAD: f64 = 0.05;

/// How one servo answers.
#[derive(Debug, Clone, Copy)]
struct Servo {
    /// Natural frequency, rad/s.
    omega: f64,
    damping: f64,
    delay_s: f64,
    friction_m_s2: f64,
}

/// Displacement from mid-stroke, speed and acceleration of the six jacks: m, m/s, m/s².
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JackMotion {
    /// Displacements, m.
    pub displacement_m: [f64; 6],
    /// Speeds, m/s.
    pub speed_m_s: [f64; 6],
    /// Accelerations, m/s².
    pub acceleration_m_s2: [f64; 6],
}

/// The six jacks and their motion.
#[derive(Debug, Clone)]
pub struct Jacks {
    servos: [Servo; 6],
    displacement_m: [f64; 6],
    speed_m_s: [f64; 6],
    /// The delayed command of each servo at this moment, m.
    command_m: [f64; 6],
}

impl Jacks {
    /// The jacks of a base, at rest at these displacements (m).
    #[must_use]
    pub fn draw(seed: u64, displacement_m: [f64; 6]) -> Self {
        let [frequency, damping, delay, friction] = [
            ("frequency", FREQUENCY_HZ),
            ("damping", DAMPING),
            ("delay", DELAY_S),
            ("friction", FRICTION_M_S2),
        ]
        .map(|(quantity, range)| draw_alike(seed, quantity, range));
        Self {
            servos: std::array::from_fn(|k| Servo {
                omega: TAU * frequency[k],
                damping: damping[k],
                delay_s: delay[k],
                friction_m_s2: friction[k],
            }),
            displacement_m,
            speed_m_s: [0.0; 6],
            command_m: displacement_m,
        }
    }

    /// Moves the jacks from `time_s` on for `step_s`.
    pub fn advance(&mut self, controller: &Controller, time_s: f64, step_s: f64) {
        for (k, servo) in self.servos.iter().enumerate() {
            let told = |ahead_s: f64| controller.command_m(k, time_s + ahead_s - servo.delay_s);
            let command = [self.command_m[k], told(0.5 * step_s), told(step_s)];
            let from = (self.displacement_m[k], self.speed_m_s[k]);
            let to = servo.runge_kutta(from, command, step_s);
            (self.displacement_m[k], self.speed_m_s[k]) = to;
            self.command_m[k] = command[2];
        }
    }

    /// Motion of the jacks at the end of the last step.
    #[must_use]
    pub fn motion(&self) -> JackMotion {
        JackMotion {
            displacement_m: self.displacement_m,
            speed_m_s: self.speed_m_s,
            acceleration_m_s2: std::array::from_fn(|k| {
                let (x, v) = (self.displacement_m[k], self.speed_m_s[k]);
                self.servos[k].acceleration(x, v, self.command_m[k])
            }),
        }
    }
}

/// Six values in a range, slightly different from each other.
fn draw_alike(seed: u64, quantity: &str, [low, high]: [f64; 2]) -> [f64; 6] {
    let spread = JACK_SPREAD * (high - low);
    let common =
        Stream::new(seed, &format!("servo.{quantity}")).uniform(low + spread, high - spread);
    std::array::from_fn(|k| {
        common + Stream::new(seed, &format!("servo.{}.{quantity}", k + 1)).within(spread)
    })
}

impl Servo {
    fn acceleration(&self, x: f64, v: f64, command: f64) -> f64 {
        let friction = self.friction_m_s2 * v / (v * v + CREEP_M_S * CREEP_M_S).sqrt();
        self.omega * (self.omega * (command - x) - 2.0 * self.damping * v) - friction
    }

    fn runge_kutta(&self, (x, v): (f64, f64), command: [f64; 3], h: f64) -> (f64, f64) {
        let [from, mid, to] = command;
        let (x1, a1) = (v, self.acceleration(x, v, from));
        let x2 = v + 0.5 * h * a1;
        let a2 = self.acceleration(x + 0.5 * h * x1, x2, mid);
        let x3 = v + 0.5 * h * a2;
        let a3 = self.acceleration(x + 0.5 * h * x2, x3, mid);
        let x4 = v + h * a3;
        let a4 = self.acceleration(x + h * x3, x4, to);
        (
            x + h / 6.0 * (x1 + 2.0 * (x2 + x3) + x4),
            v + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4),
        )
    }
}
