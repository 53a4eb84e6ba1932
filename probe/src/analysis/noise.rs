//! Noise of a sensor at low frequencies, from its signal at rest.
//!
//! Samples of a sensor with limited bandwidth are not independent, so the variance of a mean over T is not σ²/N but
//! σ²/N_eff, and the residuals' rms says nothing about N_eff. This module looks for the density d near zero frequency,
//!
//! ```text
//! var(mean over T) = d²/2T          N_eff = 2Tσ²/d²
//! ```
//!
//! The density is read from means over a *block* of τ, longer than the sensor's memory: the Allan variance (D. W. Allan,
//! Proc. IEEE 54 (1966) 221), half the mean square of the differences of successive block means, is d²/2τ, and a
//! creeping zero hardly changes it. Blocks overlap, which makes the most of a short rest. Several rests are added up:
//! from ten seconds alone the density is uncertain by 8 %, and an interval from a density that is too small is too
//! narrow by as much.

/// Length of a block, s: forty times the memory of a sensor of 50 Hz.
const BLOCK_S: f64 = 0.2;
/// A block begins one of so many parts of its length after the block before it.
const STRIDE: usize = 10;

/// What one channel scatters in any number of rests, for the density of its noise.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scatter {
    /// Σ (difference of successive block means)² · length of a block, unit²·s.
    squares: f64,
    /// Differences.
    count: usize,
}

impl Scatter {
    /// Adds a rest: `samples` taken at `rate_hz`. One that is shorter than two blocks adds nothing.
    pub fn add(&mut self, samples: &[f64], rate_hz: u32) {
        let length = (BLOCK_S * f64::from(rate_hz)).round() as usize;
        let first = samples.first().copied().unwrap_or(0.0);
        // Sums from the start on; without the first value they stay small.
        let sums: Vec<f64> = std::iter::once(0.0)
            .chain(samples.iter().scan(0.0, |sum, sample| {
                *sum += sample - first;
                Some(*sum)
            }))
            .collect();
        let windows = sums
            .windows(2 * length + 1)
            .step_by((length / STRIDE).max(1));
        for sums in windows {
            let difference = (sums[2 * length] - 2.0 * sums[length] + sums[0]) / length as f64;
            self.squares += difference * difference * length as f64 / f64::from(rate_hz);
            self.count += 1;
        }
    }

    /// Density of white noise at low frequencies, unit/√Hz (one-sided).
    ///
    /// By this measure a dead signal, or none at all, has no noise: 0.
    #[must_use]
    pub fn density(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normal numbers by a congruential generator and the sum of twelve uniform ones.
    struct Random(u64);

    impl Random {
        fn normal(&mut self) -> f64 {
            let uniform = |_| {
                self.0 = self
                    .0
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (self.0 >> 11) as f64 / (1u64 << 53) as f64
            };
            (0..12).map(uniform).sum::<f64>() - 6.0
        }
    }

    fn density(samples: &[f64]) -> f64 {
        let mut scatter = Scatter::default();
        scatter.add(samples, 1_000);
        scatter.density()
    }

    /// Stated over observed standard deviation of the mean over 10 s at 1 kHz, x[n] = memory·x[n−1] + noise.
    fn stated_over_observed(memory: f64) -> f64 {
        const TRIALS: usize = 1_000;
        let mut random = Random(1);
        let (mut stated, mut observed) = (0.0, 0.0);
        for _ in 0..TRIALS {
            let mut x = random.normal() / (1.0 - memory * memory).sqrt();
            let samples: Vec<f64> = (0..10_000)
                .map(|_| {
                    x = memory * x + random.normal();
                    x
                })
                .collect();
            let mean = samples.iter().sum::<f64>() / samples.len() as f64;
            stated += density(&samples).powi(2) / 20.0;
            observed += mean * mean;
        }
        (stated / observed).sqrt()
    }

    /// A thousand trials know the observed deviation to 2.2 %; the memory of 10 ms costs 3.6 % at this block.
    #[test]
    fn the_stated_deviation_of_a_mean_is_right_for_white_and_for_correlated_noise() {
        for memory in [0.0, 0.9] {
            let ratio = stated_over_observed(memory);
            assert!((0.93..1.05).contains(&ratio), "memory {memory}: {ratio}");
        }
    }

    #[test]
    fn a_creeping_zero_and_a_dead_channel_are_hardly_noise() {
        let creep: Vec<f64> = (0..10_000)
            .map(|n| 30_000.0 + 1e-4 * f64::from(n))
            .collect();
        assert!(density(&creep) < 0.01, "one count in ten seconds");
        assert_eq!(density(&[7.0; 10_000]), 0.0);
        assert_eq!(density(&[7.0; 100]), 0.0);
    }
}
