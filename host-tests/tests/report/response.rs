//! How the base follows a sine, of which amplitude, phase and second harmonic are known.

use std::f64::consts::TAU;

use hexsense_core::excitation::{DegreeOfFreedom, Sine};
use hexsense_core::harmonics::Harmonics;
use hexsense_probe::analysis::assumptions::Assumptions;
use hexsense_probe::analysis::condense::Sweep;
use hexsense_probe::characteristics::frequency_response::FrequencyResponse;

use crate::small::SMALL;
use crate::small::recordings::{COUNTS_PER_M, lengths};

const RATE_HZ: u32 = 1_000;
const GROUP: usize = 10;
const FIRST: usize = 6_250;
const ONSET_S: f64 = 1.3;

/// A run in which `freedom` swings by `ratio` of the command, `phase_deg` before it, and by `second` at twice its
/// frequency.
fn sweep(freedom: DegreeOfFreedom, sine: Sine, ratio: f64, phase_deg: f64, second: f64) -> Sweep {
    let omega = TAU * sine.frequency_hz;
    let counts = |scan: usize| {
        let theta = omega * (scan as f64 / f64::from(RATE_HZ) - ONSET_S);
        let mut moved = [0.0; 6];
        moved[freedom as usize] = ratio * sine.amplitude * (theta + phase_deg.to_radians()).sin()
            + second * (2.0 * theta).sin();
        lengths(&SMALL.campaign.geometry, moved)
            .map(|length| 32_768.0 + COUNTS_PER_M * (length - 2.75))
    };
    let groups = (sine.estimate_s * f64::from(RATE_HZ)) as usize / GROUP;
    let mean = |group: usize| {
        let mut mean = [0.0; 6];
        for scan in 0..GROUP {
            let counts = counts(FIRST + group * GROUP + scan);
            mean.iter_mut()
                .zip(counts)
                .for_each(|(mean, count)| *mean += count / GROUP as f64);
        }
        mean
    };
    Sweep {
        name: "one".to_owned(),
        freedom,
        sine,
        rate_hz: RATE_HZ,
        omega,
        length_s: sine.estimate_s,
        first: FIRST,
        onset_s: ONSET_S,
        sensors: std::array::from_fn(|_| Harmonics::NONE),
        jacks: (0..groups).map(mean).collect(),
        group: GROUP,
    }
}

fn response(sweep: &Sweep) -> FrequencyResponse {
    let assumptions = Assumptions::new(&SMALL.campaign.geometry, &SMALL.campaign.sensors);
    FrequencyResponse::new(sweep, &assumptions).unwrap()
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{found} for {expected}"
    );
}

#[test]
fn a_pose_that_lags_has_a_negative_phase_and_one_that_leads_a_positive_one() {
    let sine = |amplitude, frequency_hz, estimate_s| Sine {
        amplitude,
        frequency_hz,
        phase_rad: 0.0,
        fade_s: 2.0,
        settle_s: 3.0,
        estimate_s,
    };
    let lags = response(&sweep(
        DegreeOfFreedom::Heave,
        sine(0.05, 0.5, 6.0),
        0.97,
        -30.0,
        0.001,
    ));
    assert_eq!(
        (lags.run.as_str(), lags.freedom.as_str(), lags.command),
        ("one", "heave", 0.05)
    );
    // The jacks are read some 80 µs after the trigger, 0.02° of the sine.
    for (found, expected, tolerance) in [
        (lags.frequency_hz, 0.5, 1e-12),
        (lags.measured, 0.0485, 1e-6),
        (lags.ratio, 0.97, 1e-5),
        (lags.phase_deg, -30.0, 0.03),
        (lags.distortion, 0.001 / 0.0485, 1e-5),
    ] {
        assert_near(found, expected, tolerance);
    }
    let leads = response(&sweep(
        DegreeOfFreedom::Yaw,
        sine(0.04, 0.25, 8.0),
        1.05,
        20.0,
        0.0,
    ));
    assert_eq!((leads.freedom.as_str(), leads.command), ("yaw", 0.04));
    for (found, expected, tolerance) in [
        (leads.frequency_hz, 0.25, 1e-12),
        (leads.measured, 0.042, 1e-5),
        (leads.ratio, 1.05, 1e-4),
        (leads.phase_deg, 20.0, 0.03),
        (leads.distortion, 0.0, 1e-4),
    ] {
        assert_near(found, expected, tolerance);
    }
}
