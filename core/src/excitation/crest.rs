//! Phases that keep the peak of a sum of sines low.
//!
//! The *crest factor* is the peak of a signal over its root mean square: √2 for one sine, √(2N) for N equal sines that
//! start at zero phase as cosines. A base has limits for peaks, and an estimate has the noise of powers, so a low crest
//! factor is more accuracy from the same stroke. For u(t) = Σ A_n·cos(h_n·τ + φ_n), τ = 2πf₀t, with the share
//! p_n = A_n²/ΣA² of the power:
//!
//! ```text
//! φ_n = −2π·Σ_{l<n} (n − l)·p_l          M. R. Schroeder, "Synthesis of low-peak-factor signals and binary sequences
//!                                        with low autocorrelation", IEEE Trans. Inf. Theory 16 (1970) 85-89
//! ```
//!
//! This sweeps the power evenly over the period; many equal sines in a row reach about 1.7. Few or scattered harmonics
//! are not a sweep. So the better of these phases and zero phases is improved further: the search moves one phase at a
//! time to and fro where that lowers the peak, by smaller and smaller steps. It uses no random numbers and gives the
//! same phases every time.

use core::f64::consts::TAU;

use heapless::Vec;

/// One sine of a sum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Multiple of the fundamental frequency, at least 1.
    pub harmonic: u16,
    /// Amplitude, in the unit of the sum, at least 0.
    pub amplitude: f64,
    /// Phase of the cosine, rad.
    pub phase_rad: f64,
}

/// Samples of a period of the highest line; a peak between samples is at most 1/cos(π/32) − 1 = 0.5 % higher.
const SAMPLES_PER_PERIOD: usize = 32;
/// Moves of a phase, as parts of a turn: from a quarter down to a 256th.
const MOVES: [f64; 7] = [4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0];
/// Rounds over all lines with moves of one size.
const ROUNDS: usize = 4;

/// Crest factor of the sum of at most `N` lines, without unit: the largest magnitude over one period of the fundamental
/// over the root mean square. The magnitude between samples is missed by at most 0.5 %. 0 for a sum that is zero.
#[must_use]
pub fn crest_factor<const N: usize>(lines: &Vec<Line, N>) -> f64 {
    let rms = libm::sqrt(power(lines));
    if rms > 0.0 { peak(lines) / rms } else { 0.0 }
}

/// Gives `lines` Schroeder's phases, for their powers and in their order.
pub fn schroeder_phases(lines: &mut [Line]) {
    let power = power(lines).max(f64::MIN_POSITIVE);
    // Over the lines before: the sum of p_l, and that of (n − l)·p_l.
    let (mut share, mut sweep) = (0.0, 0.0);
    for line in lines {
        sweep += share;
        line.phase_rad = -TAU * (sweep - libm::floor(sweep));
        share += 0.5 * line.amplitude * line.amplitude / power;
    }
}

/// Gives `lines` phases with a low crest factor, never above that of zero phases; see the head of this file. The time
/// grows with the square of the number of lines and with the highest harmonic: some 10 ms for twelve lines up to the
/// 200th harmonic on a host.
pub fn low_crest_phases<const N: usize>(lines: &mut Vec<Line, N>) {
    lines.iter_mut().for_each(|line| line.phase_rad = 0.0);
    let at_zero = peak(lines);
    schroeder_phases(lines);
    let mut lowest = peak(lines);
    if lowest > at_zero {
        lines.iter_mut().for_each(|line| line.phase_rad = 0.0);
        lowest = at_zero;
    }
    for part in MOVES {
        for _ in 0..ROUNDS {
            let found = improve(lines, TAU / part, lowest);
            if found >= lowest {
                break;
            }
            lowest = found;
        }
    }
}

/// Moves each phase in turn by `move_rad` to and fro if that brings the peak below `lowest`; returns the peak.
fn improve<const N: usize>(lines: &mut Vec<Line, N>, move_rad: f64, mut lowest: f64) -> f64 {
    for index in 0..lines.len() {
        for step in [move_rad, -2.0 * move_rad, move_rad] {
            if let Some(line) = lines.get_mut(index) {
                line.phase_rad += step;
            }
            let peak = peak(lines);
            if peak < lowest {
                lowest = peak;
                break;
            }
        }
    }
    lowest
}

/// Mean square of the sum.
fn power(lines: &[Line]) -> f64 {
    lines
        .iter()
        .map(|line| 0.5 * line.amplitude * line.amplitude)
        .sum()
}

/// Largest magnitude among the samples of a period of the fundamental. Each line is a pointer that turns by the same
/// angle from sample to sample.
fn peak<const N: usize>(lines: &Vec<Line, N>) -> f64 {
    let highest = lines.iter().map(|line| line.harmonic).max().unwrap_or(0);
    let samples = SAMPLES_PER_PERIOD * usize::from(highest);
    let pointer = |line: &Line| {
        let turn = TAU * f64::from(line.harmonic) / samples as f64;
        let (sine, cosine) = libm::sincos(line.phase_rad);
        let (turn_sine, turn_cosine) = libm::sincos(turn);
        [
            line.amplitude * cosine,
            line.amplitude * sine,
            turn_cosine,
            turn_sine,
        ]
    };
    let mut pointers: Vec<[f64; 4], N> = lines.iter().map(pointer).collect();
    let mut peak = 0.0_f64;
    for _ in 0..samples {
        let mut sum = 0.0;
        for [x, y, cosine, sine] in &mut pointers {
            sum += *x;
            (*x, *y) = (*x * *cosine - *y * *sine, *x * *sine + *y * *cosine);
        }
        peak = peak.max(sum.abs());
    }
    peak
}
