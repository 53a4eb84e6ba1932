//! Multisines: phases for a low crest factor, separation in the window, fades.

use std::f64::consts::TAU;

use approx::assert_relative_eq;
use heapless::Vec;
use hexsense_core::excitation::crest::{Line, crest_factor, low_crest_phases, schroeder_phases};
use hexsense_core::excitation::multisine::{Multisine, Timing, shared};
use hexsense_core::excitation::{DegreeOfFreedom, Program, Signal};

use crate::signals::derivatives;

/// A flat sum of the first `N` harmonics.
fn flat<const N: usize>() -> Vec<Line, N> {
    let line = |harmonic| Line {
        harmonic,
        amplitude: 0.3,
        phase_rad: 0.0,
    };
    (1..=N as u16).map(line).collect()
}

/// Peak over root mean square by its definition, from fine samples.
fn crest_by_definition(lines: &[Line]) -> f64 {
    let at = |sample: i32| -> f64 {
        let turn = TAU * f64::from(sample) / 100_000.0;
        let line = |l: &Line| l.amplitude * (f64::from(l.harmonic) * turn + l.phase_rad).cos();
        lines.iter().map(line).sum()
    };
    let (peak, square) = (0..100_000)
        .map(at)
        .fold((0.0_f64, 0.0), |(p, s), u| (p.max(u.abs()), s + u * u));
    peak / (square / 100_000.0).sqrt()
}

#[test]
fn equal_sines_have_the_published_crest_factors() {
    // At zero phases √(2N); with Schroeder's about 1.7.
    let mut lines: Vec<Line, 64> = flat();
    assert_relative_eq!(crest_factor(&lines), 128_f64.sqrt(), max_relative = 1e-9);
    schroeder_phases(&mut lines);
    assert_relative_eq!(crest_factor(&lines), 1.7, epsilon = 0.05);
    let exact = crest_by_definition(&lines);
    assert_relative_eq!(crest_factor(&lines), exact, max_relative = 5e-3);
    let one: Vec<Line, 1> = flat();
    assert_relative_eq!(crest_factor(&one), 2_f64.sqrt(), max_relative = 1e-12);
    assert_eq!(crest_factor(&Vec::<Line, 4>::new()), 0.0);
}

/// Equal powers: −π·n·(n − 1)/N, as published, for lines counted from 1.
#[test]
fn schroeders_phases_are_his_formula() {
    let mut lines: Vec<Line, 16> = flat();
    schroeder_phases(&mut lines);
    for (n, line) in (1..).zip(&lines) {
        let published = -TAU / 2.0 * f64::from(n * (n - 1)) / 16.0;
        let turns = (line.phase_rad - published) / TAU;
        assert!((turns - turns.round()).abs() < 1e-12, "{n}: {turns}");
    }
}

#[test]
fn the_search_lowers_the_crest_factor_and_never_above_that_of_zero_phases() {
    let mut swept: Vec<Line, 31> = flat();
    schroeder_phases(&mut swept);
    let mut searched: Vec<Line, 31> = flat();
    low_crest_phases(&mut searched);
    assert!(crest_factor(&searched) < crest_factor(&swept) - 0.1);

    // Scattered harmonics, of unequal size, some of which no sweep suits.
    let sets: [&[u16]; 6] = [
        &[1],
        &[1, 2],
        &[5, 11, 17, 23],
        &[3, 4, 50],
        &[2, 4, 8, 16, 32],
        &[7, 13, 14, 60, 61, 200],
    ];
    for (set, ratio) in sets.into_iter().zip([1.0, 0.5, 0.8, 2.0, 0.7, 1.3]) {
        let mut amplitude = 1.0;
        let mut lines: Vec<Line, 12> = Vec::new();
        for &harmonic in set {
            let phase_rad = 0.0;
            let line = Line {
                harmonic,
                amplitude,
                phase_rad,
            };
            lines.push(line).unwrap();
            amplitude *= ratio;
        }
        let at_zero = crest_by_definition(&lines);
        low_crest_phases(&mut lines);
        let found = crest_by_definition(&lines);
        assert!(found <= at_zero * 1.005, "{set:?}: {found} {at_zero}");
        assert!(
            set.len() < 3 || found < 0.99 * at_zero,
            "{set:?}: {found} {at_zero}"
        );
    }
}

