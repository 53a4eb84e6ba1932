//! Which runs a plan must have, checked before anything moves.

use hexsense_core::excitation::{DegreeOfFreedom, Signal};

use super::{Plan, Purpose, Run};

/// Runs without which nothing can be computed, each with what to do.
#[must_use]
pub fn missing(runs: &[&Run]) -> Vec<String> {
    let mut missing = Vec::new();
    if !runs.iter().any(|run| run.rest_s.is_some()) {
        missing.push("no offset is determined: nothing rests at home; add a zero run".to_owned());
    }
    for (channel, freedom) in [
        ("ax", DegreeOfFreedom::Pitch),
        ("az", DegreeOfFreedom::Roll),
    ] {
        if !runs.iter().any(|run| ramps_of(run, freedom)) {
            let name = freedom.name();
            missing.push(format!(
                "{channel} is not determined: nothing is held in {name}; add ramps and holds in {name}"
            ));
        }
    }
    for (axis, freedom) in [
        ("x", DegreeOfFreedom::Roll),
        ("y", DegreeOfFreedom::Yaw),
        ("z", DegreeOfFreedom::Pitch),
    ] {
        if !runs.iter().any(|run| sine_of(run, freedom)) {
            missing.push(format!(
                "e{axis} and w{axis} are not determined: nothing turns about {}; add a {} sine",
                axis.to_uppercase(),
                freedom.name()
            ));
        }
    }
    missing
}

/// The same for a campaign that shall be recorded: its fit takes a heave sine too.
#[must_use]
pub fn missing_to_calibrate(plan: &Plan) -> Vec<String> {
    let runs: Vec<&Run> = plan.runs_to(Purpose::Calibrate).collect();
    let mut missing = missing(&runs);
    if !runs.iter().any(|run| sine_of(run, DegreeOfFreedom::Heave)) {
        missing.push(
            "ay is hardly determined: gravity barely changes along it; add a heave sine".to_owned(),
        );
    }
    missing
}

/// Whether a run moves this degree of freedom alone by a sine.
#[must_use]
pub fn sine_of(run: &Run, freedom: DegreeOfFreedom) -> bool {
    run.single_sine()
        .is_some_and(|(moved, sine)| moved == freedom && sine.amplitude > 0.0)
}

/// Whether a run moves this degree of freedom alone by ramps and holds.
fn ramps_of(run: &Run, freedom: DegreeOfFreedom) -> bool {
    match run.program().signals.as_slice() {
        [(moved, Signal::Ramps(ramps))] => {
            *moved == freedom && ramps.levels.iter().any(|level| *level != 0.0)
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests;
