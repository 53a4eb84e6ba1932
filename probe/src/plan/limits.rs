//! The refusal of movements that the base cannot make or that its jacks cannot hold.
//!
//! A movement is sampled at least as finely as the jack program's rows and finer where it is fast: 64 samples to the
//! period of its fastest sine, 50 to its shortest ramp or fade. What may happen between samples is added before a
//! value is compared with its limit:
//!
//! - length: with A the largest acceleration and h the step, A·h²/2. A smooth length leaves the straight line between
//!   samples by at most A·h²/8; a linear ramp has a kink there, whose jump of speed Δv is seen as at least Δv/2h by
//!   one of its neighbours and whose tip is at most Δv·h/4 off that line;
//! - speed and acceleration: half a hundredth. For a sine, differences and the distance of its peak from a sample make
//!   them too small by (ωh)²·(1/6 + 1/8) = 0.3 % at most; for a smooth step of 50 samples by 0.5 %;
//! - hinge angle: as [`super::hinges`] says; condition number: as [`super::conditioning`] says.

use super::conditioning::{BetterOrder, Conditioning, MAX_CONDITION, better_order, conditioning};
use super::hinges::{HingeUse, Joint, closest};
use super::uses::{Quantity, Use, Uses, uses};
use super::{Plan, Run};
use crate::geometry_file::GeometryFile;

/// Samples to a period, and to a ramp or fade.
const SAMPLES_PER_PERIOD: f64 = 64.0;
const SAMPLES_PER_RAMP: f64 = 50.0;
/// What speed and acceleration may be above their largest sample, relative.
const BETWEEN_SAMPLES: f64 = 0.005;

/// A movement that the base cannot make.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BeyondLimit {
    /// A jack would leave its stroke, or move or accelerate too fast.
    #[error(
        "run {run} leaves what the base can do: at {time_s:.3} s the {quantity} of jack {jack} is {value:.4} {unit}, \
         limit {limit:.4} {unit}; make the movement smaller or slower",
        unit = quantity.unit()
    )]
    Jack {
        /// Name of the run.
        run: String,
        /// The jack, 1 to 6.
        jack: usize,
        /// Time from the start of the program, s.
        time_s: f64,
        /// What is beyond.
        quantity: Quantity,
        /// Its value, what may happen between samples included.
        value: f64,
        /// Its limit.
        limit: f64,
    },
    /// A jack would swing further in a hinge than the hinge turns.
    #[error(
        "run {run} swings a jack too far: at {time_s:.3} s jack {jack} is {angle_deg:.2}° from its direction at home in \
         its {joint}, limit {limit_deg}°; make the movement smaller"
    )]
    Hinge {
        /// Name of the run.
        run: String,
        /// The jack, 1 to 6.
        jack: usize,
        /// Which of its hinges.
        joint: Joint,
        /// Time from the start of the program, s.
        time_s: f64,
        /// Its angle, what may happen between samples included, degrees.
        angle_deg: f64,
        /// Its limit, degrees.
        limit_deg: f64,
    },
    /// The jacks would hardly hold the platform.
    #[error(
        "run {run} comes close to a pose in which the jacks do not hold the platform: at {time_s:.3} s the condition \
         number of the Jacobian may reach {bound:.1}, limit {MAX_CONDITION}; {}",
        advice(*better_order)
    )]
    Condition {
        /// Name of the run.
        run: String,
        /// Time from the start of the program, s.
        time_s: f64,
        /// What the condition number stays below, without unit.
        bound: f64,
        /// How the upper hinges should perhaps be listed.
        better_order: Option<BetterOrder>,
    },
}

impl BeyondLimit {
    /// With the order of the upper hinges that would hold the platform better, where that is what is refused.
    fn with_order(self, better: Option<BetterOrder>) -> Self {
        match self {
            Self::Condition {
                run, time_s, bound, ..
            } => Self::Condition {
                run,
                time_s,
                bound,
                better_order: better,
            },
            other => other,
        }
    }
}

fn advice(order: Option<BetterOrder>) -> String {
    let Some(order) = order else {
        return "make the movement smaller".to_owned();
    };
    let BetterOrder {
        first,
        condition,
        now,
    } = order;
    format!(
        "in the geometry file, lower and upper do not seem to begin with the same jack: if upper began with its hinge \
         {first}, the condition number at home would be {condition:.1} instead of {now:.1}. List both in the order of the \
         jacks, or else make the movement smaller"
    )
}

