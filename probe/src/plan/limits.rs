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
    let between_m = uses.acceleration.value.abs() * step_s * step_s / 2.0;
    let shortest_m = geometry.geometry.length_min_m();
    for (quantity, used) in uses.all() {
        let value = highest(quantity, &used, between_m, shortest_m);
        let outside = match quantity {
            Quantity::Length if used.limit == shortest_m => value < used.limit,
            Quantity::Length => value > used.limit,
            Quantity::Speed | Quantity::Acceleration => value.abs() > used.limit,
        };
        if outside {
            return Err(BeyondLimit::Jack {
                run: run.name.clone(),
                jack: used.jack,
                time_s: used.time_s,
                quantity,
                value,
                limit: used.limit,
            });
        }
    }
    let hinge = closest(run, geometry, step_s);
    if let Some(hinge) = hinge.filter(|hinge| hinge.angle_deg > hinge.limit_deg) {
        return Err(BeyondLimit::Hinge {
            run: run.name.clone(),
            jack: hinge.jack,
            joint: hinge.joint,
            time_s: hinge.time_s,
            angle_deg: hinge.angle_deg,
            limit_deg: hinge.limit_deg,
        });
    }
    let conditioning = conditioning(run, &geometry.geometry);
    if conditioning.bound <= MAX_CONDITION {
        return Ok(Checked {
            uses,
            hinge,
            conditioning,
        });
    }
    Err(BeyondLimit::Condition {
        run: run.name.clone(),
        time_s: conditioning.time_s,
        bound: conditioning.bound,
        better_order: better_order(&geometry.geometry),
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
mod tests {
    use super::*;
    use crate::plan::campaign;

    fn refused(geometry: &GeometryFile, change: impl FnOnce(&mut Plan)) -> BeyondLimit {
        let mut plan = campaign::plan(geometry).unwrap();
        change(&mut plan);
        check(&plan, geometry).unwrap_err()
    }

    fn keep(plan: &mut Plan, name: &str) {
        plan.runs.retain(|run| run.name == name);
    }

    #[test]
    fn a_movement_that_leaves_the_stroke_is_refused_with_jack_time_length_and_limit() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let refusal = refused(&geometry, |plan| {
            keep(plan, "pitch");
            for level in plan.runs[0].ramps[0].levels_deg.iter_mut().flatten() {
                *level *= 2.2;
            }
        });
        let BeyondLimit::Jack {
            run,
            time_s,
            quantity,
            value,
            limit,
            ..
        } = refusal
        else {
            panic!("{refusal}");
        };
        assert_eq!((run.as_str(), quantity), ("pitch", Quantity::Length));
        assert!((4.0..=20.0).contains(&time_s));
        let lengths = 2.10..=3.40;
        assert!(lengths.contains(&limit) && !lengths.contains(&value));
    }

    #[test]
    fn a_jack_that_swings_too_far_is_refused_with_hinge_time_angle_and_limit() {
        let mut geometry = GeometryFile::load("an-74tk-200").unwrap();
        geometry.lower_hinge_angle_max_deg = Some(40.0);
        geometry.upper_hinge_angle_max_deg = Some(40.0);
        let plan = campaign::plan(&geometry).unwrap();
        let angles = |checked: &Checked| checked.hinge.unwrap().angle_deg;
        let checked = check(&plan, &geometry).unwrap();
        let widest = checked.iter().map(angles).fold(0.0, f64::max);
        assert!((15.0..40.0).contains(&widest), "{widest}");
        geometry.upper_hinge_angle_max_deg = Some(12.0);
        let refusal = check(&plan, &geometry).unwrap_err();
        let BeyondLimit::Hinge {
            ref run,
            joint,
            time_s,
            angle_deg,
            limit_deg,
            ..
        } = refusal
        else {
            panic!("{refusal}");
        };
        assert_eq!(
            (run.as_str(), joint, limit_deg),
            ("pitch", Joint::Upper, 12.0)
        );
        assert!(
            (1.0..=32.0).contains(&time_s) && angle_deg > 12.0,
            "{refusal}"
        );
        // A limit of what is used, and of a hair less.
        let run = plan.run("held-out").unwrap();
        let used = closest(run, &geometry, 0.002).unwrap().angle_deg;
        let with = |limit_deg| {
            let mut geometry = geometry.clone();
            geometry.lower_hinge_angle_max_deg = None;
            geometry.upper_hinge_angle_max_deg = Some(limit_deg);
            check_run(run, &geometry, 0.002)
        };
        assert!(with(used + 1e-9).is_ok() && with(used - 1e-3).is_err());
        // The default campaign keeps within nine tenths of a limit that is known beforehand.
        for run in campaign::plan(&geometry).unwrap().runs {
            let used = closest(&run, &geometry, 0.002).unwrap();
            assert!(used.fraction() <= campaign::USABLE, "{} {used:?}", run.name);
        }
    }

    #[test]
    fn a_sine_that_is_zero_in_every_row_of_its_program_is_seen_between_them() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let refusal = refused(&geometry, |plan| {
            keep(plan, "heave");
            plan.period_s = 0.1;
            plan.runs[0].sine[0].frequency_hz = 10.0;
        });
        assert!(refusal.to_string().contains("speed of jack"), "{refusal}");
    }

    #[test]
    fn a_pose_that_the_jacks_hardly_hold_is_refused_although_every_jack_is_within_its_limits() {
        let (_, text) = geometries::PRESETS[2];
        let text = text
            .replace("length_min = 2.10", "length_min = 0.50")
            .replace("length_max = 3.40", "length_max = 9.00");
        let geometry = GeometryFile::parse("an.toml", &text).unwrap();
        // The platform turned by a right angle about the vertical: all six jacks pass by its axis alike.
        let refusal = refused(&geometry, |plan| {
            keep(plan, "yaw-sine");
            plan.runs[0].sine[0].amplitude_deg = Some(89.0);
            plan.runs[0].sine[0].frequency_hz = 0.01;
            plan.runs[0].sine[0].fade_s = 60.0;
        });
        let BeyondLimit::Condition { time_s, bound, .. } = refusal else {
            panic!("{refusal}");
        };
        assert!(bound > MAX_CONDITION && time_s > 0.0);
    }

    #[test]
    fn upper_hinges_that_begin_with_another_jack_are_named_and_right_ones_are_not() {
        for name in crate::geometry_file::preset_names() {
            let geometry = GeometryFile::load(name).unwrap().geometry;
            assert_eq!(better_order(&geometry), None, "{name}");
        }
        let (_, text) = geometries::PRESETS[2];
        let (before, upper) = text.split_once("upper = [").unwrap();
        let first = "  [1.5, 0.0, 0.0],\n";
        // The first hinge goes behind the last.
        let upper = upper.replacen(first, "", 1);
        let upper = upper.replace(",\n]", &format!(",\n{first}]"));
        let text = format!("{before}upper = [{upper}");
        let geometry = GeometryFile::parse("an.toml", &text).unwrap();
        let plan = campaign::plan(&geometry).unwrap();
        let said = check(&plan, &geometry).unwrap_err().to_string();
        assert!(
            said.contains("lower and upper do not seem to begin"),
            "{said}"
        );
        assert!(said.contains("if upper began with its hinge 6"), "{said}");
    }

    #[test]
    fn a_step_is_a_whole_fraction_of_the_period_and_short_enough_for_the_fastest_sine() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let plan = campaign::plan(&geometry).unwrap();
        let mut run = plan.run("held-out").unwrap().clone();
        assert_eq!(step_s(&run, 0.002), 0.002);
        run.sine[2].frequency_hz = 20.0;
        let step = step_s(&run, 0.002);
        assert!(step <= 1.0 / (20.0 * SAMPLES_PER_PERIOD));
        assert!((0.002 / step - (0.002 / step).round()).abs() < 1e-9);
    }
}