fn timing() -> Timing {
    Timing {
        fundamental_hz: 0.1,
        fade_s: 4.0,
        settle_periods: 1,
        estimate_periods: 2,
    }
}

#[test]
fn degrees_of_freedom_with_disjoint_harmonics_are_told_apart_in_the_window() {
    let tones = [
        (
            DegreeOfFreedom::Heave,
            vec![(3_u16, 0.02), (9, 0.01), (15, 0.005)],
        ),
        (DegreeOfFreedom::Roll, vec![(4, 0.03), (10, 0.02)]),
        (DegreeOfFreedom::Pitch, vec![(5, 0.03), (11, 0.01)]),
    ];
    let of = |tones: &[(u16, f64)]| Multisine::new(timing(), tones.iter().copied());
    let program = Program {
        signals: tones
            .iter()
            .map(|(freedom, tones)| (*freedom, Signal::Multisine(of(tones))))
            .collect(),
    };
    assert_eq!(program.duration_s(), 38.0);
    let harmonics: std::vec::Vec<u16> = tones
        .iter()
        .flat_map(|(_, tones)| tones.iter().map(|tone| tone.0))
        .collect();
    assert_eq!(shared(&harmonics), None);
    assert_eq!(shared(&[3, 4, 5, 4, 3]), Some(4));

    // Fourier sums over the window: each degree of freedom has its own lines and no others.
    let (start_s, length_s, samples) = (timing().estimate_start_s(), timing().estimate_s(), 4000);
    assert_eq!((start_s, length_s), (14.0, 20.0));
    for (freedom, own) in &tones {
        for &harmonic in &harmonics {
            let (mut cosine, mut sine) = (0.0, 0.0);
            for sample in 0..samples {
                let t_s = start_s + length_s * f64::from(sample) / f64::from(samples);
                let u = program.displacement(t_s)[*freedom as usize];
                let (s, c) = (TAU * 0.1 * f64::from(harmonic) * t_s).sin_cos();
                cosine += 2.0 * u * c / f64::from(samples);
                sine += 2.0 * u * s / f64::from(samples);
            }
            let expected = own
                .iter()
                .find(|tone| tone.0 == harmonic)
                .map_or(0.0, |tone| tone.1);
            assert_relative_eq!(cosine.hypot(sine), expected, epsilon = 1e-12);
        }
    }
}

#[test]
fn a_multisine_starts_and_ends_without_a_jolt_and_with_bounded_jerk() {
    let multisine = Multisine::new(timing(), [(3, 0.1), (7, 0.05), (8, 0.05)]);
    let h = 1e-3;
    let third = |t: f64| {
        let u = |n: f64| multisine.at(t + n * h);
        (u(2.0) - 2.0 * u(1.0) + 2.0 * u(-1.0) - u(-2.0)) / (2.0 * h * h * h)
    };
    for end in [0.0, 38.0] {
        assert_eq!(multisine.at(end), 0.0);
        let (speed, acceleration) = derivatives(|t_s| multisine.at(t_s), end, 1e-4);
        assert!(speed.abs() < 1e-6 && acceleration.abs() < 1e-3);
    }
    let peak: f64 = multisine.lines().iter().map(|line| line.amplitude).sum();
    // Leibniz: the highest line is at 0.8 Hz, and the fade has slope 15/8, curvature 10/√3 and jerk 60 over 4 s.
    let (w, f) = (TAU * 0.8, 4.0_f64);
    let bound = peak
        * (w.powi(3)
            + 3.0 * w * w * 1.875 / f
            + 3.0 * w * 10.0 / 3_f64.sqrt() / f.powi(2)
            + 60.0 / f.powi(3));
    for index in -100..3900 {
        let jerk = third(f64::from(index) * 0.01);
        assert!(
            jerk.abs() < bound,
            "at {}: {jerk} {bound}",
            f64::from(index) * 0.01
        );
    }
}
