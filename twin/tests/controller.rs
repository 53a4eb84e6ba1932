//! The motion controller and the jacks that follow it.

mod support;

use support::{Y, an74, close, pass, program};
use twin::algebra::Rotation;
use twin::bench::STEP_S;
use twin::controller::{Controller, Refusal};
use twin::geometry::Geometry;
use twin::jack::{JackMotion, Jacks};
use twin::limits::BeyondLimit;
use twin::mechanism::Pose;
use twin::{Bench, Program};

/// Heave from home by this much at each time.
fn heave(geometry: &Geometry, duration_s: f64, height: impl Fn(f64) -> f64) -> Program {
    program(geometry, duration_s, |t| Pose {
        position_m: geometry.home.position_m + Y * height(t),
        attitude: Rotation::LEVEL,
    })
}

/// The first and the last time at which the command changes, found to 0.5 ms.
fn moves(controller: &Controller, until_s: f64) -> (f64, f64) {
    let steps = (until_s * 2e3) as usize;
    let value = |n: usize| controller.command_m(0, n as f64 * 5e-4);
    let first = (0..steps).find(|n| value(n + 1) != value(*n)).unwrap();
    let last = (0..steps)
        .rev()
        .find(|n| value(n + 1) != value(*n))
        .unwrap();
    (first as f64 * 5e-4, last as f64 * 5e-4)
}

#[test]
fn runs_start_within_ten_seconds_by_a_clock_of_their_own() {
    let geometry = an74();
    let mut starts = Vec::new();
    let mut rates = Vec::new();
    for seed in 0..60 {
        let mut controller = Controller::draw(seed, &geometry);
        let ramp = heave(&geometry, 100.0, |t| 0.002 * t);
        controller.run("ramp", ramp, 0.0).unwrap();
        let (first, last) = moves(&controller, 111.0);
        starts.push(first);
        rates.push((last - first) / 100.0 - 1.0);
    }
    let within = |values: &[f64], low: f64, high: f64| {
        let min = values.iter().copied().fold(f64::INFINITY, f64::min);
        let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let edge = 0.15 * (high - low);
        assert!(low <= min && min < low + edge, "least {min}");
        assert!(high - edge < max && max <= high, "most {max}");
    };
    within(&starts, 0.0, 10.0);
    within(&rates, -110e-6, 110e-6);
}

#[test]
fn a_program_beyond_a_limit_is_refused_with_jack_time_value_and_limit() {
    let geometry = an74();
    let mut controller = Controller::draw(1, &geometry);
    let too_far = heave(&geometry, 20.0, |t| 0.05 * t);
    let Err(Refusal::Limit(BeyondLimit {
        jack,
        time_s,
        quantity,
        value,
        limit,
        ..
    })) = controller.run("far", too_far, 0.0)
    else {
        panic!("left the stroke");
    };
    assert_eq!((jack, quantity), (1, "displacement"));
    close(limit, 0.65, 1e-12, "limit");
    assert!(
        value > 0.65 && (15.0..20.0).contains(&time_s),
        "{value} at {time_s}"
    );
    let too_fast = heave(&geometry, 0.4, |t| 1.3 * t);
    let speed = controller
        .run("fast", too_fast, 0.0)
        .unwrap_err()
        .to_string();
    assert!(
        speed.contains("speed") && speed.contains("limit ±1.0000 m/s"),
        "{speed}"
    );
    let too_hard = heave(&geometry, 0.1, |t| 10.0 * t * t);
    let hard = controller
        .run("hard", too_hard, 0.0)
        .unwrap_err()
        .to_string();
    assert!(
        hard.contains("acceleration") && hard.contains("limit ±10.0000 m/s²"),
        "{hard}"
    );
    for jack in 0..6 {
        close(controller.command_m(jack, 11.0), 0.0, 1e-5, "nothing moves");
    }
}

#[test]
fn a_program_that_begins_elsewhere_or_comes_too_early_is_refused() {
    let geometry = an74();
    let mut controller = Controller::draw(1, &geometry);
    let elsewhere = heave(&geometry, 1.0, |_| 0.02);
    assert!(matches!(
        controller.run("jump", elsewhere, 0.0),
        Err(Refusal::Jump { jack: 1, .. })
    ));
    let wave = || {
        heave(&geometry, 5.0, |t| {
            0.02 * (1.0 - (0.4 * std::f64::consts::PI * t).cos())
        })
    };
    controller.run("first", wave(), 0.0).unwrap();
    let busy = controller.run("second", wave(), 1.0).unwrap_err();
    assert_eq!(
        busy.to_string(),
        "run \"first\" has not ended; wait for it, or stop"
    );
    controller.run("second", wave(), 15.1).unwrap();
}

