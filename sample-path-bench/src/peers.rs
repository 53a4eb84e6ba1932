//! Estimators from crates.io, as their documentation shows them, for nine channels.
//!
//! Each gets the counts of a scan as `f32` (or `i32`) and does what it can: none of them calibrates, and none but
//! the last knows harmonics.

use core::num::Wrapping;

use dsp_process::SplitProcess;
use goertzel_algorithm::Goertzel;
use hexsense_core::channel::INERTIAL;
use idsp::{Lockin, Lowpass, LowpassState};
use static_cell::StaticCell;

use crate::signal;

const HARMONICS: usize = 5;
const TRANSFORM: usize = 1_024;
/// Scans whose mean is one sample of the transform, so that a period fits into it.
const MEAN_OF: usize = 4;

/// Estimates the signal with each of them.
pub fn run() {
    defmt::println!("amplitude goertzel_algorithm {}", goertzel().to_bits());
    defmt::println!("amplitude microfft {}", microfft().to_bits());
    defmt::println!("amplitude idsp {}", idsp().to_bits());
}

#[unsafe(no_mangle)]
#[inline(never)]
fn peer_goertzel_scan(filters: &mut [Goertzel; INERTIAL], scan: &[u16; INERTIAL]) -> Option<f32> {
    let mut magnitude = None;
    for (filter, count) in filters.iter_mut().zip(scan) {
        if let Some(found) = filter.process_sample(&f32::from(*count)) {
            magnitude = Some(found.magnitude);
        }
    }
    magnitude
}

fn goertzel() -> f64 {
    let mut filters = [(); INERTIAL].map(|()| Goertzel::new());
    for filter in &mut filters {
        filter.prepare(
            signal::RATE_HZ,
            signal::FREQUENCY_HZ as f32,
            signal::SCANS as u32,
        );
    }
    let found = (0..signal::SCANS)
        .filter_map(|n| peer_goertzel_scan(&mut filters, &[signal::count(n); INERTIAL]))
        .last();
    found.map_or(f64::NAN, f64::from)
}

#[unsafe(no_mangle)]
#[inline(never)]
fn peer_microfft_window(channels: &mut [[f32; TRANSFORM]; INERTIAL]) -> f32 {
    let mut amplitude = 0.0;
    for channel in channels {
        let bin = (signal::FREQUENCY_HZ * (TRANSFORM * MEAN_OF) as f64 / f64::from(signal::RATE_HZ))
            as usize;
        let found = microfft::real::rfft_1024(channel)[bin];
        amplitude = libm::sqrtf(found.re * found.re + found.im * found.im) * 2.0 / TRANSFORM as f32;
    }
    amplitude
}

#[unsafe(no_mangle)]
#[inline(never)]
fn peer_microfft_scan(
    channels: &mut [[f32; TRANSFORM]; INERTIAL],
    sample: usize,
    scan: &[u16; INERTIAL],
) {
    for (channel, count) in channels.iter_mut().zip(scan) {
        channel[sample] += f32::from(*count) * (1.0 / MEAN_OF as f32);
    }
}

fn microfft() -> f64 {
    static CHANNELS: StaticCell<[[f32; TRANSFORM]; INERTIAL]> = StaticCell::new();
    let channels = CHANNELS.init_with(|| [[0.0; TRANSFORM]; INERTIAL]);
    for n in 0..TRANSFORM * MEAN_OF {
        peer_microfft_scan(channels, n / MEAN_OF, &[signal::count(n); INERTIAL]);
    }
    f64::from(peer_microfft_window(channels))
}

struct Lockins {
    filter: Lockin<Lowpass<2>>,
    states: [[[LowpassState<2>; 2]; HARMONICS]; INERTIAL],
}

#[unsafe(no_mangle)]
#[inline(never)]
fn peer_idsp_scan(lockins: &mut Lockins, phase: Wrapping<i32>, scan: &[u16; INERTIAL]) -> [i32; 2] {
    let mut first = [0; 2];
    for (states, count) in lockins.states.iter_mut().zip(scan) {
        let sample = (i32::from(*count) - 32_768) << 12;
        let mut harmonic = phase;
        for (k, state) in states.iter_mut().enumerate() {
            let found = lockins.filter.process(state, (sample, harmonic));
            if k == 0 {
                first = found.0;
            }
            harmonic += phase;
        }
    }
    first
}

fn idsp() -> f64 {
    // A Butterworth low-pass at a tenth of the drive frequency, as the documentation of `Lowpass` scales it.
    let corner = 0.1 * signal::FREQUENCY_HZ / (f64::from(signal::RATE_HZ) / 2.0);
    let k = core::f64::consts::PI * 2_147_483_648.0 * corner;
    let gains = [
        (k * k / 4_294_967_296.0) as i32,
        (-k * core::f64::consts::SQRT_2) as i32,
    ];
    static LOCKINS: StaticCell<Lockins> = StaticCell::new();
    let lockins = LOCKINS.init_with(|| Lockins {
        filter: Lockin(Lowpass(gains)),
        states: Default::default(),
    });
    let step = (signal::FREQUENCY_HZ / f64::from(signal::RATE_HZ) * 4_294_967_296.0) as i32;
    let mut phase = Wrapping(0);
    let mut found = [0; 2];
    // It needs ten times as long to settle.
    for n in 0..10 * signal::SCANS {
        found = peer_idsp_scan(lockins, phase, &[signal::count(n); INERTIAL]);
        phase += step;
    }
    let [re, im] = found.map(|part| f64::from(part) / 4_096.0);
    2.0 * libm::hypot(re, im)
}
