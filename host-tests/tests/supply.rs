//! The mean of the supply readings: what a working board has enters it, and nothing else does.

use hexsense_core::sampling::supply::{READINGS, SupplyMean, SupplyReading};

/// VREFINT is 1.212 V: its code was 1655 at 3.0 V, and a reading of it is sixteen times its code at the supply.
const CALIBRATION: f32 = 1_655.0;
const AT_3V3: f32 = 16.0 * 1.212 / 3.3 * 4_096.0;

/// The supply factor that a sum of codes stands for.
fn factor(code: f32) -> f32 {
    3.0 * CALIBRATION * 16.0 / code / 3.3
}

fn settled() -> SupplyMean {
    let mut mean = SupplyMean::new();
    for _ in 0..READINGS {
        assert!(mean.take(Some((1.0, 30.0))));
    }
    mean
}

#[test]
fn sixteen_readings_are_averaged_and_each_later_one_enters_by_a_sixteenth() {
    let mut mean = SupplyMean::new();
    for (reading, expected) in [(1.0, 1.0), (1.03, 1.015), (0.985, 1.005)] {
        assert!(mean.take(Some((reading, 30.0))));
        assert!((mean.reading().factor - expected).abs() < 1e-6);
    }
    assert_eq!(mean.reading().readings, 3);
    let mut mean = settled();
    for _ in 0..3 {
        mean.take(Some((1.016, 46.0)));
    }
    // 1 − (15/16)³ of the way.
    let way = 0.176_025_4;
    let SupplyReading {
        factor,
        temperature_c,
        readings,
        is_old,
    } = mean.reading();
    assert!((factor - (1.0 + 0.016 * way)).abs() < 1e-6, "{factor}");
    assert!((temperature_c - (30.0 + 16.0 * way)).abs() < 1e-4);
    assert_eq!((readings, is_old), (READINGS, false));
}

#[test]
fn codes_that_no_working_board_has_leave_the_mean_as_it_was() {
    let wrong = [
        0.0,
        1.0,
        16.0,
        65_520.0,
        65_535.0,
        2.0 * AT_3V3,
        AT_3V3 / 2.0,
        1.15 * AT_3V3,
        AT_3V3 / 1.15,
    ];
    let wrong = wrong.map(|code| (factor(code), 30.0));
    let no_numbers = [(f32::NAN, 30.0), (-1.0, 30.0), (1.0, f32::NAN)];
    let no_temperatures = [-60.0, 150.0, f32::INFINITY].map(|celsius| (1.0, celsius));
    let mut mean = settled();
    let before = mean.reading();
    for reading in wrong.iter().chain(&no_numbers).chain(&no_temperatures) {
        assert!(!mean.take(Some(*reading)), "{reading:?}");
        assert_eq!(mean.reading(), before, "{reading:?}");
        // A good one in between: none of them makes the mean old by itself.
        assert!(mean.take(Some((1.0, 30.0))));
    }
    // 3.0 V and 3.6 V.
    for code in [1.1 * AT_3V3, AT_3V3 / 1.09] {
        assert!(mean.take(Some((factor(code), 30.0))), "{code}");
    }
}

#[test]
fn the_mean_is_old_when_no_good_reading_has_come_for_a_second_and_never_is_no_number() {
    let mut mean = SupplyMean::new();
    assert_eq!(mean.reading(), SupplyReading::NONE);
    assert!(mean.reading().is_old && mean.reading().factor == 1.0);
    mean.take(None);
    assert!(mean.reading().is_old);
    mean.take(Some((1.02, 30.0)));
    assert!(!mean.reading().is_old);
    // Ten a second.
    for number in 1..1_000 {
        mean.take(Some((f32::INFINITY, f32::NAN)));
        assert_eq!(mean.reading().is_old, number >= 10, "{number}");
        assert_eq!(mean.reading().factor, 1.02);
    }
    mean.take(Some((1.02, 30.0)));
    assert!(!mean.reading().is_old);
}
