//! Program signals: their shape, and where they lead the base.

use std::f64::consts::TAU;

use approx::assert_relative_eq;
use hexsense::excitation::{DegreeOfFreedom, Program, RampShape, Ramps, Signal, Sine, smooth_step};
use hexsense::kinematics::Geometry;
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
    let holds: Vec<_> = ramps
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
        ramps.holds().map(|hold| hold.start_s).collect::<Vec<_>>(),
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
