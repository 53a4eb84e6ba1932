//! What people and programs read of a set: no two of its numbers are alike.

use super::*;
use hexsense_core::records::{BuildId, JackCoefficients, MotionBase, TriadCoefficients};
use serde_json::json;

fn triad(offset: [f32; 3], gains: [f32; 3], delay_s: f32) -> TriadCoefficients {
    let [x, y, z] = gains;
    TriadCoefficients {
        offset,
        matrix: [[x, 1e-6, 2e-6], [3e-6, y, 4e-6], [5e-6, 6e-6, z]],
        offset_uncertainty: [6.5, 1.75, 0.25],
        matrix_uncertainty: [
            [5e-7, 1e-8, 2e-8],
            [3e-8, 1.25e-6, 4e-8],
            [5e-8, 6e-8, 3e-6],
        ],
        delay_s,
    }
}

fn sources() -> Sources {
    Sources {
        captures_sha256: "0a".repeat(32),
        programs_sha256: "0b".repeat(32),
        geometry_sha256: "0c".repeat(32),
        sensors_sha256: "0d".repeat(32),
    }
}

fn set() -> CoefficientSet {
    CoefficientSet {
        board: *b"another one.",
        geometry: "base seven".try_into().unwrap(),
        geometry_hash: [1, 2, 3, 4, 5, 6, 7, 8],
        unix_s: 1_780_000_000,
        temperature_c: 27.3,
        provenance: sources().provenance(),
        ratiometric: Default::default(),
        build: Some(BuildId([0x0d, 1, 2, 3, 4, 5, 6, 0xe7])),
        triads: [
            triad([32_100.5, 32_850.25, 33_000.75], [5e-4, 4e-4, 8e-4], 0.0015),
            triad(
                [31_000.5, 31_500.25, 31_999.75],
                [-2e-4, 1e-4, 2.5e-4],
                -0.0023,
            ),
            triad(
                [34_000.5, 34_100.25, 34_200.75],
                [1.6e-5, 3.2e-5, 6.4e-5],
                0.0047,
            ),
        ],
        base: MotionBase {
            lower: [
                [1.35, 0.01, -1.73],
                [1.36, 0.02, 1.74],
                [0.82, 0.03, 2.04],
                [-2.18, 0.04, 0.31],
                [-2.17, 0.05, -0.3],
                [0.83, 0.06, -2.03],
            ],
            upper: [
                [1.5, -0.01, -0.02],
                [1.51, -0.02, 0.03],
                [-0.75, -0.03, 1.31],
                [-0.76, -0.04, 1.32],
                [-0.74, -0.05, -1.29],
                [-0.73, -0.06, -1.28],
            ],
            length_min_m: 2.1,
            length_max_m: 3.4,
            home_height_m: 2.13,
        },
        jacks: JackCoefficients {
            zero_length_m: 2.75,
            zero_counts: [32_701.5, 32_702.5, 32_703.5, 32_704.5, 32_705.5, 32_706.5],
            metres_per_count: [2.1e-5, 2.2e-5, 2.3e-5, 2.4e-5, 2.5e-5, 2.6e-5],
        },
    }
}

#[test]
fn the_tables_have_offset_gain_sensitivity_and_twice_the_stored_uncertainty() {
    let table = table(&set());
    let lines: Vec<String> = table
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect();
    let expected = [
        "channel offset u0, counts gain M_ii, unit/count sensitivity, counts/unit",
        "ax 32100.50 ± 13.00 5.000000e-4 ± 1.00e-6 m/s² 2000.000",
        "ay 32850.25 ± 3.50 4.000000e-4 ± 2.50e-6 m/s² 2500.000",
        "az 33000.75 ± 0.50 8.000000e-4 ± 6.00e-6 m/s² 1250.000",
        "ex 31000.50 ± 13.00 -2.000000e-4 ± 1.00e-6 rad/s² -5000.000",
        "ey 31500.25 ± 3.50 1.000000e-4 ± 2.50e-6 rad/s² 10000.000",
        "ez 31999.75 ± 0.50 2.500000e-4 ± 6.00e-6 rad/s² 4000.000",
        "wx 34000.50 ± 13.00 1.600000e-5 ± 1.00e-6 rad/s 62500.000",
        "wy 34100.25 ± 3.50 3.200000e-5 ± 2.50e-6 rad/s 31250.000",
        "wz 34200.75 ± 0.50 6.400000e-5 ± 6.00e-6 rad/s 15625.000",
        "± is the expanded uncertainty, coverage factor 2",
        "",
        "base base seven: jacks 2.1000 m to 3.4000 m, O at 2.1300 m at home",
        "jack lower hinge x, y, z, m upper hinge x, y, z, m 2.7500 m at, counts mm per count",
        "jack1 1.3500 0.0100 -1.7300 1.5000 -0.0100 -0.0200 32701.50 0.021000",
        "jack2 1.3600 0.0200 1.7400 1.5100 -0.0200 0.0300 32702.50 0.022000",
        "jack3 0.8200 0.0300 2.0400 -0.7500 -0.0300 1.3100 32703.50 0.023000",
        "jack4 -2.1800 0.0400 0.3100 -0.7600 -0.0400 1.3200 32704.50 0.024000",
        "jack5 -2.1700 0.0500 -0.3000 -0.7400 -0.0500 -1.2900 32705.50 0.025000",
        "jack6 0.8300 0.0600 -2.0300 -0.7300 -0.0600 -1.2800 32706.50 0.026000",
    ];
    assert_eq!(lines, expected);
}

