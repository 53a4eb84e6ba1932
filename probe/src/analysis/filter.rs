//! A zero-phase low-pass: a Butterworth filter run forwards and then backwards.
//!
//! Second-order sections by the bilinear transform of the analog prototype (e.g. A. V. Oppenheim, R. W. Schafer,
//! Discrete-Time Signal Processing, 7.1). Fourth order each way; the two passes together halve the power at the
//! corner twice: gain ½ there, and no phase anywhere.

use core::f64::consts::PI;

/// Damping of the two sections of a fourth-order Butterworth filter: cos(π/8) and cos(3π/8).
const DAMPINGS: [f64; 2] = [0.923_879_532_511_286_7, 0.382_683_432_365_089_8];

/// One second-order section, normalised to a0 = 1; b1 = 2·b0 and b2 = b0 for a low-pass.
#[derive(Clone, Copy)]
struct Section {
    b0: f64,
    a1: f64,
    a2: f64,
}

impl Section {
    fn new(corner_hz: f64, rate_hz: f64, damping: f64) -> Self {
        let warped = (PI * corner_hz / rate_hz).tan();
        let square = warped * warped;
        let a0 = 1.0 + 2.0 * damping * warped + square;
        Self {
            b0: square / a0,
            a1: 2.0 * (square - 1.0) / a0,
            a2: (1.0 - 2.0 * damping * warped + square) / a0,
        }
    }

    /// Filters in place, starting from the state in which the first value has lasted for ever.
    fn run<'a>(self, values: impl Iterator<Item = &'a mut f64>) {
        let mut state: Option<(f64, f64)> = None;
        for value in values {
            let x = *value;
            let (s1, s2) = state.unwrap_or((x * (1.0 - self.b0), x * (self.b0 - self.a2)));
            let y = self.b0 * x + s1;
            state = Some((
                2.0 * self.b0 * x - self.a1 * y + s2,
                self.b0 * x - self.a2 * y,
            ));
            *value = y;
        }
    }
}

/// Low-pass of `values` sampled at `rate_hz`, gain ½ at `corner_hz`, without any phase.
///
/// The first and last two periods of the corner are disturbed by the ends.
#[must_use]
pub fn zero_phase_low_pass(values: &[f64], corner_hz: f64, rate_hz: f64) -> Vec<f64> {
    let mut values = values.to_vec();
    for damping in DAMPINGS {
        let section = Section::new(corner_hz, rate_hz, damping);
        section.run(values.iter_mut());
        section.run(values.iter_mut().rev());
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gain_and_lag(frequency_hz: f64) -> (f64, f64) {
        let (rate, omega) = (500.0, 2.0 * PI * frequency_hz / 500.0);
        let sine: Vec<f64> = (0..20_000).map(|n| (omega * f64::from(n)).sin()).collect();
        let out = zero_phase_low_pass(&sine, 2.0, rate);
        let (mut a, mut b) = (0.0, 0.0);
        for (n, y) in out.iter().enumerate().skip(5_000).take(10_000) {
            a += y * (omega * n as f64).sin() / 5_000.0;
            b += y * (omega * n as f64).cos() / 5_000.0;
        }
        (a.hypot(b), b.atan2(a))
    }

    #[test]
    fn it_passes_one_hertz_halves_two_and_stops_ten_without_phase() {
        let (gain, lag) = gain_and_lag(1.0);
        assert!((gain - 1.0 / (1.0 + 0.5f64.powi(8))).abs() < 1e-3 && lag.abs() < 1e-9);
        let (gain, lag) = gain_and_lag(2.0);
        assert!((gain - 0.5).abs() < 1e-3 && lag.abs() < 1e-9);
        assert!(gain_and_lag(10.0).0 < 1e-5);
    }

    #[test]
    fn a_constant_stays_as_it_is_from_the_first_value_on() {
        assert!(
            zero_phase_low_pass(&[9.8; 100], 2.0, 500.0)
                .iter()
                .all(|y| (y - 9.8).abs() < 1e-9)
        );
    }
}
