//! Tables 11 and 12: instants and the reference.

use std::f64::consts::TAU;

use hexsense::FACTS;
use hexsense_core::channel::INERTIAL;

use crate::board::{Board, conversion_noise};
use crate::page::{agree, data_sheet, table, three};

#[test]
fn instants_and_phases_are_as_stated() {
    let board = Board::new();
    let held = ((board.ratio - 1.0) / 2.0 * board.conversion_cycles
        + board.sampling_cycles
        + data_sheet("trigger latency"))
        / board.adc_hz;
    let delays_s = [
        f64::from(FACTS.rank_ns) * 1e-9,
        FACTS.instant_s(INERTIAL - 1) - FACTS.instant_s(INERTIAL),
        held - FACTS.instant_s(0),
        1.0 / board.adc_hz,
        data_sheet("jitter of the PLL") * 1e-12,
        0.06e-3,
    ];
    let names = table(11);
    let rows: Vec<_> = delays_s
        .iter()
        .zip(&names)
        .map(|(&delay_s, name)| {
            let phase = TAU * 50.0 * delay_s;
            vec![
                name[0].to_string(),
                three(delay_s * 1e6),
                format!("{phase:.1e}"),
            ]
        })
        .collect();
    agree(11, &rows);
}

#[test]
fn the_reference_is_as_stated() {
    let readings = f64::from(hexsense::SUPPLY_READINGS);
    let code = data_sheet("VREFINT") / f64::from(FACTS.nominal_supply_v) * 4_096.0;
    // One reading is the mean of 256 conversions; a weight of 1/n leaves 1/(2n − 1) of its variance.
    let noise = conversion_noise()
        / f64::from(hexsense::SUPPLY_OVERSAMPLING).sqrt()
        / (2.0 * readings - 1.0).sqrt()
        / code;
    let shift_v = 0.001 * f64::from(FACTS.nominal_supply_v);
    let parts = [
        0.001,
        10.0 * data_sheet("VREFINT, temperature") * 1e-6,
        shift_v * data_sheet("VREFINT, supply") * 1e-6,
        data_sheet("VREFINT, 1000 hours") * 1e-6,
        noise,
    ];
    let names = table(12);
    let rows: Vec<_> = parts
        .iter()
        .zip(&names)
        .map(|(&part, name)| {
            let at_zero = part * f64::from(FACTS.counts_at_supply) / 2.0;
            vec![name[0].to_string(), three(1e6 * part), three(at_zero)]
        })
        .collect();
    agree(12, &rows);
}
