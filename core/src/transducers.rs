//! Jack transducers: from counts to hinge-to-hinge lengths.
//!
//! ```text
//! l_k = l° + m_k · e_k        e_k = c·u_k − u°_k        u_k: counts of jack k, c: supply factor
//! ```
//!
//! The *excess* e_k is what the counts at nominal supply are above those at the zero length l°. It is computed in three
//! ways, which differ in their last bits only:
//!
//! | counts | excess | use |
//! |---|---|---|
//! | at nominal supply | u − u° | the host, in `f64` |
//! | mean of a block, with its supply factor | (u − u°) + (c − 1)·u | the board's pose, in `f32` |
//! | `f64`, with a supply factor | c·u − u° in `f64`, then rounded | the board's harmonics |
//!
//! Lengths of metres are to be good to a tenth of a micrometre, the last place of an `f32`. The second way puts the
//! excess together from small numbers, so that only the sum with l° is rounded.

use nalgebra::{RealField, convert};

use crate::channel::{INERTIAL, JACKS, Ratiometric};
use crate::records::JackCoefficients;

/// Coefficients of the six transducers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transducers<T> {
    /// Length at which the zero counts are read, hinge to hinge, m.
    pub zero_length_m: T,
    /// Counts at that length, at nominal supply.
    pub zero_counts: [T; JACKS],
    /// Change of length per count, m; negative for a transducer that counts down.
    pub metres_per_count: [T; JACKS],
    /// Whether the supply factor acts on the counts of each jack: on all but the ratiometric ones.
    pub supplied: [bool; JACKS],
}

impl<T: RealField + Copy> Transducers<T> {
    /// The transducers of a coefficient set.
    #[must_use]
    pub fn new(jacks: &JackCoefficients, ratiometric: Ratiometric) -> Self {
        Self {
            zero_length_m: convert(jacks.zero_length_m),
            zero_counts: jacks.zero_counts.map(convert),
            metres_per_count: jacks.metres_per_count.map(convert),
            supplied: core::array::from_fn(|jack| !ratiometric.has(INERTIAL + jack)),
        }
    }

    /// Length of each jack, m, from its counts at nominal supply.
    #[inline]
    pub fn lengths_m(&self, counts: &[T; JACKS]) -> [T; JACKS] {
        core::array::from_fn(|jack| self.length_m(jack, counts[jack] - self.zero_counts[jack]))
    }

    /// How much longer than at the zero length jack `jack` is, m, at `counts` at nominal supply.
    pub fn displacement_m(&self, jack: usize, counts: T) -> T {
        self.metres_per_count[jack] * (counts - self.zero_counts[jack])
    }

    /// The inverse of [`Transducers::displacement_m`].
    pub fn counts(&self, jack: usize, displacement_m: T) -> T {
        self.zero_counts[jack] + displacement_m / self.metres_per_count[jack]
    }

    /// Length of each jack, m, from the mean counts of a block and its supply factor.
    #[inline(always)]
    pub fn lengths_of_means_m(&self, mean: impl Fn(usize) -> T, supply: T) -> [T; JACKS] {
        let beyond = supply - T::one();
        core::array::from_fn(|jack| {
            let mean = mean(jack);
            let beyond = if self.supplied[jack] {
                beyond
            } else {
                T::zero()
            };
            self.length_m(jack, (mean - self.zero_counts[jack]) + beyond * mean)
        })
    }

    #[inline(always)]
    fn length_m(&self, jack: usize, excess: T) -> T {
        self.zero_length_m + self.metres_per_count[jack] * excess
    }
}

impl Transducers<f32> {
    /// Length of each jack, m, from counts in double precision and a supply factor.
    pub fn lengths_of_doubles_m(&self, counts: &[f64; JACKS], supply: f32) -> [f32; JACKS] {
        core::array::from_fn(|jack| {
            let factor = if self.supplied[jack] {
                f64::from(supply)
            } else {
                1.0
            };
            let excess = counts[jack] * factor - f64::from(self.zero_counts[jack]);
            self.length_m(jack, excess as f32)
        })
    }
}
