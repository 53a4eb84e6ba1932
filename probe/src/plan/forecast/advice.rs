use super::*;

/// A gain that is known well: by half of a percent, and sure of its tilt.
fn good(channel: &'static str) -> Gain {
    Gain {
        channel,
        uncertainty: 0.005,
        cause: Cause::Gravity,
        contribution: 0.003,
        tilt_change: 0.002,
    }
}

const REMEDIES: [(&str, &str); 9] = [
    ("ax", "tilt further in pitch"),
    ("ay", "make the heave sine larger, faster or longer"),
    ("az", "tilt further in roll"),
    ("ex", "make the roll sine larger, faster or longer"),
    ("ey", "make the yaw sine larger, faster or longer"),
    ("ez", "make the pitch sine larger, faster or longer"),
    ("wx", "make the roll sine larger, faster or longer"),
    ("wy", "make the yaw sine larger, faster or longer"),
    ("wz", "make the pitch sine larger, faster or longer"),
];

#[test]
fn a_gain_known_to_one_hundredth_is_determined_and_the_next_larger_uncertainty_is_not() {
    for (channel, remedy) in REMEDIES {
        let with = |uncertainty| {
            let gain = Gain {
                uncertainty,
                ..good(channel)
            };
            advice(&gain, true)
        };
        assert_eq!(with(0.01), None);
        let advised = with(0.01_f64.next_up()).unwrap();
        let expected = format!(
            "{channel} is ill-determined: ± 1.0 %, {} alone ± 0.3 %; {remedy}",
            Cause::Gravity.name()
        );
        assert_eq!(advised, expected);
    }
}

#[test]
fn a_gain_that_a_tilt_changes_by_one_hundredth_is_determined_and_the_next_larger_change_is_not() {
    for (channel, remedy) in REMEDIES {
        for sign in [-1.0, 1.0] {
            let with = |change: f64| {
                let gain = Gain {
                    tilt_change: sign * change,
                    ..good(channel)
                };
                advice(&gain, true)
            };
            assert_eq!(with(0.01), None);
            let expected = format!(
                "{channel} is ill-determined: 1.0 % per 0.1° of pitch and roll error; {remedy}"
            );
            assert_eq!(with(0.01_f64.next_up()).unwrap(), expected);
        }
    }
}

#[test]
fn only_ay_needs_a_heave_sine_however_well_it_seems_to_be_known() {
    for (channel, _) in REMEDIES {
        let advised = advice(&good(channel), false);
        let expected =
            "ay is ill-determined: 0.2 % per 0.1° of pitch and roll error; add a heave sine";
        assert_eq!(advised, (channel == "ay").then(|| expected.to_owned()));
    }
}
