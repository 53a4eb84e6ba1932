use super::*;
use crate::plan::{RampsEntry, Shape, SineEntry};

fn rest() -> Run {
    Run {
        name: "rest".to_owned(),
        purpose: Purpose::Calibrate,
        rest_s: Some(10.0),
        ramps: Vec::new(),
        sine: Vec::new(),
        multisine: None,
    }
}

fn ramps(freedom: Freedom) -> Run {
    let entry = RampsEntry {
        freedom,
        levels_deg: None,
        levels_m: None,
        step_s: 4.0,
        shape: Shape::JerkLimited,
    };
    Run {
        name: "ramps".to_owned(),
        rest_s: None,
        ramps: vec![entry],
        ..rest()
    }
}

fn sine(freedom: Freedom) -> Run {
    let entry = SineEntry {
        freedom,
        amplitude_deg: None,
        amplitude_m: None,
        frequency_hz: 0.5,
        fade_s: 2.0,
        settle_s: 4.0,
        estimate_s: 6.0,
    };
    Run {
        name: "sine".to_owned(),
        rest_s: None,
        sine: vec![entry],
        ..rest()
    }
}

const FREEDOMS: [Freedom; 6] = [
    Freedom::Surge,
    Freedom::Heave,
    Freedom::Sway,
    Freedom::Roll,
    Freedom::Yaw,
    Freedom::Pitch,
];

fn is_fitted(run: &Run, earlier: &[Run]) -> bool {
    check("plan.toml", run, earlier).is_ok()
}

#[test]
fn coefficients_are_fitted_to_a_rest_two_tilts_a_heave_and_three_turns() {
    assert!(is_fitted(&rest(), &[]));
    let holds = [false, false, false, true, false, true];
    let sines = [false, true, false, true, true, true];
    for ((freedom, holds), sines) in FREEDOMS.into_iter().zip(holds).zip(sines) {
        assert_eq!(is_fitted(&ramps(freedom), &[]), holds, "{freedom:?}");
        assert_eq!(is_fitted(&sine(freedom), &[]), sines, "{freedom:?}");
        for purpose in [Purpose::Verify, Purpose::Characterise] {
            let with = |run: Run| is_fitted(&Run { purpose, ..run }, &[]);
            assert!(with(ramps(freedom)) && with(sine(freedom)), "{freedom:?}");
        }
    }
    let both = Run {
        ramps: ramps(Freedom::Pitch).ramps,
        ..sine(Freedom::Pitch)
    };
    let mut two = sine(Freedom::Roll);
    two.sine.extend(sine(Freedom::Yaw).sine);
    let mut tilts = ramps(Freedom::Roll);
    tilts.ramps.extend(ramps(Freedom::Pitch).ramps);
    assert!(![both, two, tilts].iter().any(|run| is_fitted(run, &[])));
}

#[test]
fn only_turns_may_repeat_and_what_does_not_calibrate_does_not_count() {
    let once = [
        rest(),
        ramps(Freedom::Pitch),
        ramps(Freedom::Roll),
        sine(Freedom::Heave),
    ];
    for run in &once {
        let error = check("plan.toml", run, &once).unwrap_err().to_string();
        let same = format!("the same movement as run {}", run.name);
        assert!(error.contains(&same), "{error}");
        let verify = once.clone().map(|run| Run {
            purpose: Purpose::Verify,
            ..run
        });
        assert!(is_fitted(run, &verify));
        let others: Vec<Run> = once.iter().filter(|other| *other != run).cloned().collect();
        assert!(is_fitted(run, &others));
    }
    for freedom in [Freedom::Roll, Freedom::Yaw, Freedom::Pitch] {
        assert!(is_fitted(&sine(freedom), &[sine(freedom)]), "{freedom:?}");
    }
}
