use super::*;
use crate::analysis::results::{ChannelResult, Measured};

/// Each number of three is another: estimate, U, 95 %.
fn measured([estimate, expanded_uncertainty, interval_95]: [f64; 3]) -> Measured {
    Measured {
        estimate,
        expanded_uncertainty,
        interval_95,
    }
}

fn channel(name: &str, unit: &str, offset: [f64; 3], gain: [f64; 3]) -> ChannelResult {
    ChannelResult {
        name: name.to_owned(),
        unit: unit.to_owned(),
        offset: measured(offset),
        gain: measured(gain),
        cross: [1e-7, 2e-7, 3e-7].map(|cross| measured([cross, 0.1 * cross, 0.09 * cross])),
        sensitivity: 1.0 / gain[0],
        budget: Vec::new(),
        noise_density: 0.0123,
        rest_uncertainty: 0.0234,
        bias_walk: 0.0345,
    }
}

#[test]
fn offset_gain_and_sensitivity_stand_with_their_uncertainty_and_unit_in_the_order_of_the_head() {
    let results = Results {
        channels: vec![
            channel("ax", "m/s²", [32_100.0, 12.0, 11.0], [5e-4, 1e-6, 9e-7]),
            channel("ey", "rad/s²", [31_500.5, 7.8, 7.4], [-1e-4, 3e-7, 2e-7]),
            channel(
                "wz",
                "rad/s",
                [34_200.25, 0.78, 0.75],
                [6.4e-5, 1.408e-6, 1.2e-6],
            ),
        ],
        delays_s: [[1e-3, 2e-4, 1e-4]; 3].map(measured),
        gravity_m_s2: measured([9.8, 0.02, 0.01]),
        lever_arm_m: [[0.4, 0.05, 0.04]; 3].map(measured),
        second_harmonics: Vec::new(),
        warnings: Vec::new(),
        scans: 99,
        checks: Vec::new(),
    };
    let expected = "
channel  offset u0, counts       k, unit per count                    S, counts per unit
ax       32100.00 ± 12.00       5.000000e-4 ± 1.00e-6   m/s²         2000.000
ey       31500.50 ± 7.80       -1.000000e-4 ± 3.00e-7   rad/s²     -10000.000
wz       34200.25 ± 0.78        6.400000e-5 ± 1.41e-6   rad/s       15625.000
± is the expanded uncertainty, coverage factor 2

";
    assert_eq!(table(&results), expected);
}
