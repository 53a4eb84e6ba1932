//! Tables 2 to 5: time, sampling time, ratio and clock of the converters.

use hexsense::{
    APPROXIMATION_HALF_CYCLES, FACTS, SUPPLY_CONVERSIONS, SUPPLY_OVERSAMPLING,
    SUPPLY_SAMPLING_HALF_CYCLES,
};
use hexsense_core::channel::{INERTIAL, JACKS};
use hexsense_core::wire::telemetry::SUPPLY_HZ;
use twin::sheet;

use crate::board::{Board, bits, conversion_noise, sensor_density};
use crate::page::{WIRING, agree, data_sheet, number, says, table, yes};

#[test]
fn a_scan_fits_each_period_and_its_pause_is_short() {
    let board = Board::new();
    let scan = board.scan_us(board.ratio, board.sampling_cycles);
    assert!((scan - INERTIAL as f64 * f64::from(FACTS.rank_ns) * 1e-3).abs() < 1e-9);
    let charge = data_sheet("sampling capacitor") * 1e-12;
    let rows = FACTS.rates_hz.map(|rate| {
        let period = 1e6 / f64::from(rate);
        let jacks = scan * JACKS as f64 / INERTIAL as f64;
        let longest = 1e3 * data_sheet("longest trigger period");
        assert!(period <= longest && period - jacks < longest);
        vec![
            rate.to_string(),
            format!("{period:.0}"),
            format!("{scan:.1}"),
            format!("{:.1}", 100.0 * scan / period),
            format!("{:.1}", period - scan),
            format!("{:.1}", period - jacks),
            format!("{:.0}", 1e3 * charge * board.ratio * f64::from(rate) * 1e6),
        ]
    });
    agree(2, &rows);
}

#[test]
fn the_sampling_time_is_the_longest_that_fits_and_allows_the_resistor() {
    let board = Board::new();
    let rows: Vec<_> = table(3)
        .iter()
        .map(|row| {
            let cycles = number(row[0]);
            let fits = board.fits(board.ratio, cycles);
            let chosen = cycles == board.sampling_cycles;
            assert!(!chosen || fits);
            assert!(!fits || cycles <= board.sampling_cycles);
            if chosen {
                let allowed = number(row[2]);
                assert!(
                    WIRING.contains("1 kΩ and 1 µF (film or C0G) in front of each pin")
                        && WIRING.contains("The resistor must not be larger")
                        && 1_000.0 < allowed
                );
            }
            vec![
                row[0].to_string(),
                row[1].to_string(),
                row[2].to_string(),
                format!("{:.2}", cycles / board.adc_hz * 1e6),
                format!("{:.1}", board.scan_us(board.ratio, cycles)),
                yes(fits),
                yes(chosen),
            ]
        })
        .collect();
    agree(3, &rows);
}

#[test]
fn the_ratio_is_the_largest_that_allows_the_resistor() {
    let board = Board::new();
    let accelerometer = sensor_density(&sheet::TRIADS[0]);
    let rows: Vec<_> = [1.0, 4.0, 8.0, 16.0, 32.0]
        .iter()
        .map(|&ratio| {
            let options = table(3);
            let longest = options
                .iter()
                .rfind(|row| board.fits(ratio, number(row[0])))
                .expect("one fits");
            let cycles = number(longest[0]);
            let noise = conversion_noise() / ratio.sqrt();
            let converter = 16.0 * noise * (2.0 / f64::from(FACTS.rates_hz[0])).sqrt();
            let raised = (1.0 + (converter / accelerometer).powi(2)).sqrt() - 1.0;
            let allowed = number(longest[2]);
            assert_eq!(ratio <= board.ratio, allowed > 1_000.0);
            vec![
                format!("{ratio:.0}"),
                format!("{cycles}"),
                format!("{:.1}", board.scan_us(ratio, cycles)),
                format!("{allowed:.0}"),
                format!("{noise:.2}"),
                format!("{:.1}", bits(noise)),
                format!("{:.1}", 100.0 * raised),
                yes(ratio == board.ratio),
            ]
        })
        .collect();
    agree(4, &rows);
}

#[test]
fn the_clock_is_within_the_limits_and_is_the_one_described() {
    let board = Board::new();
    let clock_mhz = board.adc_hz * 1e-6;
    assert!(clock_mhz < data_sheet("clock, all converters, any supply"));
    let chosen: Vec<_> = table(5).into_iter().filter(|row| row[3] == "yes").collect();
    let [chosen] = chosen.as_slice() else {
        panic!("table 5 must say yes once");
    };
    assert!(chosen[0].contains("`PLL1_P`"), "{chosen:?}");
    assert_eq!(number(chosen[1]), clock_mhz);
    let slower_scan = board.scan_us(board.ratio, board.sampling_cycles) * clock_mhz / 25.0;
    says(&format!("a scan takes {slower_scan:.1} µs"));
    says(&format!(
        "prescaler of TIM6 is {:.0}",
        board.trigger_prescaler
    ));
    // Divided by the PLL alone: 300 MHz, and nothing for the converter to divide.
    assert_eq!(300.0 % clock_mhz, 0.0);
    assert_eq!(board.trigger_prescaler, board.core_hz / board.adc_hz);
    let cycles = f64::from(SUPPLY_SAMPLING_HALF_CYCLES + APPROXIMATION_HALF_CYCLES) / 2.0;
    let conversions = f64::from(SUPPLY_CONVERSIONS * SUPPLY_OVERSAMPLING);
    let reading_ms = conversions * cycles / board.adc_hz * 1e3;
    let period_ms = 1_000 / SUPPLY_HZ;
    says(&format!("{reading_ms:.1} ms of every {period_ms} ms"));
    // A trigger always meets the same phase of the converters' clock.
    for rate in FACTS.rates_hz {
        let cycles = board.core_hz / f64::from(rate);
        assert_eq!(cycles % (board.core_hz / board.adc_hz), 0.0);
    }
}
