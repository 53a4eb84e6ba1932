//! The shape of ramps and sines.

use std::f64::consts::TAU;

use approx::assert_relative_eq;
use hexsense_core::excitation::{RampShape, Ramps, Sine, smooth_step};

/// First and second derivative by central differences.
pub fn derivatives(f: impl Fn(f64) -> f64, t: f64, h: f64) -> (f64, f64) {
    let (before, at, after) = (f(t - h), f(t), f(t + h));
    (
        (after - before) / (2.0 * h),
        (after - 2.0 * at + before) / (h * h),
    )
}

#[test]
fn a_smooth_step_rises_from_zero_to_one_without_a_jolt() {
    let mut steepest: f64 = 0.0;
    let mut most_curved: f64 = 0.0;
    for index in -100..=1_100 {
        let s = f64::from(index) / 1_000.0;
        let (slope, curvature) = derivatives(smooth_step, s, 1e-5);
        assert!(slope >= -1e-9, "falls at {s}");
        assert_relative_eq!(smooth_step(s) + smooth_step(1.0 - s), 1.0, epsilon = 1e-12);
        steepest = steepest.max(slope);
        most_curved = most_curved.max(curvature.abs());
    }
    assert_relative_eq!(steepest, 15.0 / 8.0, epsilon = 1e-5);
    assert_relative_eq!(most_curved, 10.0 / 3_f64.sqrt(), epsilon = 1e-4);
    assert_eq!([-1.0, 0.0, 1.0, 2.0].map(smooth_step), [0.0, 0.0, 1.0, 1.0]);
    for end in [0.0, 1.0] {
        let (slope, curvature) = derivatives(smooth_step, end, 1e-5);
        assert!(
            slope.abs() < 1e-8 && curvature.abs() < 1e-3,
            "{slope} {curvature} at {end}"
        );
    }
}

#[test]
fn the_default_table_goes_up_and_down_in_eight_subintervals() {
    let ramps = Ramps::up_and_down(0.3, 2.0, RampShape::Linear);
    assert_eq!(ramps.duration_s(), 16.0);
    let table = [
        (-5.0, 0.0),
        (0.0, 0.0),
        (1.0, 0.15),
        (2.0, 0.3),
        (3.9, 0.3),
        (5.0, 0.15),
        (6.0, 0.0),
        (7.5, 0.0),
        (9.0, -0.15),
        (10.0, -0.3),
        (11.0, -0.3),
        (13.0, -0.15),
        (14.0, 0.0),
        (15.0, 0.0),
        (16.0, 0.0),
        (99.0, 0.0),
    ];
    for (t_s, expected) in table {
        assert_relative_eq!(ramps.at(t_s), expected, epsilon = 1e-12);
    }
    let holds: std::vec::Vec<_> = ramps
        .holds()
        .map(|hold| (hold.start_s, hold.length_s, hold.level))
        .collect();
    assert_eq!(
        holds,
        [
            (2.0, 2.0, 0.3),
            (6.0, 2.0, 0.0),
            (10.0, 2.0, -0.3),
            (14.0, 2.0, 0.0)
        ]
    );
}

#[test]
fn any_other_staircase_is_a_table() {
    let ramps = Ramps {
        step_s: 0.5,
        levels: [0.1, 0.2, 0.3, 0.3, 0.0].into_iter().collect(),
        shape: RampShape::Linear,
    };
    assert_relative_eq!(ramps.at(0.75), 0.15, epsilon = 1e-12);
    assert_relative_eq!(ramps.at(1.25), 0.25, epsilon = 1e-12);
    assert_eq!(
        ramps
            .holds()
            .map(|hold| hold.start_s)
            .collect::<std::vec::Vec<_>>(),
        [1.5]
    );
    let stays = Ramps {
        levels: [0.0, 0.4].into_iter().collect(),
        ..ramps
    };
    assert_eq!(stays.holds().count(), 1, "the start at zero counts");
    assert_eq!(stays.at(9.0), 0.4, "the last level stays");
}

