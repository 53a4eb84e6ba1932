//! The movements of the method, each as large as its default or as the base allows, whichever is smaller.
//!
//! | run | movement | gives |
//! |---|---|---|
//! | `zero` | 10 s at home | offsets |
//! | `pitch`, `roll` | ramps and holds, 8 Δt with Δt = 4 s, up to ±20° | accelerometers, from gravity |
//! | `heave` | sine of 0.5 Hz, up to 0.25 m | ay, where gravity hardly changes |
//! | `roll-sine`, `yaw-sine`, `pitch-sine` | sine of 0.5 Hz, up to 10° | angular accelerations and rates |
//! | `held-out` | six sines at once, all different | nothing: coefficients are judged by it |
//!
//! A movement uses at most nine tenths of stroke, speed, acceleration and hinge angle.

use hexsense_core::excitation::{DegreeOfFreedom, Signal};

use super::hinges::closest;
use super::uses::uses;
use super::{Freedom, Plan, Purpose, RampsEntry, Run, Shape, SineEntry};
use crate::files;
use crate::geometry_file::GeometryFile;

/// Period of the rows of jack programs, s.
pub const PERIOD_S: f64 = 0.002;
/// Fraction of any limit that a movement of the default campaign may use.
pub const USABLE: f64 = 0.9;
/// Rest at home for the offsets, s.
const ZERO_S: f64 = 10.0;
/// Subinterval of ramps and holds, s: long enough for a hold to settle and be averaged.
const RAMP_STEP_S: f64 = 4.0;
const TILT_DEG: f64 = 20.0;
/// Frequency of the sine runs: high enough for a clear angular acceleration, low enough for the servos to follow.
const SINE_HZ: f64 = 0.5;
const HEAVE_M: f64 = 0.25;
const SINE_DEG: f64 = 10.0;
const SETTLE_PERIODS: f64 = 2.0;
const ESTIMATE_PERIODS: f64 = 3.0;

/// Sines of the held-out movement. Translations: amplitude, m. Rotations: angular acceleration, rad/s² rms.
const HELD_OUT: [(Freedom, f64, f64); 6] = [
    (Freedom::Surge, 0.37, 0.05),
    (Freedom::Heave, 0.53, 0.08),
    (Freedom::Sway, 0.43, 0.05),
    (Freedom::Roll, 0.83, 0.7),
    (Freedom::Yaw, 0.97, 0.7),
    (Freedom::Pitch, 0.89, 0.7),
];
const HELD_OUT_FADE_S: f64 = 3.0;
const HELD_OUT_S: f64 = 20.0;

/// No room to move.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "run {run} finds no room to move at home: jack {jack} is {length_m:.4} m long there and the stroke is \
     {length_min_m} m to {length_max_m} m; change home_height in the geometry file"
)]
pub struct NoRoom {
    /// Name of the run.
    pub run: String,
    /// The jack, 1 to 6.
    pub jack: usize,
    /// Its length, m.
    pub length_m: f64,
    /// Shortest length, m.
    pub length_min_m: f64,
    /// Greatest length, m.
    pub length_max_m: f64,
}

/// The default campaign for a base.
///
/// # Errors
/// [`NoRoom`] when home is so close to an end of the stroke that nothing can move.
pub fn plan(geometry: &GeometryFile) -> Result<Plan, NoRoom> {
    let mut runs = vec![Run {
        name: "zero".to_owned(),
        purpose: Purpose::Calibrate,
        rest_s: Some(ZERO_S),
        ramps: Vec::new(),
        sine: Vec::new(),
        multisine: None,
    }];
    for template in [
        tilts("pitch", Freedom::Pitch),
        tilts("roll", Freedom::Roll),
        sine("heave", Freedom::Heave, HEAVE_M),
        sine("roll-sine", Freedom::Roll, SINE_DEG),
        sine("yaw-sine", Freedom::Yaw, SINE_DEG),
        sine("pitch-sine", Freedom::Pitch, SINE_DEG),
        held_out(),
    ] {
        runs.push(largest(&template, geometry)?);
    }
    Ok(Plan {
        geometry: geometry.name.clone(),
        geometry_sha256: files::hex(&geometry.hash),
        period_s: PERIOD_S,
        runs,
    })
}

fn moving(name: &str, purpose: Purpose, ramps: Vec<RampsEntry>, sine: Vec<SineEntry>) -> Run {
    Run {
        name: name.to_owned(),
        purpose,
        rest_s: None,
        ramps,
        sine,
        multisine: None,
    }
}

/// Up, hold, down, hold, down below, hold, back, hold.
fn tilts(name: &str, freedom: Freedom) -> Run {
    let levels = [1.0, 1.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0].map(|level| level * TILT_DEG);
    let entry = RampsEntry {
        freedom,
        levels_deg: Some(levels.to_vec()),
        levels_m: None,
        step_s: RAMP_STEP_S,
        shape: Shape::JerkLimited,
    };
    moving(name, Purpose::Calibrate, vec![entry], Vec::new())
}

