//! The sensors against their data sheet and against textbook formulas.

mod support;

use std::f64::consts::TAU;

use support::close;
use twin::Bench;
use twin::algebra::Vec3;
use twin::bench::STEP_S;
use twin::board::Surroundings;
use twin::random::Stream;
use twin::sensor::{RandomWalk, Response, Sensor, SensorTruth};
use twin::sheet::{self, TRIADS};
use twin::transducer::Transducer;

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn rms(values: &[f64]) -> f64 {
    mean(&values.iter().map(|v| v * v).collect::<Vec<_>>()).sqrt()
}

#[test]
fn noise_has_the_density_of_the_data_sheet() {
    // The mean over T of noise with one-sided density d has the variance d²/2T; the differences of neighbouring means
    // are free of bias and of almost all of the random walk.
    let (block, blocks) = (200, 4000);
    for (index, triad) in TRIADS.iter().enumerate() {
        let mut sensor = Sensor::new(11, triad, index, Vec3::ZERO, STEP_S);
        let means: Vec<f64> = (0..blocks)
            .map(|_| {
                let values: Vec<f64> = (0..block)
                    .map(|_| {
                        sensor.advance(Vec3::ZERO);
                        (sensor.volts() - sheet::ZERO_V) / triad.volts_per_unit()
                    })
                    .collect();
                mean(&values)
            })
            .collect();
        let differences: Vec<f64> = means.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let density = rms(&differences) * (f64::from(block) * STEP_S).sqrt();
        close(density / triad.noise_density, 1.0, 0.06, triad.name);
    }
}

#[test]
fn the_random_walk_has_its_size_after_five_minutes() {
    for step_s in [1.0, 0.05] {
        let ends: Vec<f64> = (0..500)
            .map(|seed| {
                let mut walk = RandomWalk::new(Stream::new(seed, "walk"), 0.01, step_s);
                (0..(300.0 / step_s) as usize).for_each(|_| walk.advance());
                walk.value()
            })
            .collect();
        close(rms(&ends), 0.01, 0.001, "walk");
        close(mean(&ends), 0.0, 0.0015, "mean");
    }
}

#[test]
fn the_response_is_that_of_a_second_order_system() {
    for (natural_hz, damping) in [(50.0, 0.6), (80.0, 0.8), (120.0, 1.0)] {
        for drive_hz in [0.5, 10.0, 50.0] {
            let mut response = Response::new(natural_hz, damping, 0.0, STEP_S);
            let omega = TAU * drive_hz * STEP_S;
            // Two seconds to settle, two to measure: whole periods of every drive frequency.
            let (mut re, mut im) = (0.0, 0.0);
            for n in 1..=8000 {
                response.advance((omega * f64::from(n)).sin());
                if n > 4000 {
                    re += response.output() * (omega * f64::from(n)).sin() / 2000.0;
                    im += response.output() * (omega * f64::from(n)).cos() / 2000.0;
                }
            }
            let r = drive_hz / natural_hz;
            let size = 1.0 / ((1.0 - r * r).powi(2) + (2.0 * damping * r).powi(2)).sqrt();
            // The input is linear between steps: the chords of a sine are smaller than the sine.
            let half = 0.5 * omega;
            let size = size * (half.sin() / half).powi(2);
            let phase = -(2.0 * damping * r).atan2(1.0 - r * r);
            close(re.hypot(im), size, 1e-5 * size, "amplitude");
            close(im.atan2(re), phase, 1e-5, "phase");
        }
    }
}

#[test]
fn the_response_leaves_a_constant_as_it_is() {
    let mut response = Response::new(70.0, 0.7, 3.0, STEP_S);
    (0..4000).for_each(|_| response.advance(3.0));
    close(response.output(), 3.0, 1e-12, "constant");
}

#[test]
fn sensors_saturate_at_105_percent_of_full_scale() {
    let triad = &TRIADS[0];
    for (input, volts) in [(100.0, 1.65 + 1.05 * 1.5), (-100.0, 1.65 - 1.05 * 1.5)] {
        let sensor = Sensor::new(1, triad, 0, Vec3([input, 0.0, 0.0]), STEP_S);
        close(sensor.volts(), volts, 1e-12, "saturated");
    }
}

