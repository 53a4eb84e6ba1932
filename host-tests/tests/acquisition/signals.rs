//! Tables 6 to 10: noise, sensors, filters, the capacitor at the pin, interferers.

use hexsense::FACTS;
use std::f64::consts::{PI, TAU};

use twin::{sheet, vibration};

use crate::board::{
    Board, bits, conversion_noise, converter_density, counts_per_volt, full_sine, sensor_density,
};
use crate::page::{agree, data_sheet, number, says, table, three, yes};

#[test]
fn noise_and_bits_are_as_stated() {
    let from_snr = |name| full_sine() / 10_f64.powf(data_sheet(name) / 20.0);
    let count = conversion_noise() / Board::new().ratio.sqrt();
    let amplitude = |rate_hz: u32| count * (2.0 / (3.0 * f64::from(rate_hz))).sqrt();
    let noises = [
        from_snr("SNR at 25 °C"),
        from_snr("SNR, -40 to 125 °C"),
        conversion_noise(),
        count,
        count / 4.0,
        amplitude(FACTS.rates_hz[0]),
        amplitude(FACTS.rates_hz[2]),
    ];
    let names = table(6);
    let rows: Vec<_> = noises
        .iter()
        .zip(&names)
        .map(|(&noise, name)| {
            vec![
                name[0].to_string(),
                three(noise),
                three(16.0 * noise),
                format!("{:.1}", bits(noise)),
            ]
        })
        .collect();
    agree(6, &rows);
    let linearity = data_sheet("integral linearity, -40 to 125 °C");
    says(&format!(
        "{linearity} LSB are {:.0} counts",
        16.0 * linearity
    ));
}

#[test]
fn what_each_sensor_adds_is_as_stated() {
    let [slow, fast] = sheet::BANDWIDTH_HZ;
    let [soft, hard] = sheet::DAMPING;
    // Noise bandwidth of a second-order low-pass: π·f0/(4·ζ).
    let bandwidths = [PI * slow / (4.0 * hard), PI * fast / (4.0 * soft)];
    let over = |density: f64, rate: u32| three(density / converter_density(f64::from(rate)));
    let names = table(7);
    let mut rows: Vec<_> = sheet::TRIADS
        .iter()
        .zip(&names)
        .map(|(triad, name)| {
            let density = sensor_density(triad);
            let [narrow, wide] = bandwidths.map(|hz| three(density * hz.sqrt()));
            vec![
                name[0].to_string(),
                three(triad.volts_per_unit() * counts_per_volt()),
                three(density),
                format!("{narrow} to {wide}"),
                over(density, FACTS.rates_hz[0]),
                over(density, FACTS.rates_hz[2]),
            ]
        })
        .collect();
    let per_metre = sheet::JACK_SPAN_V / data_sheet("stroke of il-96-300") * counts_per_volt();
    let rms = sheet::JACK_NOISE_RMS_M * per_metre;
    let density = rms * (2.0_f64 / 1e3).sqrt();
    rows.push(vec![
        "jack".into(),
        format!("{per_metre:.0}"),
        three(density),
        three(rms),
        over(density, FACTS.rates_hz[0]),
        over(density, FACTS.rates_hz[2]),
    ]);
    agree(7, &rows);
}

/// Gain of the mean of the conversions of one count.
fn burst_gain(board: &Board, hertz: f64) -> f64 {
    let half = PI * hertz / board.burst_hz();
    if half.sin().abs() < 1e-9 {
        return 1.0;
    }
    ((board.ratio * half).sin() / (board.ratio * half.sin())).abs()
}

fn rc_gain(farad: f64, hertz: f64) -> f64 {
    1.0 / (TAU * 1e3 * farad * hertz).hypot(1.0)
}

fn sensor_gain(hertz: f64) -> f64 {
    let x = hertz / sheet::BANDWIDTH_HZ[1];
    1.0 / (1.0 - x * x).hypot(2.0 * sheet::DAMPING[0] * x)
}

#[test]
fn the_filters_do_what_is_stated() {
    let board = Board::new();
    // The sum turns -0.0 into 0.0.
    let decibel = |gain: f64| format!("{:.1}", (200.0 * gain.log10()).round() / 10.0 + 0.0);
    let row = |name: &str, gain: &dyn Fn(f64) -> f64| {
        let mut row = vec![name.to_string(), format!("{:.0}", 1e6 * (1.0 - gain(5.0)))];
        let aliases = FACTS.rates_hz.map(|rate| f64::from(rate) - 50.0);
        row.extend(aliases.iter().map(|&hertz| decibel(gain(hertz))));
        row.push(decibel(gain(8e3)));
        row.push(decibel(gain(board.burst_hz())));
        row
    };
    agree(
        8,
        &[
            row("mean of 16 conversions", &|f| burst_gain(&board, f)),
            row("1 kΩ, 100 nF", &|f| rc_gain(1e-7, f)),
            row("1 kΩ, 1 µF", &|f| rc_gain(1e-6, f)),
            row("sensor of 120 Hz, then 1 kΩ, 1 µF", &|f| {
                sensor_gain(f) * rc_gain(1e-6, f)
            }),
        ],
    );
}

#[test]
fn the_capacitor_is_judged_as_stated() {
    let c_adc = data_sheet("sampling capacitor") * 1e-12;
    let rows: Vec<_> = table(9)
        .iter()
        .map(|row| {
            let farad = number(row[0]) * 1e-9;
            let kick = 4_096.0 * c_adc / (c_adc + farad);
            // What 1 kΩ needs to bring a full step within 1/4 LSB of 12 bits.
            let settling_us = 1e3 * (farad + c_adc) * 16_384_f64.ln() * 1e6;
            let sampling_us = Board::new().sampling_cycles / Board::new().adc_hz * 1e6;
            vec![
                row[0].to_string(),
                three(1e-3 / (TAU * farad)),
                three(kick),
                three(settling_us),
                yes(kick < 0.25 || settling_us < sampling_us),
            ]
        })
        .collect();
    agree(9, &rows);
    let leakage = data_sheet("pin leakage") * 1e-9 * 1e3 * counts_per_volt();
    says(&format!("at most {leakage:.1} counts"));
}

#[test]
fn interferers_leak_as_stated() {
    let surroundings = twin::board::Surroundings::draw(1);
    let hum_v = (0..20_000)
        .map(|micros| surroundings.hum_v(f64::from(micros) * 1e-6))
        .fold(0.0, f64::max);
    let vibration = vibration::ACCELERATION_M_S2 / sheet::TRIADS[0].full_scale;
    let interferers = [
        (vibration, vibration::FREQUENCY_HZ[0]),
        (vibration, vibration::FREQUENCY_HZ[1]),
        (hum_v / sheet::FULL_SCALE_V, 50.0),
    ];
    let names = table(10);
    let rows: Vec<_> = interferers
        .iter()
        .zip(&names)
        .map(|(&(part, hertz), name)| {
            // Largest response of a 3 s window at 1 Hz to a line at `hertz`, by its image too.
            let leak = part / (PI * 3.0) * (1.0 / (hertz - 1.0) + 1.0 / (hertz + 1.0));
            vec![
                name[0].to_string(),
                format!("{hertz:.0}"),
                three(100.0 * part),
                three(1e6 * leak),
            ]
        })
        .collect();
    agree(10, &rows);
}
