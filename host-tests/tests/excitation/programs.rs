//! The pose that a program gives the base.

use approx::assert_relative_eq;
use hexsense_core::excitation::{DegreeOfFreedom, Program, RampShape, Ramps, Signal, Sine};
use host_tests::reference::{gost, six_three};
use nalgebra::Vector3;

#[test]
fn a_program_that_does_not_move_is_at_home() {
    let geometry = six_three();
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

#[test]
fn each_degree_of_freedom_moves_the_base_its_own_way() {
    let geometry = six_three();
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
    let expected = gost(0.11, 0.12, 0.13);
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
