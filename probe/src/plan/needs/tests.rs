use super::*;
use crate::geometry_file::GeometryFile;
use crate::plan::campaign;

/// What is missing in the default campaign after a change.
fn missing_after(change: impl FnOnce(&mut Plan)) -> Vec<String> {
    let geometry = GeometryFile::load("an-74tk-200").unwrap();
    let mut plan = campaign::plan(&geometry).unwrap();
    change(&mut plan);
    missing_to_calibrate(&plan)
}

fn run<'a>(plan: &'a mut Plan, name: &str) -> &'a mut Run {
    plan.runs.iter_mut().find(|run| run.name == name).unwrap()
}

const NEEDED: [(&str, &str); 7] = [
    ("zero", "no offset is determined"),
    ("pitch", "ax is not determined"),
    ("roll", "az is not determined"),
    ("heave", "ay is hardly determined"),
    ("roll-sine", "ex and wx are not determined"),
    ("yaw-sine", "ey and wy are not determined"),
    ("pitch-sine", "ez and wz are not determined"),
];

#[test]
fn each_run_that_is_left_out_or_only_verifies_is_missed_alone() {
    assert_eq!(missing_after(|_| {}), [""; 0]);
    for (name, channels) in NEEDED {
        let left_out = missing_after(|plan| plan.runs.retain(|run| run.name != name));
        let verifies = missing_after(|plan| run(plan, name).purpose = Purpose::Verify);
        for missing in [left_out, verifies] {
            let [only] = missing.as_slice() else {
                panic!("{name}: {missing:?}");
            };
            assert!(only.starts_with(channels), "{name}: {only}");
        }
    }
    let held_out = missing_after(|plan| plan.runs.retain(|run| run.name != "held-out"));
    assert_eq!(held_out, [""; 0], "nothing is fitted to it");
}

#[test]
fn a_sine_moves_when_its_amplitude_is_above_zero() {
    for (name, channels) in NEEDED.into_iter().skip(3) {
        let with = |amplitude: f64| {
            missing_after(|plan| {
                let sine = &mut run(plan, name).sine[0];
                let written = [&mut sine.amplitude_deg, &mut sine.amplitude_m];
                written
                    .into_iter()
                    .flatten()
                    .for_each(|there| *there = amplitude);
            })
        };
        // The least amplitude in degrees that is still a number in radians.
        assert_eq!(with(f64::MIN_POSITIVE * 64.0), [""; 0], "{name}");
        assert!(with(0.0)[0].starts_with(channels), "{name}");
    }
}

#[test]
fn ramps_tilt_when_one_level_is_not_zero() {
    for (name, channels) in NEEDED.into_iter().skip(1).take(2) {
        let with = |level: f64| {
            missing_after(|plan| {
                let levels = run(plan, name).ramps[0].levels_deg.as_mut().unwrap();
                levels.fill(0.0);
                levels[4] = level;
            })
        };
        assert_eq!(with(-f64::MIN_POSITIVE * 64.0), [""; 0], "{name}");
        assert!(with(0.0)[0].starts_with(channels), "{name}");
    }
}

#[test]
fn a_movement_of_two_freedoms_at_once_is_no_movement_of_one() {
    for (name, channels) in NEEDED.into_iter().skip(1) {
        let missing = missing_after(|plan| {
            let other = if name == "yaw-sine" {
                "heave"
            } else {
                "yaw-sine"
            };
            let second = run(plan, other).sine[0].clone();
            run(plan, name).sine.push(second);
        });
        assert!(
            missing.len() == 1 && missing[0].starts_with(channels),
            "{missing:?}"
        );
    }
}