/// A run that the base can make.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checked {
    /// What it uses of the jacks.
    pub uses: Uses,
    /// The hinge that comes closest to its limit; `None` where the geometry file has no limit of hinges.
    pub hinge: Option<HingeUse>,
    /// How well the jacks hold the platform.
    pub conditioning: Conditioning,
}

/// Checks every run of a plan and returns what each uses, in order.
///
/// # Errors
/// [`BeyondLimit`] for the first run that the base cannot make.
pub fn check(plan: &Plan, geometry: &GeometryFile) -> Result<Vec<Checked>, BeyondLimit> {
    plan.runs
        .iter()
        .map(|run| check_run(run, geometry, step_s(run, plan.period_s)))
        .collect()
}

/// Time between samples of a run, s: the program's period or a whole fraction of it.
#[must_use]
pub fn step_s(run: &Run, period_s: f64) -> f64 {
    let sines = run.sine.iter().flat_map(|sine| {
        [
            1.0 / (sine.frequency_hz * SAMPLES_PER_PERIOD),
            sine.fade_s / SAMPLES_PER_RAMP,
        ]
    });
    let ramps = run
        .ramps
        .iter()
        .map(|ramps| ramps.step_s / SAMPLES_PER_RAMP);
    let multisines = run.multisine.iter().flat_map(|entry| {
        [
            1.0 / (entry.highest_hz() * SAMPLES_PER_PERIOD),
            entry.fade_s / SAMPLES_PER_RAMP,
        ]
    });
    let all = sines.chain(ramps).chain(multisines);
    let finest = all.fold(period_s, f64::min);
    period_s / (period_s / finest).ceil()
}

fn check_run(run: &Run, geometry: &GeometryFile, step_s: f64) -> Result<Checked, BeyondLimit> {
    let uses = uses(run, geometry, step_s);
    jacks_within(&run.name, &uses, step_s, geometry.geometry.length_min_m())?;
    let hinge = closest(run, geometry, step_s);
    if let Some(hinge) = &hinge {
        hinge_within(&run.name, hinge)?;
    }
    let conditioning = conditioning(run, &geometry.geometry);
    condition_within(&run.name, &conditioning)
        .map_err(|refusal| refusal.with_order(better_order(&geometry.geometry)))?;
    Ok(Checked {
        uses,
        hinge,
        conditioning,
    })
}

/// Whether lengths, speeds and accelerations, with what they may reach between samples, keep within their limits.
fn jacks_within(run: &str, uses: &Uses, step_s: f64, shortest_m: f64) -> Result<(), BeyondLimit> {
    let between_m = uses.acceleration.value.abs() * step_s * step_s / 2.0;
    for (quantity, used) in uses.all() {
        let value = highest(quantity, &used, between_m, shortest_m);
        let inside = match quantity {
            Quantity::Length if used.limit == shortest_m => value >= used.limit,
            Quantity::Length => value <= used.limit,
            Quantity::Speed | Quantity::Acceleration => value.abs() <= used.limit,
        };
        if !inside {
            return Err(BeyondLimit::Jack {
                run: run.to_owned(),
                jack: used.jack,
                time_s: used.time_s,
                quantity,
                value,
                limit: used.limit,
            });
        }
    }
    Ok(())
}

fn hinge_within(run: &str, hinge: &HingeUse) -> Result<(), BeyondLimit> {
    if hinge.angle_deg <= hinge.limit_deg {
        return Ok(());
    }
    Err(BeyondLimit::Hinge {
        run: run.to_owned(),
        jack: hinge.jack,
        joint: hinge.joint,
        time_s: hinge.time_s,
        angle_deg: hinge.angle_deg,
        limit_deg: hinge.limit_deg,
    })
}

fn condition_within(run: &str, conditioning: &Conditioning) -> Result<(), BeyondLimit> {
    if conditioning.bound <= MAX_CONDITION {
        return Ok(());
    }
    Err(BeyondLimit::Condition {
        run: run.to_owned(),
        time_s: conditioning.time_s,
        bound: conditioning.bound,
        better_order: None,
    })
}

/// What a value may reach between samples.
fn highest(quantity: Quantity, used: &Use, between_m: f64, shortest_m: f64) -> f64 {
    match quantity {
        Quantity::Length if used.limit == shortest_m => used.value - between_m,
        Quantity::Length => used.value + between_m,
        Quantity::Speed | Quantity::Acceleration => used.value * (1.0 + BETWEEN_SAMPLES),
    }
}

#[cfg(test)]
mod tests;
