use std::f64::consts::TAU;

use super::*;
use crate::analysis::results::{ChannelResult, Measured};
use hexsense_core::channel::NAMES;

/// A channel within its limits, with numbers that no other channel has.
fn good(channel: usize) -> ChannelVerdict {
    let size = 1.0 + channel as f64;
    ChannelVerdict {
        name: NAMES[channel].to_owned(),
        unit: format!("unit {channel}"),
        rms_signal: size,
        rms_error_before: 0.5 * size,
        rms_error_after: 0.02 * size,
        mean_error: -0.001 * size,
        mean_uncertainty: 0.002 * size,
    }
}

#[test]
fn an_rms_error_of_three_hundredths_of_the_signal_passes_and_the_next_larger_one_does_not() {
    let with = |rms_error_after| ChannelVerdict {
        rms_signal: 2.0,
        rms_error_after,
        ..good(3)
    };
    assert!(with(0.06).passes());
    assert!(!with(0.06_f64.next_up()).passes());
    assert!(!with(f64::NAN).passes());
}

#[test]
fn a_mean_error_as_large_as_its_uncertainty_passes_and_the_next_larger_one_does_not() {
    let with = |mean_error| ChannelVerdict {
        mean_error,
        mean_uncertainty: 0.25,
        ..good(3)
    };
    for sign in [-1.0, 1.0] {
        assert!(with(sign * 0.25).passes());
        assert!(!with(sign * 0.25_f64.next_up()).passes());
    }
    assert!(!with(f64::NAN).passes());
}

#[test]
fn one_channel_that_fails_by_its_mean_or_its_rms_alone_is_named_alone() {
    for channel in 0..INERTIAL {
        let with = |spoil: fn(&mut ChannelVerdict)| {
            let mut verdicts: Vec<_> = (0..INERTIAL).map(good).collect();
            assert!(failures(&verdicts).is_empty());
            spoil(&mut verdicts[channel]);
            verdicts
        };
        let by_mean = with(|verdict| verdict.mean_error = -1.001 * verdict.mean_uncertainty);
        let by_rms = with(|verdict| verdict.rms_error_after = 0.030_001 * verdict.rms_signal);
        assert_eq!(failures(&by_mean), [NAMES[channel]]);
        assert_eq!(failures(&by_rms), [NAMES[channel]]);
    }
    let mut verdicts: Vec<_> = (0..INERTIAL).map(good).collect();
    (verdicts[7].mean_error, verdicts[2].rms_error_after) = (1.0, 1.0);
    assert_eq!(
        failures(&verdicts),
        ["az", "wy"],
        "in the order of the channels"
    );
}

/// What [`compare`] takes of a campaign's results; each channel has its own.
fn results() -> Results {
    let none = Measured {
        estimate: 0.0,
        expanded_uncertainty: 0.0,
        interval_95: 0.0,
    };
    let channel = |channel: usize| ChannelResult {
        name: NAMES[channel].to_owned(),
        unit: format!("unit {channel}"),
        offset: none,
        gain: none,
        cross: [none; 3],
        sensitivity: 0.0,
        budget: Vec::new(),
        // Legs of a box: 2·size, 3·size and 6·size have the diagonal 7·size.
        noise_density: 2.0 * 40f64.sqrt() * size(channel),
        rest_uncertainty: 3.0 * size(channel),
        bias_walk: 6.0 / 12.0 * size(channel),
    };
    Results {
        channels: (0..INERTIAL).map(channel).collect(),
        delays_s: [none; 3],
        gravity_m_s2: none,
        lever_arm_m: [none; 3],
        second_harmonics: Vec::new(),
        warnings: Vec::new(),
        scans: 0,
        checks: Vec::new(),
    }
}

fn size(channel: usize) -> f64 {
    0.1 + 0.01 * channel as f64
}

/// A sine of half a hertz, which the low-pass makes smaller by 1 in 65,536, for 20 s; the mean of whole periods is zero.
fn sine(amplitude: f64, mean: f64) -> Vec<f64> {
    let at = |n: usize| mean + amplitude * (TAU * 0.5 * n as f64 / 100.0).sin();
    (0..2_000).map(at).collect()
}

#[test]
fn signal_errors_and_uncertainty_of_each_channel_are_its_own() {
    let each = |of: fn(f64) -> Vec<f64>| std::array::from_fn(|channel| of(size(channel)));
    let reference: Signals = each(|size| sine(10.0 * size, 40.0 * size));
    let after = each(|size| sine(10.5 * size, 41.0 * size));
    let before = each(|size| sine(13.0 * size, 90.0 * size));
    // 144 s are twelve times the root.
    let verdicts = compare(&reference, &after, &before, &results(), 144.0);
    assert_eq!(verdicts.len(), INERTIAL);
    for (channel, verdict) in verdicts.iter().enumerate() {
        let size = size(channel);
        assert_eq!(verdict.name, NAMES[channel]);
        assert_eq!(verdict.unit, format!("unit {channel}"));
        // A low-pass of 2 Hz swings for a second at the ends; 17 s hold eight and a half periods.
        let is = |found: f64, expected: f64, within: f64| {
            let off = found / (expected * size) - 1.0;
            assert!(off.abs() < within, "{channel}: {found} {expected} {off:e}");
        };
        let root = 2f64.sqrt();
        is(verdict.rms_signal, 10.0 / root, 0.01);
        is(verdict.rms_error_after, 0.5 / root, 0.01);
        is(verdict.rms_error_before, 3.0 / root, 0.01);
        is(verdict.mean_error, 1.0, 0.03);
        is(verdict.mean_uncertainty, 3.0 * 7.0, 1e-12);
    }
}
