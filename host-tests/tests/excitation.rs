//! Program signals: their shape, and where they lead the base.

use std::f64::consts::TAU;

use approx::assert_relative_eq;
use heapless::Vec;
use hexsense_core::excitation::crest::{Line, crest_factor, low_crest_phases, schroeder_phases};
use hexsense_core::excitation::multisine::{Multisine, Timing, shared};
use hexsense_core::excitation::{
    DegreeOfFreedom, Program, RampShape, Ramps, Signal, Sine, smooth_step,
};
use hexsense_core::kinematics::Geometry;
use nalgebra::{Matrix3, Vector3};

/// First and second derivative by central differences.
fn derivatives(f: impl Fn(f64) -> f64, t: f64, h: f64) -> (f64, f64) {
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
            // Jerk of the step is at most 60·U/Δt³: what one millisecond may change.
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

fn geometry() -> Geometry<f64> {
    // A 6-3 layout: upper hinges at 0°, 120°, 240°, lower ones 52° to either side of them.
    let ring = |radius: f64, degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vector3::new(radius * cos, 0.0, radius * sin)
    };
    let side = |jack: usize| if jack.is_multiple_of(2) { -52.0 } else { 52.0 };
    let lower = std::array::from_fn(|jack| ring(2.2, 120.0 * (jack / 2) as f64 + side(jack)));
    let upper = std::array::from_fn(|jack| ring(1.5, 120.0 * (jack / 2) as f64));
    Geometry::new(lower, upper, 2.1, 3.4, None).unwrap()
}

#[test]
fn a_program_that_does_not_move_is_at_home() {
    let geometry = geometry();
    let still = Program::default();
    assert_eq!(
        (still.pose(&geometry, 3.0), still.duration_s()),
        (geometry.home(), 0.0)
    );
    let before = Program::of(
        DegreeOfFreedom::Roll,
        Signal::Sine(Sine::of_periods(0.1, 0.5, 2, 3)),
    );
    assert_eq!(before.pose(&geometry, 0.0), geometry.home());
}

/// A = Ry(ψ)·Rz(ϑ)·Rx(γ), written out as in GOST 20058-80.
fn attitude(roll: f64, yaw: f64, pitch: f64) -> Matrix3<f64> {
    let ((sg, cg), (sy, cy), (st, ct)) = (roll.sin_cos(), yaw.sin_cos(), pitch.sin_cos());
    Matrix3::new(
        cy * ct,
        sy * sg - cy * st * cg,
        sy * cg + cy * st * sg,
        st,
        ct * cg,
        -ct * sg,
        -sy * ct,
        cy * sg + sy * st * cg,
        cy * cg - sy * st * sg,
    )
}

#[test]
fn each_degree_of_freedom_moves_the_base_its_own_way() {
    let geometry = geometry();
    let level = |level| {
        Signal::Ramps(Ramps {
            step_s: 1.0,
            levels: [level].into_iter().collect(),
            shape: RampShape::JerkLimited,
        })
    };
    let amounts = [0.1, 0.2, 0.3, 0.11, 0.12, 0.13];
    let together = Program {
        signals: DegreeOfFreedom::ALL
            .into_iter()
            .zip(amounts.map(level))
            .collect(),
    };
    assert_eq!(together.displacement(2.0), amounts);
    let pose = together.pose(&geometry, 2.0);
    let home = geometry.home().position;
    assert_relative_eq!(
        pose.position,
        home + Vector3::new(0.1, 0.2, 0.3),
        epsilon = 1e-12
    );
    let expected = attitude(0.11, 0.12, 0.13);
    assert_relative_eq!(
        *pose.rotation.to_rotation_matrix().matrix(),
        expected,
        epsilon = 1e-12
    );

    let names = DegreeOfFreedom::ALL.map(DegreeOfFreedom::name);
    assert_eq!(names, ["surge", "heave", "sway", "roll", "yaw", "pitch"]);
    let rotations = DegreeOfFreedom::ALL.map(DegreeOfFreedom::is_rotation);
    assert_eq!(rotations, [false, false, false, true, true, true]);
}

#[test]
fn a_degree_of_freedom_named_twice_moves_by_the_sum() {
    let sine = |frequency_hz| Sine {
        amplitude: 0.1,
        frequency_hz,
        phase_rad: 0.3,
        fade_s: 1.0,
        settle_s: 4.0,
        estimate_s: 5.0,
    };
    let heave = |frequency_hz| (DegreeOfFreedom::Heave, Signal::Sine(sine(frequency_hz)));
    let multisine = Program {
        signals: [heave(0.3), heave(0.7)].into_iter().collect(),
    };
    for t_s in [0.5, 3.3, 8.8] {
        let expected = sine(0.3).at(t_s) + sine(0.7).at(t_s);
        assert_relative_eq!(multisine.displacement(t_s)[1], expected, epsilon = 1e-12);
    }
    assert_eq!(multisine.duration_s(), 11.0);
}

/// A flat sum of the first `N` harmonics.
fn flat<const N: usize>() -> Vec<Line, N> {
    let line = |harmonic| Line {
        harmonic,
        amplitude: 0.3,
        phase_rad: 0.0,
    };
    (1..=N as u16).map(line).collect()
}

/// Peak over root mean square by its definition, from samples so fine that nothing is missed.
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

    // Fourier sums over the window: each degree of freedom has its own lines and nothing of the others'.
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
