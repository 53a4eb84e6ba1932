//! Coefficient sets to store.

use hexsense_core::records::log::Reason;
use hexsense_core::records::{
    BuildId, CoefficientSet, Entry, JackCoefficients, MAX_ENCODED, MotionBase, TriadCoefficients,
};

/// Unique id of the board that the sets are for.
pub const BOARD: [u8; 12] = [7; 12];
/// The firmware of the board.
pub const BUILD: BuildId = BuildId([0xB1; 8]);

/// A set of nearly the greatest length; `number` makes it differ from the others.
#[must_use]
pub fn numbered(number: u32) -> CoefficientSet {
    let triad = TriadCoefficients {
        offset: [32_768.0 + number as f32, 32_767.0, 32_766.0],
        matrix: [[6e-4, 1e-5, 0.0], [-1e-5, 6.1e-4, 2e-5], [0.0, 0.0, 5.9e-4]],
        offset_uncertainty: [0.5; 3],
        matrix_uncertainty: [[1e-7; 3]; 3],
        delay_s: 3.5e-3,
    };
    CoefficientSet {
        board: BOARD,
        geometry: heapless::String::try_from("a name of thirty-two letters….").unwrap(),
        geometry_hash: [0x5A; 8],
        unix_s: 1_780_000_000 + u64::from(number),
        temperature_c: 31.5,
        provenance: [0xC3; 32],
        ratiometric: Default::default(),
        build: None,
        triads: [triad; 3],
        base: base(),
        jacks: JackCoefficients {
            zero_length_m: 2.75,
            zero_counts: [32_768.5; 6],
            metres_per_count: [2.5e-5; 6],
        },
    }
}

/// Upper hinges in pairs on a circle, lower hinges to either side of them on a larger circle; all numbers are short.
#[must_use]
pub fn base() -> MotionBase {
    MotionBase {
        lower: [
            [1.375, 0.0, -1.75],
            [1.375, 0.0, 1.75],
            [0.812_5, 0.0, 2.062_5],
            [-2.187_5, 0.0, 0.312_5],
            [-2.187_5, 0.0, -0.312_5],
            [0.812_5, 0.0, -2.062_5],
        ],
        upper: [
            [1.5, 0.0, 0.0],
            [1.5, 0.0, 0.0],
            [-0.75, 0.0, 1.312_5],
            [-0.75, 0.0, 1.312_5],
            [-0.75, 0.0, -1.312_5],
            [-0.75, 0.0, -1.312_5],
        ],
        length_min_m: 2.125,
        length_max_m: 3.375,
        home_height_m: 2.125,
    }
}

/// Its bytes.
///
/// # Panics
/// When it has none.
#[must_use]
pub fn encoded(set: &CoefficientSet) -> Vec<u8> {
    set.encode(&mut [0; MAX_ENCODED]).unwrap().to_vec()
}

/// The log entry of the upload of set `number`, with that counter.
#[must_use]
pub fn uploaded(number: u32) -> Entry {
    Entry {
        counter: number,
        reason: Reason::Upload,
        unix_s: 1_790_000_000 + u64::from(number),
        id: Some(CoefficientSet::id_of(&encoded(&numbered(number)))),
        previous: None,
        build: BUILD,
        chain: [0; 16],
        reset: 0,
        page: 0,
    }
}