#[test]
fn a_stop_brakes_on_the_path_and_goes_home() {
    let geometry = an74();
    let mut controller = Controller::draw(2, &geometry);
    let wave = heave(&geometry, 60.0, |t| {
        0.4 * (t / 5.0).min(1.0).powi(2) * (std::f64::consts::TAU * 0.2 * t).sin()
    });
    controller.run("wave", wave, 0.0).unwrap();
    controller.stop(20.03);
    let busy = controller.run("again", heave(&geometry, 1.0, |_| 0.0), 20.5);
    assert!(busy.unwrap_err().to_string().contains("return home"));
    let at = |t: f64| controller.command_m(0, t);
    let fastest = (200_000..450_000)
        .map(|n| f64::from(n) * 1e-4)
        .map(|t| (at(t + 1e-4) - at(t)).abs() / 1e-4)
        .fold(0.0, f64::max);
    assert!(at(20.03).abs() > 0.01, "stopped where nothing moved");
    assert!(fastest < 0.55, "speed {fastest}");
    close(at(45.0), 0.0, 1e-6, "home");
    controller
        .run("again", heave(&geometry, 1.0, |_| 0.0), 45.0)
        .unwrap();
}

#[test]
fn between_rows_the_command_is_a_smooth_cubic() {
    let rows = (0..200).map(|n| [(f64::from(n) * 0.02).sin(); 6]).collect();
    let program = Program::new(0.02, rows).unwrap();
    for n in 50..3900 {
        let t = f64::from(n) * 0.001;
        close(program.at(3, t), t.sin(), 1e-6, "value");
        let slope = (program.at(3, t + 1e-6) - program.at(3, t - 1e-6)) / 2e-6;
        close(slope, t.cos(), 1e-4, "slope");
    }
    assert_eq!(program.at(0, -1.0), 0.0);
    assert_eq!(program.at(0, 99.0), (199.0_f64 * 0.02).sin());
}

#[test]
fn jacks_lag_behind_a_ramp_each_a_little_differently_and_arrive() {
    let geometry = an74();
    for seed in 0..5 {
        let mut bench = Bench::with_geometry(seed, &geometry).unwrap();
        let home = bench.motion().jacks.displacement_m;
        let ramp = heave(&geometry, 8.0, |t| 0.1 * t.min(3.0));
        let end = ramp.rows()[8000];
        bench.run("ramp", ramp).unwrap();
        let run = pass(&mut bench, 18.0);
        // At the same speed of the jacks a lag in time is a difference of position.
        let middle = run
            .iter()
            .find(|m| m.velocity.linear.0[1] > 0.05 && m.pose.position_m.0[1] > 2.28)
            .unwrap();
        let travel: Vec<f64> = (0..6)
            .map(|k| middle.jacks.displacement_m[k] - home[k])
            .collect();
        let spread = travel.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            - travel.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(spread > 2e-5 && spread < 2e-3, "spread {spread}");
        let last = run.last().unwrap();
        for (got, want) in last.jacks.displacement_m.into_iter().zip(end) {
            close(got, want, 2e-5, "arrival");
        }
    }
}

#[test]
fn a_jack_answers_late_and_bumps_when_it_turns_around() {
    let geometry = an74();
    for seed in 0..10 {
        let mut controller = Controller::draw(seed, &geometry);
        let wave = heave(&geometry, 20.0, |t| {
            0.03 * (1.0 - (std::f64::consts::TAU * 0.5 * t).cos())
        });
        controller.run("wave", wave, 0.0).unwrap();
        let (start, _) = moves(&controller, 31.0);
        let mut jacks = Jacks::draw(seed, geometry.home_displacements_m());
        let run: Vec<JackMotion> = (0..((start + 4.0) / STEP_S) as u32)
            .map(|n| {
                jacks.advance(&controller, f64::from(n) * STEP_S, STEP_S);
                jacks.motion()
            })
            .collect();
        let after_start = |index: usize| index as f64 * STEP_S - start;
        let first = run
            .iter()
            .position(|m| m.speed_m_s[0].abs() > 1e-7)
            .unwrap();
        let delay = after_start(first);
        assert!((0.004..0.023).contains(&delay), "delay {delay}");
        // At the top the acceleration of a sine stands still; that of a jack falls less by twice its friction.
        let top = (first + 1000..run.len())
            .find(|n| run[*n].speed_m_s[0] < 0.0)
            .unwrap();
        let bump = run[top + 16].acceleration_m_s2[0] - run[top - 16].acceleration_m_s2[0];
        assert!((0.015..0.25).contains(&bump), "bump {bump} m/s²");
    }
}
