//! Random numbers that never change from version to version.
//!
//! Every random quantity has a *stream* of its own, with the name of the quantity (`"sensor.ax.bias"`), so that a new
//! quantity never shifts the numbers of the old ones. A stream is ChaCha with 8 rounds (D. J. Bernstein, 2008): the key
//! is the seed, the nonce is the FNV-1a hash of the name. Only the few lines below make uniform and normal numbers from
//! its words. They use the portable `libm` instead of the system's, so that the numbers depend on no platform and on no
//! other library's version.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The random numbers of one named quantity.
#[derive(Debug, Clone)]
pub struct Stream {
    words: ChaCha8Rng,
    /// Second number of the last Box-Muller pair, if it is still unused.
    spare: Option<f64>,
}

impl Stream {
    /// The stream of the quantity `name` under `seed`.
    #[must_use]
    pub fn new(seed: u64, name: &str) -> Self {
        let mut key = *b"seedseed hexsense twin, stream 1";
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let mut words = ChaCha8Rng::from_seed(key);
        words.set_stream(fnv1a(name));
        Self { words, spare: None }
    }

    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.words.next_u64()
    }

    /// Uniform in `low` (included) to `high` (excluded).
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.fraction()
    }

    /// Uniform in `-limit` to `limit`.
    pub fn within(&mut self, limit: f64) -> f64 {
        self.uniform(-limit, limit)
    }

    /// Normal with mean 0 and standard deviation 1 (Box and Muller, 1958).
    pub fn normal(&mut self) -> f64 {
        if let Some(value) = self.spare.take() {
            return value;
        }
        let radius = (-2.0 * libm::log(1.0 - self.fraction())).sqrt();
        let (sine, cosine) = libm::sincos(TAU * self.fraction());
        self.spare = Some(radius * sine);
        radius * cosine
    }

    /// A direction: a unit vector, uniform on the sphere.
    pub fn direction(&mut self) -> [f64; 3] {
        let height = self.within(1.0);
        let (sine, cosine) = libm::sincos(self.uniform(0.0, TAU));
        let radius = (1.0 - height * height).sqrt();
        [radius * cosine, height, radius * sine]
    }

    /// Uniform in 0 (included) to 1 (excluded), in steps of 2⁻⁵³.
    fn fraction(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
}

/// FNV-1a hash, 64 bits (Fowler, Noll, Vo).
fn fnv1a(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_hash_is_the_published_fnv1a() {
        // Test vectors of the FNV draft (draft-eastlake-fnv, appendix C).
        assert_eq!(fnv1a(""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a("a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv1a("foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn a_seed_means_the_same_numbers_for_ever() {
        // Computed with an independent implementation of ChaCha8 and of Box and Muller's formula.
        let mut stream = Stream::new(1, "anything");
        assert_eq!(stream.bits(), 8_491_307_815_529_302_450);
        assert!((stream.normal() + 0.220_804_387_903_034_47).abs() < 1e-15);
        assert!((stream.normal() + 0.148_352_288_814_936_7).abs() < 1e-15);
    }
}
