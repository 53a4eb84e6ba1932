//! Tables 11 and 12: instants and the reference.

use std::f64::consts::TAU;

use hexsense_core::channel::{COUNTS_AT_SUPPLY, INERTIAL};
use hexsense_core::sampling::{NOMINAL_SUPPLY_V, RANK_NS, instant_s};

use crate::board::{Board, conversion_noise};
use crate::page::{SUPPLY, agree, between, data_sheet, number, table, three};

#[test]
fn instants_and_phases_are_as_stated() {
    let board = Board::read();
    let held = ((board.ratio - 1.0) / 2.0 * board.conversion_cycles
        + board.sampling_cycles
        + data_sheet("trigger latency"))
        / board.adc_hz;
    let delays_s = [
        f64::from(RANK_NS) * 1e-9,
        instant_s(INERTIAL - 1) - instant_s(INERTIAL),
        held - instant_s(0),
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
    let readings = number(between(SUPPLY, "const AVERAGED: u8 =", ';'));
    let code = data_sheet("VREFINT") / f64::from(NOMINAL_SUPPLY_V) * 4_096.0;
    // One reading is the mean of 256 conversions; a weight of 1/n leaves 1/(2n − 1) of its variance.
    let noise = conversion_noise() / 16.0 / (2.0 * readings - 1.0).sqrt() / code;
    let shift_v = 0.001 * f64::from(NOMINAL_SUPPLY_V);
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
            let at_zero = part * f64::from(COUNTS_AT_SUPPLY) / 2.0;
            vec![name[0].to_string(), three(1e6 * part), three(at_zero)]
        })
        .collect();
    agree(12, &rows);
}
