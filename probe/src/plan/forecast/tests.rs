use super::*;
use hexsense_core::calibration::budget::Distribution;
use hexsense_core::calibration::triad::TriadFit;
use nalgebra::{Matrix3, Vector3};

/// An estimate with these three diagonals; beside them are larger elements.
fn estimate(diagonals: [[f64; 3]; 3]) -> Estimate {
    let fit = |[x, y, z]: [f64; 3]| TriadFit {
        sensitivity: Matrix3::identity(),
        matrix: Matrix3::new(x, 7.0, 8.0, 9.0, y, 10.0, 11.0, 12.0, z),
        delay_s: 0.0,
        delay_shares: [0.2, 0.3, 0.5],
        delay_noise_s: 0.0,
        row_covariance: [Matrix3::identity(); 3],
    };
    Estimate {
        fits: diagonals.map(fit),
        offsets: [Vector3::zeros(); 3],
        home: Vector3::zeros(),
        lever_arm_m: Vector3::zeros(),
        lever_arm_noise_m: Vector3::zeros(),
    }
}

/// Standard uncertainties of 3 by noise and 4 by the clock, or the other way round, so that both are 5.
fn budgets() -> Budgets {
    let mut budgets = Budgets::default();
    for channel in 0..9 {
        let (triad, axis) = (channel / 3, channel % 3);
        let size = 1e-3 * (1.0 + channel as f64);
        let (noise, clock) = if channel % 2 == 0 {
            (3.0, 4.0)
        } else {
            (4.0, 3.0)
        };
        let budget = &mut budgets.matrix[triad][axis][axis];
        budget.add(Cause::SensorNoise, Distribution::Normal, noise * size);
        budget.add(Cause::Clock, Distribution::Uniform, clock * size);
    }
    budgets
}

#[test]
fn a_gain_is_told_with_twice_its_standard_uncertainty_and_its_largest_cause() {
    let known = [[1.0, -2.0, 4.0], [5.0, 8.0, -10.0], [16.0, 20.0, 25.0]];
    let mut tilted = known;
    tilted[0][1] = -2.5;
    tilted[2][2] = 26.0;
    let (known, tilted) = (estimate(known), estimate(tilted));
    // 2·5·size over the gain, and 2·4·size over the gain.
    let expected = [
        ("ax", 0.010, Cause::Clock, 0.008, 0.0),
        ("ay", 0.010, Cause::SensorNoise, 0.008, -0.25),
        ("az", 0.0075, Cause::Clock, 0.006, 0.0),
        ("ex", 0.008, Cause::SensorNoise, 0.0064, 0.0),
        ("ey", 0.00625, Cause::Clock, 0.005, 0.0),
        ("ez", 0.006, Cause::SensorNoise, 0.0048, 0.0),
        ("wx", 0.004375, Cause::Clock, 0.0035, 0.0),
        ("wy", 0.004, Cause::SensorNoise, 0.0032, 0.0),
        ("wz", 0.0036, Cause::Clock, 0.00288, 0.04),
    ];
    for (channel, (name, uncertainty, cause, contribution, tilt_change)) in
        expected.into_iter().enumerate()
    {
        let gain = gain(channel, &known, &tilted, &budgets());
        assert_eq!((gain.channel, gain.cause), (name, cause));
        for (found, expected) in [
            (gain.uncertainty, uncertainty),
            (gain.contribution, contribution),
            (gain.tilt_change, tilt_change),
        ] {
            assert!((found - expected).abs() < 1e-12, "{gain:?}");
        }
    }
}

fn known(channel: &'static str, uncertainty: f64, tilt_change: f64) -> Gain {
    Gain {
        channel,
        uncertainty,
        cause: Cause::Hinges,
        contribution: 0.021,
        tilt_change,
    }
}

#[test]
fn the_advice_names_the_run_that_moves_the_channel() {
    for (channel, remedy) in [
        ("ax", "tilt further in pitch"),
        ("ay", "make the heave sine larger, faster or longer"),
        ("az", "tilt further in roll"),
        ("ex", "make the roll sine larger, faster or longer"),
        ("ey", "make the yaw sine larger, faster or longer"),
        ("ez", "make the pitch sine larger, faster or longer"),
        ("wx", "make the roll sine larger, faster or longer"),
        ("wy", "make the yaw sine larger, faster or longer"),
        ("wz", "make the pitch sine larger, faster or longer"),
    ] {
        let expected =
            format!("{channel} is ill-determined: ± 3.4 %, hinge places alone ± 2.1 %; {remedy}");
        assert_eq!(advice(&known(channel, 0.034, 0.0), true), Some(expected));
    }
    let expected = "ay is ill-determined: 1.2 % per 0.1° of pitch and roll error; add a heave sine";
    assert_eq!(
        advice(&known("ay", 0.001, -0.012), false).as_deref(),
        Some(expected)
    );
}

#[test]
fn a_gain_is_ill_determined_from_just_above_one_percent_on() {
    let limit = 0.01_f64;
    assert_eq!(advice(&known("ex", limit, limit), true), None);
    assert_eq!(advice(&known("ay", limit, -limit), true), None);
    let sensitive =
        "ay is ill-determined: 1.0 % per 0.1° of pitch and roll error; make the heave sine larger";
    for tilt_change in [limit.next_up(), -limit.next_up()] {
        let said = advice(&known("ay", limit, tilt_change), true).unwrap();
        assert!(said.starts_with(sensitive), "{said}");
    }
    let said = advice(&known("wy", limit.next_up(), 0.0), true).unwrap();
    assert!(
        said.starts_with("wy is ill-determined: ± 1.0 %, hinge places alone ± 2.1 %;"),
        "{said}"
    );
    // Without a heave sine ay has no sine at all, however small its numbers.
    assert!(advice(&known("ay", 0.0, 0.0), false).is_some());
    assert_eq!(advice(&known("az", 0.0, 0.0), false), None);
}