#[test]
fn the_document_has_every_number_under_its_key() {
    let set = set();
    let triad = |offset: [f64; 3], [x, y, z]: [f64; 3], delay_s: f64| {
        json!({
            "offset_counts": offset,
            "offset_standard_uncertainty": [6.5, 1.75, 0.25],
            "matrix_unit_per_count": [[x, 1e-6, 2e-6], [3e-6, y, 4e-6], [5e-6, 6e-6, z]],
            "matrix_standard_uncertainty": [[5e-7, 1e-8, 2e-8], [3e-8, 1.25e-6, 4e-8], [5e-8, 6e-8, 3e-6]],
            "delay_s": delay_s,
        })
    };
    let mut buffer = [0; MAX_ENCODED];
    let id = CoefficientSet::id_of(set.encode(&mut buffer).unwrap()).to_string();
    let mut expected = json!({
        "format": "hexsense coefficients, version 3",
        "id": id,
        // "another one." in ASCII.
        "board": "616e6f74686572206f6e652e",
        "geometry": "base seven",
        "geometry_hash": "0102030405060708",
        "date_utc": "2026-05-28T20:26:40Z",
        "temperature_c": 27.3,
        // By sha256sum, of the four digests with a line feed behind each.
        "provenance_sha256": "a1cbbe37bad28b580344276a4869ae096950fc6a06e17bf91ea5ce58bb8a49fa",
        "firmware_build": "0d010203040506e7",
        "linear_acceleration": triad([32_100.5, 32_850.25, 33_000.75], [5e-4, 4e-4, 8e-4], 0.0015),
        "angular_acceleration": triad([31_000.5, 31_500.25, 31_999.75], [-2e-4, 1e-4, 2.5e-4], -0.0023),
        "angular_rate": triad([34_000.5, 34_100.25, 34_200.75], [1.6e-5, 3.2e-5, 6.4e-5], 0.0047),
        "base": {
            "lower": [
                [1.35, 0.01, -1.73],
                [1.36, 0.02, 1.74],
                [0.82, 0.03, 2.04],
                [-2.18, 0.04, 0.31],
                [-2.17, 0.05, -0.3],
                [0.83, 0.06, -2.03],
            ],
            "upper": [
                [1.5, -0.01, -0.02],
                [1.51, -0.02, 0.03],
                [-0.75, -0.03, 1.31],
                [-0.76, -0.04, 1.32],
                [-0.74, -0.05, -1.29],
                [-0.73, -0.06, -1.28],
            ],
            "length_min": 2.1,
            "length_max": 3.4,
            "home_height": 2.13,
        },
        "jacks": {
            "zero_length": 2.75,
            "zero_counts": [32_701.5, 32_702.5, 32_703.5, 32_704.5, 32_705.5, 32_706.5],
            "metres_per_count": [2.1e-5, 2.2e-5, 2.3e-5, 2.4e-5, 2.5e-5, 2.6e-5],
        },
    });
    let document = to_json(&set).unwrap();
    assert_eq!(document, expected);
    // The file has the same keys and the sources, and what is read from it is the set.
    expected["sources"] = json!({
        "captures_sha256": "0a".repeat(32),
        "programs_sha256": "0b".repeat(32),
        "geometry_sha256": "0c".repeat(32),
        "sensors_sha256": "0d".repeat(32),
    });
    let text = toml::to_string(&toml_value(&expected)).unwrap();
    let read = (set, sources());
    assert_eq!(parse("coefficients.toml", &text).unwrap(), read);
    let again = to_text("again.toml", &read.0, &read.1).unwrap();
    assert_eq!(parse("again.toml", &again).unwrap(), read);
}

/// The same value in TOML. Serde alone would not do: with the feature `arbitrary_precision`, which a package of the
/// workspace may turn on, it writes numbers of JSON as tables.
fn toml_value(value: &serde_json::Value) -> toml::Value {
    use serde_json::Value;
    match value {
        Value::Object(map) => map
            .iter()
            .map(|(key, value)| (key.clone(), toml_value(value)))
            .collect::<toml::Table>()
            .into(),
        Value::Array(values) => values.iter().map(toml_value).collect::<Vec<_>>().into(),
        Value::String(text) => text.clone().into(),
        number => match number.as_i64() {
            Some(whole) => whole.into(),
            None => number.as_f64().unwrap().into(),
        },
    }
}
