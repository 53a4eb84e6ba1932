//! Movements through the whole check; `boundaries` has the decisions at their limits.

mod boundaries;
mod jacks;

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
