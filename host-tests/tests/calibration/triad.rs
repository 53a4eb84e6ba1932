//! A triad is recovered exactly from runs without noise, and runs that cannot determine it are refused.

use std::f64::consts::TAU;

use hexsense_core::calibration::triad::{Hold, Noise, SineRun, TriadError, TriadFit, fit_triad};
use nalgebra::{Complex, Matrix3, Vector3};
use proptest::prelude::*;

pub const NOISE: Noise = Noise {
    density: [0.3; 3],
    walk: [0.05; 3],
};
const G: f64 = 9.80665;

/// A triad whose sensors are misaligned, offset and late.
#[derive(Debug, Clone)]
struct Sensors {
    sensitivity: Matrix3<f64>,
    offset: Vector3<f64>,
    delay_s: f64,
}

fn sensors() -> impl Strategy<Value = Sensors> {
    let three = |low: f64, high: f64| [low..high, low..high, low..high];
    (
        (
            three(0.7, 1.3),
            [any::<bool>(), any::<bool>(), any::<bool>()],
            1.0_f64..4.0,
        ),
        [three(-0.1, 0.1), three(-0.1, 0.1), three(-0.1, 0.1)],
        three(30_000.0, 35_000.0),
        0.0_f64..0.1,
    )
        .prop_map(|((gains, signs, decade), cross, offset, delay_s)| {
            let sensitivity = Matrix3::from_fn(|sensor, axis| {
                let main = if sensor == axis {
                    gains[sensor]
                } else {
                    cross[sensor][axis]
                };
                main * if signs[sensor] { 1.0 } else { -1.0 } * 10_f64.powf(decade)
            });
            Sensors {
                sensitivity,
                offset: Vector3::from(offset),
                delay_s,
            }
        })
}

impl Sensors {
    /// The sensors' reading on a hold at this attitude; the bias has wandered by `wandered` since the zero run.
    fn hold(&self, run: usize, time_s: f64, (roll, pitch): (f64, f64), wandered: f64) -> Hold {
        let truth = Vector3::new(
            pitch.sin(),
            pitch.cos() * roll.cos(),
            -pitch.cos() * roll.sin(),
        ) * G;
        let counts = self.sensitivity * truth + self.offset.add_scalar(wandered);
        Hold {
            run,
            time_s,
            length_s: 8.0,
            counts,
            truth,
        }
    }

    /// The sensors' reading of this motion.
    fn sine(&self, frequency_hz: f64, truth: [Complex<f64>; 3]) -> SineRun {
        let omega = TAU * frequency_hz;
        let late = Complex::from_polar(1.0, -omega * self.delay_s);
        let counts = std::array::from_fn(|sensor| {
            (0..3)
                .map(|axis| truth[axis] * self.sensitivity[(sensor, axis)])
                .sum::<Complex<f64>>()
                * late
        });
        SineRun {
            omega,
            length_s: 3.0 / frequency_hz,
            counts,
            truth,
        }
    }

    /// Pitch run, roll run, and a heave sine with a little motion along the other axes.
    fn linear_runs(&self) -> (Vec<Hold>, Vec<SineRun>) {
        let levels = [0.3, 0.0, -0.3, 0.0];
        let pitch = (0..4).map(|h| self.hold(0, 20.0 * h as f64, (0.01, levels[h]), 3.0));
        let roll = (0..4).map(|h| self.hold(1, 200.0 + 20.0 * h as f64, (levels[h], -0.02), -5.0));
        let truth = [(0.02, 0.1), (1.5, -0.4), (-0.05, 0.0)].map(|(a, b)| Complex::new(a, b));
        (pitch.chain(roll).collect(), vec![self.sine(0.7, truth)])
    }

    /// A run about each axis, with a little of the others.
    fn angular_runs(&self) -> Vec<SineRun> {
        let axes = [(0, 0.5, 0.4), (1, 0.6, 2.0), (2, 0.5, -1.1)];
        let run = |(axis, frequency_hz, phase)| {
            let truth = std::array::from_fn(|other| {
                let size = if other == axis {
                    0.8
                } else {
                    0.03 * (other as f64 - 1.5)
                };
                Complex::from_polar(size, phase + other as f64)
            });
            self.sine(frequency_hz, truth)
        };
        axes.map(run).to_vec()
    }

