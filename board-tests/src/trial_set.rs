//! Coefficients to try a board with: random numbers, for a base with round dimensions.

use hexsense_core::channel::Triad;
use hexsense_core::records::{CoefficientSet, JackCoefficients, TriadCoefficients};
use hostile::sets;

/// Pseudo-random bits (xorshift, Marsaglia 2003).
pub struct Random(pub u32);

impl Random {
    /// The next 32 bits.
    pub fn bits(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// −1 to 1.
    pub fn share(&mut self) -> f32 {
        self.bits() as i32 as f32 / 2_147_483_648.0
    }

    /// Coefficients of any sign, for a base of round numbers.
    pub fn set(&mut self, board: [u8; 12]) -> CoefficientSet {
        let triads = Triad::ALL.map(|_| TriadCoefficients {
            offset: [(); 3].map(|()| 32_768.0 + 1_000.0 * self.share()),
            matrix: [[(); 3]; 3].map(|row| row.map(|()| 6e-4 * self.share())),
            offset_uncertainty: [0.5; 3],
            matrix_uncertainty: [[1e-7; 3]; 3],
            delay_s: 1e-3,
        });
        CoefficientSet {
            board,
            geometry: Default::default(),
            geometry_hash: [0; 8],
            unix_s: 1_780_000_000,
            temperature_c: 30.0,
            provenance: [0; 32],
            triads,
            base: sets::base(),
            jacks: JackCoefficients {
                zero_length_m: 2.75,
                zero_counts: [32_768.0; 6],
                metres_per_count: [2.5e-5; 6],
            },
        }
    }
}