/// One period to fade in, some to settle, some to estimate, one to fade out.
fn sine(name: &str, freedom: Freedom, amplitude: f64) -> Run {
    let entry = SineEntry {
        fade_s: 1.0 / SINE_HZ,
        settle_s: SETTLE_PERIODS / SINE_HZ,
        estimate_s: ESTIMATE_PERIODS / SINE_HZ,
        ..sine_entry(freedom, SINE_HZ, amplitude)
    };
    moving(name, Purpose::Calibrate, Vec::new(), vec![entry])
}

fn held_out() -> Run {
    let entries = HELD_OUT.map(|(freedom, frequency_hz, size)| {
        let omega = std::f64::consts::TAU * frequency_hz;
        let amplitude = match freedom {
            Freedom::Surge | Freedom::Heave | Freedom::Sway => size,
            _ => (size * std::f64::consts::SQRT_2 / (omega * omega)).to_degrees(),
        };
        sine_entry(freedom, frequency_hz, amplitude)
    });
    moving("held-out", Purpose::Verify, Vec::new(), entries.to_vec())
}

/// A sine of the held-out movement; `amplitude` in m or degrees.
fn sine_entry(freedom: Freedom, frequency_hz: f64, amplitude: f64) -> SineEntry {
    let rotation = DegreeOfFreedom::from(freedom).is_rotation();
    SineEntry {
        freedom,
        amplitude_deg: rotation.then_some(amplitude),
        amplitude_m: (!rotation).then_some(amplitude),
        frequency_hz,
        fade_s: HELD_OUT_FADE_S,
        settle_s: 0.0,
        estimate_s: HELD_OUT_S,
    }
}

/// The template, made smaller until no more than [`USABLE`] of any limit is used.
fn largest(template: &Run, geometry: &GeometryFile) -> Result<Run, NoRoom> {
    const STEPS: u32 = 12;
    let fits = |run: &Run| {
        let hinge = closest(run, geometry, PERIOD_S);
        uses(run, geometry, PERIOD_S).worst() <= USABLE
            && hinge.is_none_or(|hinge| hinge.fraction() <= USABLE)
    };
    let whole = scaled(template, 1.0);
    if fits(&whole) {
        return Ok(whole);
    }
    let (mut possible, mut impossible) = (0.0, 1.0);
    for _ in 0..STEPS {
        let middle = 0.5 * (possible + impossible);
        *(if fits(&scaled(template, middle)) {
            &mut possible
        } else {
            &mut impossible
        }) = middle;
    }
    let run = scaled(template, possible);
    let still = run
        .program()
        .signals
        .iter()
        .all(|(_, signal)| is_still(signal));
    if still {
        let used = uses(&scaled(template, impossible), geometry, PERIOD_S).length;
        return Err(NoRoom {
            run: template.name.clone(),
            jack: used.jack,
            length_m: used.value,
            length_min_m: geometry.geometry.length_min_m(),
            length_max_m: geometry.geometry.length_max_m(),
        });
    }
    Ok(run)
}

fn is_still(signal: &Signal) -> bool {
    match signal {
        Signal::Ramps(ramps) => ramps.levels.iter().all(|level| *level == 0.0),
        Signal::Sine(sine) => sine.amplitude == 0.0,
        Signal::Multisine(multisine) => multisine.lines().iter().all(|line| line.amplitude == 0.0),
    }
}

/// The template with every amplitude times `factor`, rounded down to 0.01° or 0.1 mm.
fn scaled(template: &Run, factor: f64) -> Run {
    // A product that is a hair below a whole step is that step.
    let down =
        |value: f64, steps: f64| (value * factor * steps + value.signum() * 1e-9).trunc() / steps;
    let mut run = template.clone();
    for entry in &mut run.ramps {
        entry
            .levels_deg
            .iter_mut()
            .flatten()
            .for_each(|level| *level = down(*level, 100.0));
        entry
            .levels_m
            .iter_mut()
            .flatten()
            .for_each(|level| *level = down(*level, 1e4));
    }
    for entry in &mut run.sine {
        entry.amplitude_deg = entry.amplitude_deg.map(|amplitude| down(amplitude, 100.0));
        entry.amplitude_m = entry.amplitude_m.map(|amplitude| down(amplitude, 1e4));
    }
    run
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry_file::preset_names;
    use crate::plan::limits::check;

    #[test]
    fn a_base_at_the_end_of_its_stroke_has_no_room() {
        let (_, text) = geometries::PRESETS[2];
        let geometry = GeometryFile::parse("an.toml", text).unwrap();
        let longest =
            hexsense_core::kinematics::inverse(&geometry.geometry, &geometry.geometry.home());
        let text = text.replace(
            "length_max = 3.40",
            &format!("length_max = {}", longest[0] + 1e-5),
        );
        let geometry = GeometryFile::parse("an.toml", &text).unwrap();
        assert_eq!(plan(&geometry).unwrap_err().run, "pitch");
    }

    #[test]
    fn every_preset_has_a_campaign_within_nine_tenths_of_its_limits_that_survives_its_file() {
        for name in preset_names() {
            let geometry = GeometryFile::load(name).unwrap();
            let plan = plan(&geometry).unwrap();
            let read = Plan::parse("plan.toml", &plan.to_toml()).unwrap();
            assert_eq!(read, plan);
            for (run, checked) in plan.runs.iter().zip(check(&plan, &geometry).unwrap()) {
                assert!(checked.uses.worst() <= USABLE, "{name} {}", run.name);
            }
        }
    }
}
