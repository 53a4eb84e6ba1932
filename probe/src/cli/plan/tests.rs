use super::*;
use crate::plan::conditioning::Conditioning;
use crate::plan::forecast::Gain;
use crate::plan::hinges::{HingeUse, Joint};
use crate::plan::uses::Uses;
use hexsense_core::calibration::budget::Cause;

const PLAN: &str = r#"
geometry = "an-74tk-200"
geometry_sha256 = "00"
period_s = 0.002

[[run]]
name = "zero"
purpose = "calibrate"
rest_s = 9.0

[[run]]
name = "lift"
purpose = "characterise"
[[run.ramps]]
freedom = "heave"
levels_m = [0.06, -0.08, 0.0]
step_s = 4.0
shape = "linear"

[[run]]
name = "both"
purpose = "verify"
[[run.sine]]
freedom = "surge"
amplitude_m = 0.04
frequency_hz = 0.3
fade_s = 2.0
settle_s = 1.0
estimate_s = 5.5
[[run.sine]]
freedom = "yaw"
amplitude_deg = 2.5
frequency_hz = 0.2
fade_s = 2.0
settle_s = 1.0
estimate_s = 5.0
"#;

fn used(jack: usize, [time_s, value, limit, fraction]: [f64; 4]) -> Use {
    Use {
        jack,
        time_s,
        value,
        limit,
        fraction,
    }
}

/// Three runs: at rest without limits, one that is closest by a jack, and one that could be by a hinge.
fn checked(hinge_deg: f64) -> [Checked; 3] {
    let none = used(1, [0.0, 0.0, f64::INFINITY, 0.0]);
    let conditioning = |time_s, condition, bound| Conditioning {
        time_s,
        condition,
        bound,
    };
    [
        Checked {
            uses: Uses {
                length: used(1, [0.5, 2.75, 3.4, 0.01]),
                speed: none,
                acceleration: none,
            },
            hinge: None,
            conditioning: conditioning(0.25, 6.54, 6.78),
        },
        Checked {
            uses: Uses {
                length: used(2, [1.5, 3.1, 3.4, 0.35]),
                speed: used(3, [2.5, -0.62, 1.0, 0.62]),
                acceleration: used(4, [3.5, 8.1234, 10.0, 0.81]),
            },
            hinge: None,
            conditioning: conditioning(4.5, 12.34, 15.67),
        },
        Checked {
            uses: Uses {
                length: used(5, [5.5, 2.2, 2.1, 0.44]),
                speed: used(6, [6.5, 0.55, 1.0, 0.55]),
                acceleration: used(1, [7.5, 6.6, 10.0, 0.66]),
            },
            hinge: Some(HingeUse {
                joint: Joint::Upper,
                jack: 6,
                time_s: 8.5,
                angle_deg: hinge_deg,
                limit_deg: 30.0,
            }),
            conditioning: conditioning(9.25, 13.45, 14.56),
        },
    ]
}

#[test]
fn what_every_run_uses_stands_in_its_column() {
    let plan = Movements::parse("plan.toml", PLAN).unwrap();
    let geometry = GeometryFile::load("an-74tk-200").unwrap();
    let lines = "\
an-74tk-200: jacks 2.1 to 3.4 m, home at 2.1298 m, at most 1 m/s, 10 m/s²

run          for          movement                     time     stroke  speed  accel.  hinges  cond(J)
zero         calibrate    rest at home                  9.0 s     1 %      -       -       -     6.54
lift         characterise heave ramps to ±0.08 m       12.0 s    35 %   62 %    81 %       -    12.34
both         verify       surge 0.04 m at 0.3 Hz       10.5 s    44 %   55 %    66 %    80 %    13.45
                          yaw 2.5° at 0.2 Hz

";
    let held = format!(
        "largest cond(J): run lift, 12.34 at 4.50 s, below 15.67 between samples (limit {MAX_CONDITION}); lengths over \
         the mean\nradius of the upper hinges, so that it has no unit\n"
    );
    let jack = "closest to a limit: run lift, jack 4 at 3.50 s, acceleration 8.1234 m/s² (limit 10.0000 m/s²)\n";
    assert_eq!(
        table(&plan, &checked(24.0), &geometry),
        format!("{lines}{jack}{held}")
    );
    // 24.6° of 30° are 82 %.
    let hinge = "closest to a limit: run both, jack 6 at 8.50 s, upper hinge 24.60° (limit 30°)\n";
    let expected = format!("{}{hinge}{held}", lines.replace("80 %", "82 %"));
    assert_eq!(table(&plan, &checked(24.6), &geometry), expected);
}

#[test]
fn every_predicted_gain_has_its_expanded_uncertainty_largest_cause_and_change() {
    let gain = |channel, cause, [uncertainty, contribution, tilt_change]: [f64; 3]| Gain {
        channel,
        uncertainty,
        cause,
        contribution,
        tilt_change,
    };
    let forecast = Forecast {
        gains: vec![
            gain("ax", Cause::Hinges, [0.0123, 0.0098, -0.0045]),
            gain("wz", Cause::Bandwidth, [0.0034, 0.0021, 0.0007]),
        ],
        advice: vec!["tilt it".to_owned(), "turn it".to_owned()],
    };
    let expected = "\
predicted expanded uncertainty of the gains (k = 2), by geometry and sensor file; last column: change of the gain
if the base tilts 0.1° further on the holds than the jacks say

gain  uncertainty  mostly by                    0.1° of tilt
ax         1.23 %  hinge places 0.98 %               0.45 %
wz         0.34 %  sensor bandwidth 0.21 %           0.07 %
advice: tilt it
advice: turn it
";
    assert_eq!(predicted(&forecast), expected);
}