    fn worst(&self, fit: &TriadFit) -> (f64, f64) {
        let off = (fit.sensitivity - self.sensitivity).norm() / self.sensitivity.norm();
        (off, (fit.delay_s - self.delay_s).abs())
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn a_linear_triad_is_recovered_from_holds_and_heave(sensors in sensors()) {
        let (holds, sines) = sensors.linear_runs();
        let fit = fit_triad(&holds, &sines, &NOISE).unwrap();
        let (off, late) = sensors.worst(&fit);
        prop_assert!(off < 1e-9 && late < 1e-11, "{off:e} {late:e}");
        let identity = fit.matrix * sensors.sensitivity;
        prop_assert!((identity - Matrix3::identity()).norm() < 1e-8);

        let at_rest = Vector3::new(0.0, G, 0.0);
        let offset = fit.offset(&(sensors.sensitivity * at_rest + sensors.offset), &at_rest);
        prop_assert!((offset - sensors.offset).norm() < 1e-4, "{offset} for {}", sensors.offset);
    }

    #[test]
    fn an_angular_triad_is_recovered_from_three_sines(sensors in sensors()) {
        let fit = fit_triad(&[], &sensors.angular_runs(), &NOISE).unwrap();
        let (off, late) = sensors.worst(&fit);
        prop_assert!(off < 1e-9 && late < 1e-11, "{off:e} {late:e}");
    }

    #[test]
    fn holds_alone_determine_a_linear_triad_but_no_delay(sensors in sensors()) {
        let (holds, _) = sensors.linear_runs();
        let fit = fit_triad(&holds, &[], &NOISE).unwrap();
        prop_assert!(sensors.worst(&fit).0 < 1e-7);
        prop_assert_eq!(fit.delay_s, 0.0);
    }
}

fn straight() -> Sensors {
    Sensors {
        sensitivity: Matrix3::new(
            1_600.0, 30.0, -20.0, 10.0, -1_500.0, 5.0, -40.0, 25.0, 1_700.0,
        ),
        offset: Vector3::repeat(32_768.0),
        delay_s: 0.004,
    }
}

#[test]
fn runs_that_leave_an_axis_out_are_refused() {
    let sensors = straight();
    let (holds, _) = sensors.linear_runs();
    let angular = sensors.angular_runs();
    let undetermined = |what: &str, holds: &[Hold], sines: &[SineRun]| {
        let found = fit_triad(holds, sines, &NOISE);
        assert_eq!(found.err(), Some(TriadError::Undetermined), "{what}");
    };
    undetermined("nothing", &[], &[]);
    undetermined("one pose", &holds[..1], &[]);
    undetermined("pitch without roll", &holds[..4], &[]);
    // At the same roll, the signal along the third axis is a constant share of the second, up to rounding.
    let vertical = [0.0, 0.01_f64.cos(), -0.01_f64.sin()];
    let heave = sensors.sine(0.7, vertical.map(|part| Complex::new(1.5, 0.4) * part));
    undetermined("pitch and heave without roll", &holds[..4], &[heave]);
    undetermined("one sine", &[], &angular[..1]);

    // Two axes in the plane across (1, 2, −1.5), rounded: no number is exactly zero, and still one direction is
    // missing.
    let in_plane = |frequency_hz: f64, a: f64, b: f64| {
        let (one, other) = (
            Vector3::new(2.0, -1.0, 0.0) / 3.0,
            Vector3::new(1.5, 0.0, 1.0) / 7.0,
        );
        let axis = one * a + other * b;
        let turn = Complex::from_polar(1.0, 0.3 * a + b);
        sensors.sine(
            frequency_hz,
            [axis.x, axis.y, axis.z].map(|part| turn * part),
        )
    };
    let plane = [
        in_plane(0.5, 1.0, 0.1),
        in_plane(0.6, 0.3, -0.9),
        in_plane(0.7, 0.7, 0.7),
    ];
    undetermined("three sines in a plane", &[], &plane);
}

#[test]
fn sensors_that_read_alike_are_refused() {
    let mut sensors = straight();
    for copy in [1.0, -0.5] {
        let first = sensors.sensitivity.row(0) * copy;
        sensors.sensitivity.set_row(2, &first);
        let found = fit_triad(&[], &sensors.angular_runs(), &NOISE);
        assert_eq!(
            found.err(),
            Some(TriadError::Singular),
            "by a factor of {copy}"
        );
        let (holds, sines) = sensors.linear_runs();
        assert_eq!(
            fit_triad(&holds, &sines, &NOISE).err(),
            Some(TriadError::Singular)
        );
    }
    sensors
        .sensitivity
        .set_row(2, &nalgebra::RowVector3::zeros());
    let dead = fit_triad(&[], &sensors.angular_runs(), &NOISE);
    assert_eq!(
        dead.err(),
        Some(TriadError::Singular),
        "a sensor that is not connected"
    );
}

#[test]
fn a_hold_of_a_third_run_is_refused() {
    let (mut holds, sines) = straight().linear_runs();
    holds[3].run = 2;
    let refused = fit_triad(&holds, &sines, &NOISE).unwrap_err();
    assert_eq!(refused, TriadError::Run { run: 2 });
    assert_eq!(refused.to_string(), "a hold names run 2; there are 2");
}

#[test]
fn what_is_not_a_number_is_refused() {
    let sensors = straight();
    for bad in [f64::NAN, f64::INFINITY] {
        let (mut holds, mut sines) = sensors.linear_runs();
        sines[0].counts[1].im = bad;
        assert!(fit_triad(&holds, &sines, &NOISE).is_err());
        holds[2].truth.x = bad;
        assert!(fit_triad(&holds, &[], &NOISE).is_err());
        let noise = Noise {
            density: [bad; 3],
            walk: [0.0; 3],
        };
        assert!(fit_triad(&[], &sensors.angular_runs(), &noise).is_err());
    }
}
