//! How much of stroke, speed and acceleration a movement uses, and the refusal of one that uses too much.
//!
//! Lengths come from inverse kinematics at every row of the program, speed and acceleration from differences of
//! neighbouring rows,
//!
//! ```text
//! v_i = (l_{i+1} − l_{i−1}) / 2h        a_i = (l_{i+1} − 2 l_i + l_{i−1}) / h²
//! ```
//!
//! *Use* is a fraction of what there is: of the way from home to the end of the stroke, of the highest speed, of the
//! highest acceleration. A use of 1 is the limit itself.

use std::fmt;

use hexsense::kinematics::{inverse, jacobian, jacobian::condition};

use super::{Plan, Run};
use crate::geometry_file::GeometryFile;

/// What is limited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Hinge-to-hinge length, m.
    Length,
    /// Speed of a jack, m/s.
    Speed,
    /// Acceleration of a jack, m/s².
    Acceleration,
}

impl Quantity {
    /// Unit of values and limits.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Length => "m",
            Self::Speed => "m/s",
            Self::Acceleration => "m/s²",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Length => "length",
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
        })
    }
}

/// The place where a movement comes closest to a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Use {
    /// The jack, 1 to 6.
    pub jack: usize,
    /// Time from the start of the program, s.
    pub time_s: f64,
    /// Length, speed or acceleration there: m, m/s, m/s².
    pub value: f64,
    /// The limit that it comes closest to; infinite where the geometry file names none.
    pub limit: f64,
    /// Fraction of the room that is used; 1 at the limit.
    pub fraction: f64,
}

impl Use {
    const NONE: Self = Self {
        jack: 1,
        time_s: 0.0,
        value: 0.0,
        limit: f64::INFINITY,
        fraction: 0.0,
    };

    fn or_worse(&mut self, other: Self) {
        if other.fraction > self.fraction
            || (other.limit.is_infinite() && other.value.abs() > self.value.abs())
        {
            *self = other;
        }
    }
}

/// How close a movement comes to the limits of the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uses {
    /// Of the way from home to the nearer end of the stroke.
    pub length: Use,
    /// Of the highest speed.
    pub speed: Use,
    /// Of the highest acceleration.
    pub acceleration: Use,
    /// Largest condition number of the Jacobian on the way, metres and radians as units.
    pub condition: f64,
}

impl Uses {
    /// The largest fraction of any limit.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.length
            .fraction
            .max(self.speed.fraction)
            .max(self.acceleration.fraction)
    }
}

/// A movement that the base cannot make.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "run {run} leaves what the base can do: at {time_s:.3} s the {quantity} of jack {jack} is {value:.4} {unit}, \
     limit {limit:.4} {unit}; make the movement smaller or slower",
    unit = quantity.unit()
)]
pub struct BeyondLimit {
    /// Name of the run.
    pub run: String,
    /// The jack, 1 to 6.
    pub jack: usize,
    /// Time from the start of the program, s.
    pub time_s: f64,
    /// What is beyond.
    pub quantity: Quantity,
    /// Its value.
    pub value: f64,
    /// Its limit.
    pub limit: f64,
}

/// Checks every run of a plan and returns what each uses, in order.
///
/// # Errors
/// [`BeyondLimit`] for the first run that the base cannot make.
pub fn check(plan: &Plan, geometry: &GeometryFile) -> Result<Vec<Uses>, BeyondLimit> {
    plan.runs
        .iter()
        .map(|run| check_run(run, geometry, plan.period_s))
        .collect()
}

fn check_run(run: &Run, geometry: &GeometryFile, period_s: f64) -> Result<Uses, BeyondLimit> {
    let uses = uses(run, geometry, period_s);
    for (quantity, used) in [
        (Quantity::Length, uses.length),
        (Quantity::Speed, uses.speed),
        (Quantity::Acceleration, uses.acceleration),
    ] {
        if used.fraction > 1.0 {
            return Err(BeyondLimit {
                run: run.name.clone(),
                jack: used.jack,
                time_s: used.time_s,
                quantity,
                value: used.value,
                limit: used.limit,
            });
        }
    }
    Ok(uses)
}

