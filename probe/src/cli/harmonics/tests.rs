use super::*;
use crate::cli::documents::assert_same;
use hexsense_core::harmonics::Uncertainty;
use hexsense_core::sampling::BlockSize;

/// Channel `c`: in every column another number, which grows with the channel and the harmonic.
fn fit(c: f64) -> ChannelHarmonics {
    let harmonic = |first: f64, step: f64| std::array::from_fn(|k| first + step * k as f64);
    ChannelHarmonics {
        offset: 30_000.0 + 100.0 * c,
        drift: -2.0 - 0.1 * c,
        amplitude: harmonic(1000.0 + 10.0 * c, 1.0),
        phase: harmonic(0.5 + 0.01 * c, 0.001),
        residual_rms: 5.0 + 0.01 * c,
        distortion: 0.01 + 0.001 * c,
        uncertainty: Uncertainty {
            offset: 10.0 + c,
            drift: 0.1 + 0.01 * c,
            amplitude: harmonic(1.0 + 0.1 * c, 0.02),
            phase: harmonic(0.010 + 0.001 * c, 0.0002),
        },
    }
}

fn found() -> Found {
    Found {
        rate_hz: 2_000,
        // 2000 Hz / 8192.
        drive: Drive {
            increment: 1 << 51,
            block: BlockSize::Four,
            settle_blocks: 17,
            blocks: 1_500,
        },
        first_scan: 777,
        fits: (0..15).map(|channel| fit(f64::from(channel))).collect(),
        // Y moves most and Z more than a tenth of it; of the turns only roll does.
        motion: Some(Ok(Motion {
            amplitude: [0.001, 0.05, 0.006, 0.02, 0.001, 0.0001],
            factors: [
                1.25e-4, 2.5e-4, 3.75e-4, 5e-4, 6.25e-4, 7.5e-4, 8.75e-4, 1e-3, 1.125e-3,
            ],
        })),
    }
}

const CHANNEL_NAMES: [&str; 15] = [
    "ax", "ay", "az", "ex", "ey", "ez", "wx", "wy", "wz", "jack1", "jack2", "jack3", "jack4",
    "jack5", "jack6",
];

#[test]
fn every_figure_of_every_channel_stands_in_its_column() {
    let text = found().table();
    let lines: Vec<String> = text
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect();
    // 1500 blocks of 4 scans are 3 s.
    assert_eq!(
        lines[0],
        "0.244141 Hz over 3.000 s from scan 777, in blocks of 4; counts, ± standard uncertainty"
    );
    assert_eq!(
        lines[2],
        "channel offset drift amplitude phase, rad THD, % rms"
    );
    for (c, name) in CHANNEL_NAMES.iter().enumerate() {
        let expected = format!(
            "{name} {} ± {} −{:.2} ± 0.{} {}.0 ± {:.1} 0.{} ± 0.0{} {:.2} 5.{c:02}",
            30_000 + 100 * c,
            10 + c,
            2.0 + 0.1 * c as f64,
            10 + c,
            1_000 + 10 * c,
            1.0 + 0.1 * c as f64,
            500 + 10 * c,
            10 + c,
            1.0 + 0.1 * c as f64,
        );
        assert_eq!(lines[3 + c], expected);
    }
    let motion = [
        "",
        "motion by the jacks: X 0.0010000 m, Y 0.050000 m, Z 0.0060000 m, roll 0.020000 rad, yaw 0.0010000 rad, \
         pitch 0.00010000 rad",
        "ay 2.50000e-4 m/s² per count",
        "az 3.75000e-4 m/s² per count",
        "ex 5.00000e-4 rad/s² per count",
        "wx 8.75000e-4 rad/s per count",
    ];
    assert_eq!(lines[18..], motion);
}

#[test]
fn without_a_motion_the_table_says_why() {
    let mut found = found();
    found.motion = None;
    assert!(
        found
            .table()
            .ends_with("\nno motion: the board has no coefficients; calibrate and upload a set\n")
    );
    assert_eq!(found.to_json()["motion"], Value::Null);
    found.motion = Some(Err(PoseRefusal::NotFinite { jack: 4 }));
    let why = "the length of jack 4 is not a finite number; check the supply of the board";
    assert!(found.table().ends_with(&format!("\nno motion: {why}\n")));
    assert_eq!(found.to_json()["motion"], json!({"refusal": why}));
}

#[test]
fn the_document_has_every_figure_of_every_harmonic_under_its_key() {
    let channels = CHANNEL_NAMES.iter().enumerate().map(|(c, name)| {
        let c = c as f64;
        let harmonics = [0.0, 1.0, 2.0, 3.0, 4.0].map(|k| {
            json!({
                "amplitude": 1000.0 + 10.0 * c + k,
                "amplitude_uncertainty": 1.0 + 0.1 * c + 0.02 * k,
                "phase_rad": 0.5 + 0.01 * c + 0.001 * k,
                "phase_uncertainty_rad": 0.010 + 0.001 * c + 0.0002 * k,
            })
        });
        json!({
            "channel": name,
            "offset": 30_000.0 + 100.0 * c,
            "offset_uncertainty": 10.0 + c,
            "drift": -2.0 - 0.1 * c,
            "drift_uncertainty": 0.1 + 0.01 * c,
            "harmonics": harmonics,
            "distortion": 0.01 + 0.001 * c,
            "residual_rms": 5.0 + 0.01 * c,
        })
    });
    let factor = |channel: &str, per_count: f32, unit: &str| json!({"channel": channel, "per_count": per_count, "unit": unit});
    let expected = json!({
        "frequency_hz": 0.244_140_625,
        "first_scan": 777,
        "block": 4,
        "blocks": 1_500,
        "channels": channels.collect::<Vec<_>>(),
        "motion": {
            "displacement_m": [0.001_f32, 0.05_f32, 0.006_f32],
            "rotation_rad": [0.02_f32, 0.001_f32, 0.0001_f32],
            "factors": [
                factor("ay", 2.5e-4, "m/s²"),
                factor("az", 3.75e-4, "m/s²"),
                factor("ex", 5e-4, "rad/s²"),
                factor("wx", 8.75e-4, "rad/s"),
            ],
        },
    });
    assert_same(&found().to_json(), &expected);
}
