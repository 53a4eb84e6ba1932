//! Coefficients to try a board with: random numbers, for a base with round dimensions.

use hexsense_core::channel::{Ratiometric, Triad};
use hexsense_core::records::{CoefficientSet, JackCoefficients, MotionBase, TriadCoefficients};

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
            matrix: self.matrix(),
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
            build: None,
            ratiometric: Ratiometric::from_bits(self.bits() as u16 >> 1).unwrap_or_default(),
            triads,
            base: base(),
            jacks: JackCoefficients {
                zero_length_m: 2.75,
                zero_counts: [32_768.0; 6],
                metres_per_count: [2.5e-5; 6],
            },
        }
    }

    /// Three sensors, each of either sign and nearer to its own axis than to the two others together, so that no board
    /// refuses the matrix as singular.
    fn matrix(&mut self) -> [[f32; 3]; 3] {
        core::array::from_fn(|row| {
            core::array::from_fn(|column| {
                let share = self.share();
                if row == column {
                    (4e-4 + 2e-4 * share.abs()).copysign(share)
                } else {
                    1.5e-4 * share
                }
            })
        })
    }
}

/// Upper hinges in pairs on a circle, lower hinges to either side of them on a larger one.
fn base() -> MotionBase {
    MotionBase {
        lower: [
            [1.375, 0.0, -1.75],
            [1.375, 0.0, 1.75],
            [0.8125, 0.0, 2.0625],
            [-2.1875, 0.0, 0.3125],
            [-2.1875, 0.0, -0.3125],
            [0.8125, 0.0, -2.0625],
        ],
        upper: [
            [1.5, 0.0, 0.0],
            [1.5, 0.0, 0.0],
            [-0.75, 0.0, 1.3125],
            [-0.75, 0.0, 1.3125],
            [-0.75, 0.0, -1.3125],
            [-0.75, 0.0, -1.3125],
        ],
        length_min_m: 2.125,
        length_max_m: 3.375,
        home_height_m: 2.125,
    }
}