/// What one run uses, sampled every `period_s`.
#[must_use]
pub fn uses(run: &Run, geometry: &GeometryFile, period_s: f64) -> Uses {
    let lengths = lengths(run, geometry, period_s);
    let home = inverse(&geometry.geometry, &geometry.geometry.home());
    let (shortest, longest) = (
        geometry.geometry.length_min_m(),
        geometry.geometry.length_max_m(),
    );
    let speed_max = geometry.speed_max_m_s.unwrap_or(f64::INFINITY);
    let acceleration_max = geometry.acceleration_max_m_s2.unwrap_or(f64::INFINITY);
    let mut uses = Uses {
        length: Use::NONE,
        speed: Use::NONE,
        acceleration: Use::NONE,
        condition: 0.0,
    };
    for (row, now) in lengths.iter().enumerate() {
        let before = &lengths[row.saturating_sub(1)];
        let after = lengths.get(row + 1).unwrap_or(now);
        for jack in 0..6 {
            let place = |value, limit, fraction| Use {
                jack: jack + 1,
                time_s: row as f64 * period_s,
                value,
                limit,
                fraction,
            };
            let limit = if now[jack] < home[jack] {
                shortest
            } else {
                longest
            };
            let way = (now[jack] - home[jack]).abs();
            let fraction = if way > 0.0 {
                way / (limit - home[jack]).abs()
            } else {
                0.0
            };
            uses.length.or_worse(place(now[jack], limit, fraction));
            let speed = (after[jack] - before[jack]) / (2.0 * period_s);
            uses.speed
                .or_worse(place(speed, speed_max, speed.abs() / speed_max));
            let acceleration =
                (after[jack] - 2.0 * now[jack] + before[jack]) / (period_s * period_s);
            uses.acceleration.or_worse(place(
                acceleration,
                acceleration_max,
                acceleration.abs() / acceleration_max,
            ));
        }
    }
    uses.condition = worst_condition(run, geometry);
    uses
}

/// Lengths of the six jacks at every row, from the start of the program to its end.
fn lengths(run: &Run, geometry: &GeometryFile, period_s: f64) -> Vec<[f64; 6]> {
    let program = run.program();
    let rows = (program.duration_s() / period_s).ceil() as usize;
    (0..=rows)
        .map(|row| {
            inverse(
                &geometry.geometry,
                &program.pose(&geometry.geometry, row as f64 * period_s),
            )
        })
        .collect()
}

fn worst_condition(run: &Run, geometry: &GeometryFile) -> f64 {
    const PERIOD_S: f64 = 0.1;
    let program = run.program();
    let rows = (program.duration_s() / PERIOD_S).ceil() as usize;
    (0..=rows)
        .map(|row| program.pose(&geometry.geometry, row as f64 * PERIOD_S))
        .map(|pose| condition(&jacobian(&geometry.geometry, &pose)))
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::campaign;

    #[test]
    fn a_movement_that_leaves_the_stroke_is_refused_with_jack_time_length_and_limit() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let plan = campaign::plan(&geometry).unwrap();
        let text = plan.to_toml().replace("20.0", "44.0");
        let refusal = check(&Plan::parse("plan.toml", &text).unwrap(), &geometry).unwrap_err();
        assert_eq!(
            (refusal.run.as_str(), refusal.quantity),
            ("pitch", Quantity::Length)
        );
        assert!((4.0..=20.0).contains(&refusal.time_s));
        let lengths = 2.10..=3.40;
        assert!(lengths.contains(&refusal.limit) && !lengths.contains(&refusal.value));
    }

    #[test]
    fn speed_and_acceleration_of_a_heave_are_those_of_the_jacks() {
        // At home the jacks' share of a small heave is h/l, the cosine of their slope.
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let mut run = campaign::plan(&geometry)
            .unwrap()
            .run("heave")
            .unwrap()
            .clone();
        run.sine[0].amplitude_m = Some(0.001);
        run.sine[0].fade_s = 60.0;
        let home = geometry.geometry.home();
        let slope = home.position.y / inverse(&geometry.geometry, &home)[0];
        let omega = std::f64::consts::TAU * 0.5;
        let uses = uses(&run, &geometry, 0.002);
        assert!((uses.speed.value.abs() / (0.001 * omega * slope) - 1.0).abs() < 1e-3);
        assert!(
            (uses.acceleration.value.abs() / (0.001 * omega * omega * slope) - 1.0).abs() < 1e-3
        );
    }
}