#[test]
fn every_hold_is_still_and_every_jerk_limited_ramp_starts_and_ends_softly() {
    let (step_s, level) = (1.5, 0.25);
    let ramps = Ramps::up_and_down(level, step_s, RampShape::JerkLimited);
    for hold in ramps.holds() {
        for part in [0.0, 0.3, 0.7, 0.999] {
            assert_relative_eq!(
                ramps.at(hold.start_s + part * hold.length_s),
                hold.level,
                epsilon = 1e-12
            );
        }
    }
    let (mut fastest, mut last): (f64, Option<(f64, f64)>) = (0.0, None);
    let h = 1e-4;
    for index in 0..(ramps.duration_s() / 0.001) as i32 {
        let (speed, acceleration) = derivatives(|t_s| ramps.at(t_s), f64::from(index) * 0.001, h);
        fastest = fastest.max(speed.abs());
        if let Some((speed_before, acceleration_before)) = last {
            // The jerk of the step is at most 60·U/Δt³: the limit of the change in one millisecond.
            let jerk = 60.0 * level / step_s.powi(3);
            assert!((acceleration - acceleration_before).abs() < jerk * 0.001 * 1.2 + 1e-6);
            assert!(
                (speed - speed_before).abs()
                    < 10.0 / 3_f64.sqrt() * level / step_s.powi(2) * 0.001 * 1.1
            );
        }
        last = Some((speed, acceleration));
    }
    assert_relative_eq!(fastest, 15.0 / 8.0 * level / step_s, max_relative = 1e-4);
}

#[test]
fn a_sine_fades_in_stays_and_fades_out() {
    let sine = Sine {
        amplitude: 0.1,
        frequency_hz: 0.5,
        phase_rad: 0.4,
        fade_s: 3.0,
        settle_s: 4.0,
        estimate_s: 3.0,
    };
    assert_eq!(sine.duration_s(), 13.0);
    for index in 0..=130 {
        let t_s = f64::from(index) / 10.0;
        let carrier = 0.1 * (TAU * 0.5 * t_s + 0.4).sin();
        if (3.0..=10.0).contains(&t_s) {
            assert_relative_eq!(sine.at(t_s), carrier, epsilon = 1e-12);
        } else {
            assert!(sine.at(t_s).abs() <= carrier.abs(), "at {t_s}");
        }
    }
    assert_eq!([-1.0, 0.0, 13.0, 20.0].map(|t_s| sine.at(t_s)), [0.0; 4]);
    for end in [0.0, 13.0] {
        let (speed, acceleration) = derivatives(|t_s| sine.at(t_s), end, 1e-4);
        assert!(
            speed.abs() < 1e-6 && acceleration.abs() < 1e-3,
            "jolts at {end}: {speed} {acceleration}"
        );
    }
}

#[test]
fn a_sine_without_fade_starts_and_stops_at_once() {
    let sine = Sine {
        amplitude: 1.0,
        frequency_hz: 0.25,
        phase_rad: TAU / 4.0,
        fade_s: 0.0,
        settle_s: 0.0,
        estimate_s: 8.0,
    };
    for (t_s, expected) in [
        (-0.1, 0.0),
        (0.0, 1.0),
        (2.0, -1.0),
        (7.99, 1.0),
        (8.1, 0.0),
    ] {
        assert_relative_eq!(sine.at(t_s), expected, epsilon = 2e-4);
    }
}

#[test]
fn periods_are_counted_at_full_amplitude() {
    let sine = Sine::of_periods(0.2, 0.4, 2, 3);
    assert_relative_eq!(sine.estimate_start_s(), 7.5, epsilon = 1e-12);
    assert_relative_eq!(sine.estimate_s, 7.5, epsilon = 1e-12);
    assert_relative_eq!(sine.fade_s, 2.5, epsilon = 1e-12);
    assert_relative_eq!(sine.duration_s(), 17.5, epsilon = 1e-12);
    assert_relative_eq!(sine.at(2.5 + 0.625), 0.2, epsilon = 1e-12);
}
