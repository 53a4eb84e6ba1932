use super::*;
use hexsense_core::channel::{CHANNELS, INERTIAL};

/// Two scans from scan 40 on.
fn block(supply: f32, temperature_c: f32, values: [[f32; INERTIAL]; 2]) -> Block {
    let header = Header {
        first_scan: 40,
        scans: 2,
        rate_hz: 1_000,
        supply,
        temperature_c,
        set: None,
        dropped: 0,
        content: StreamContent::default(),
    };
    Block {
        header,
        counts: Some([[0; CHANNELS]; 2].into_iter().collect()),
        values: Some(values.into_iter().collect()),
    }
}

#[test]
fn a_number_that_is_not_finite_is_not_recorded() {
    let good = [[f32::MAX; INERTIAL], [f32::MIN; INERTIAL]];
    check_finite(&block(f32::MIN_POSITIVE, -40.0, good)).unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let said = |block: Block| check_finite(&block).unwrap_err().to_string();
        let supply = said(block(bad, 25.0, good));
        assert!(supply.starts_with(&format!("the supply factor of scan 40 is {bad}")));
        let temperature = said(block(1.0, bad, good));
        assert!(
            temperature.starts_with("the temperature of scan 40"),
            "{temperature}"
        );
        let mut values = good;
        values[1][INERTIAL - 1] = bad;
        let value = said(block(1.0, 25.0, values));
        assert!(value.starts_with("wz of scan 41"), "{value}");
    }
}
