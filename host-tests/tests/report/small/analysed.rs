//! What the analysis would have found in the small campaign, written by hand.

use std::f64::consts::TAU;

use hexsense_core::calibration::triad::{Noise, TriadFit};
use hexsense_core::excitation::{DegreeOfFreedom, Sine};
use hexsense_core::harmonics::{Harmonic, Harmonics};
use hexsense_probe::analysis::condense::{HoldRun, RestMeans, Sweep};
use hexsense_probe::analysis::estimate::{Condensed, Estimate};
use nalgebra::{Matrix3, Vector3};

use super::recordings::{RECORDINGS, Recording};

/// Gravity by the sensor file, m/s².
const GRAVITY: f64 = 9.8154;

/// A fit of amplitude and uncertainty in counts: three fifths of the amplitude cosine, four sine.
fn fit(amplitude: f64, uncertainty: f64, residual_rms: f64) -> Harmonics {
    let mut fit = Harmonics {
        residual_rms,
        ..Harmonics::NONE
    };
    fit.harmonics[0] = Harmonic {
        cosine: 0.6 * amplitude,
        sine: -0.8 * amplitude,
    };
    fit.harmonics[1].cosine = 3.0;
    fit.uncertainty.amplitude = [uncertainty; 5];
    fit
}

fn sine(amplitude: f64, frequency_hz: f64, estimate_s: f64) -> Sine {
    Sine {
        amplitude,
        frequency_hz,
        phase_rad: 0.0,
        fade_s: 1.0,
        settle_s: 4.0,
        estimate_s,
    }
}

/// A run whose base stayed at home.
fn sweep(run: usize, freedom: DegreeOfFreedom, sine: Sine, hz: f64) -> Sweep {
    let Recording {
        run: name,
        rate_hz,
        onset_s,
        ..
    } = RECORDINGS[run];
    Sweep {
        name: name.to_owned(),
        freedom,
        sine,
        rate_hz,
        omega: TAU * hz,
        length_s: sine.estimate_s,
        first: 6_000,
        onset_s,
        sensors: std::array::from_fn(|_| Harmonics::NONE),
        jacks: vec![[32_768.0; 6]; 40],
        group: 100,
    }
}

fn rest(counts: [f64; 3]) -> RestMeans {
    let mut all = [32_768.0; 15];
    all[..3].copy_from_slice(&counts);
    RestMeans {
        time_s: 1.0,
        length_s: 2.0,
        counts: all,
        jack_noise: [0.1; 6],
    }
}

/// Counts on a level hold on which the accelerometers err by so many mm/s².
fn hold(errors: [f64; 3]) -> RestMeans {
    let [x, y, z] = errors.map(|error| 1e-3 * error);
    rest([
        32_100.0 + 2_000.0 * x,
        32_850.0 + 2_500.0 * (GRAVITY + y),
        33_000.0 + 1_250.0 * z,
    ])
}

pub fn condensed() -> Condensed {
    let [lift, turn] = [sine(0.05, 0.5, 6.0), sine(0.04, 0.25, 8.0)];
    let mut heave = sweep(3, DegreeOfFreedom::Heave, lift, 0.501);
    heave.sensors[1] = fit(1000.0, 1.2, 34.5);
    let mut roll = sweep(4, DegreeOfFreedom::Roll, turn, 0.2505);
    roll.sensors[3] = fit(500.0, 0.34, 7.89);
    roll.sensors[6] = fit(1300.0, 5.6, 0.912);
    let run = |index: usize, holds: &[[f64; 3]]| HoldRun {
        name: RECORDINGS[index].run.to_owned(),
        onset_s: RECORDINGS[index].onset_s,
        holds: holds.iter().copied().map(hold).collect(),
    };
    Condensed {
        rate_hz: 1_000,
        zero: rest([32_100.0, 57_388.5, 33_000.0]),
        hold_runs: vec![
            run(1, &[[2.0, 5.0, -7.0], [-2.0, 5.0, 7.0], [2.0, -5.0, 7.0]]),
            run(2, &[[2.0, -5.0, -7.0], [-2.0, 5.0, -7.0]]),
        ],
        heave,
        turns: vec![roll],
        noise: [1.0, 2.0, 3.0].map(|noise| Noise {
            density: [noise; 3],
            walk: [0.1 * noise; 3],
        }),
    }
}

pub fn estimate() -> Estimate {
    let fit = TriadFit {
        sensitivity: Matrix3::from_diagonal(&Vector3::new(2_000.0, 2_500.0, 1_250.0)),
        matrix: Matrix3::from_diagonal(&Vector3::new(5e-4, 4e-4, 8e-4)),
        delay_s: 0.001,
        delay_shares: [0.2, 0.3, 0.5],
        delay_noise_s: 1e-5,
        row_covariance: [Matrix3::identity(); 3],
    };
    Estimate {
        fits: [fit.clone(), fit.clone(), fit],
        offsets: [Vector3::new(32_100.0, 32_850.0, 33_000.0); 3],
        home: Vector3::new(0.0, GRAVITY, 0.0),
        lever_arm_m: Vector3::new(0.4123, -0.2611, 0.0877),
        lever_arm_noise_m: Vector3::new(0.001, 0.002, 0.003),
    }
}