#[test]
fn drawn_sensors_fill_their_tolerances_and_do_not_leave_them() {
    for triad in &TRIADS {
        let drawn: Vec<(usize, SensorTruth)> = (0..300)
            .flat_map(|seed| [0, 1, 2].map(|axis| (axis, SensorTruth::draw(seed, triad, axis))))
            .collect();
        let fills = |what: &str, [low, high]: [f64; 2], value: &dyn Fn(&SensorTruth) -> f64| {
            let values: Vec<f64> = drawn.iter().map(|(_, truth)| value(truth)).collect();
            let min = values.iter().copied().fold(f64::INFINITY, f64::min);
            let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let (edge, name) = (0.02 * (high - low), triad.name);
            assert!(low <= min && min < low + edge, "{name} {what}: least {min}");
            assert!(
                high - edge < max && max <= high,
                "{name} {what}: most {max}"
            );
        };
        let symmetric = |tolerance: f64| [-tolerance, tolerance];
        fills("gain", symmetric(triad.gain_tolerance), &|t| t.gain - 1.0);
        fills("bias", symmetric(triad.bias_tolerance), &|t| t.bias);
        fills("bandwidth", sheet::BANDWIDTH_HZ, &|t| t.bandwidth_hz);
        fills("damping", sheet::DAMPING, &|t| t.damping);
        let tilts: Vec<f64> = drawn
            .iter()
            .map(|(axis, truth)| truth.axis.0[*axis].clamp(-1.0, 1.0).acos().to_degrees())
            .collect();
        assert!(tilts.iter().all(|tilt| *tilt < 1.001));
        // Rayleigh with σ = 0.5° cut at 1°: mean square 2σ²(1 − 2·e⁻²/(1 − e⁻²)) = 0.343.
        close(rms(&tilts).powi(2), 0.343, 0.03, "mean square of tilt");
    }
}

#[test]
fn transducer_noise_is_a_tenth_of_a_millimetre_between_steps_too() {
    let mut transducer = Transducer::draw(2, 0, 1.0);
    let volts: Vec<f64> = (0..200_001).map(|_| transducer.volts(0.0)).collect();
    // A board samples every second interval, at a place in it that drifts with its clock.
    let sampled: Vec<f64> = (0..100_000)
        .map(|n| {
            let s = f64::from(n) / 100_000.0;
            volts[2 * n as usize] * (1.0 - s) + volts[2 * n as usize + 1] * s
        })
        .collect();
    let centre = mean(&sampled);
    let noise: Vec<f64> = sampled.iter().map(|v| (v - centre) / 3.1).collect();
    close(rms(&noise), 1e-4, 2e-6, "noise, m");
    assert!((centre - 1.65).abs() < 3.1 * 5.1e-4, "offset: {centre}");
}

#[test]
fn hum_supply_and_temperature_stay_in_their_classes() {
    for seed in 0..50 {
        let surroundings = Surroundings::draw(seed);
        for second in 0..1200 {
            let t = f64::from(second) + 0.003;
            let supply = surroundings.supply_v(t);
            assert!((supply / 3.3 - 1.0).abs() <= 0.001, "supply {supply}");
            let temperature = surroundings.temperature_c(t);
            assert!((25.0..35.0).contains(&temperature), "{temperature}");
        }
        let period: Vec<f64> = (0..40)
            .map(|n| surroundings.hum_v(f64::from(n) * STEP_S))
            .collect();
        close(rms(&period) * 2f64.sqrt(), 0.0005 * 1.5, 1e-12, "hum");
        close(mean(&period), 0.0, 1e-12, "hum is 50 Hz");
    }
}

#[test]
fn every_analog_pin_hums() {
    let seconds = 40.0;
    let mut bench = Bench::with_geometry(1, &support::an74()).unwrap();
    let (mut rows, mut phasors, mut count) = (Vec::new(), [(0.0, 0.0); 15], 0u32);
    for _ in 0..(seconds / 0.02) as usize {
        bench.next_chunk(&mut rows, |_| ()).unwrap();
        for row in rows.chunks_exact(17).skip(1) {
            count += 1;
            let (sine, cosine) = (TAU * 50.0 * f64::from(count) * STEP_S).sin_cos();
            for (phasor, volts) in phasors.iter_mut().zip(row) {
                phasor.0 += f64::from(*volts) * sine;
                phasor.1 += f64::from(*volts) * cosine;
            }
        }
    }
    for (pin, (re, im)) in phasors.into_iter().enumerate() {
        let volts = 2.0 * f64::hypot(re, im) / f64::from(count);
        // Noise of one-sided density d leaves an amplitude that is uncertain by d/√T.
        let density = TRIADS
            .get(pin / 3)
            .map_or(1e-5, |triad| triad.noise_density * triad.volts_per_unit());
        close(
            volts,
            0.0005 * 1.5,
            4.0 * density / f64::sqrt(seconds) + 2e-5,
            "hum",
        );
    }
}
