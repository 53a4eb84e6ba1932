//! A coefficient set for the fake board.

use hexsense_core::records::{
    CoefficientSet, JackCoefficients, MAX_ENCODED, MotionBase, TriadCoefficients,
};
use hexsense_probe::coefficient_file::Sources;
use hexsense_probe::geometry_file::GeometryFile;

/// What the set of the fake board says that it was found from.
pub fn sources() -> Sources {
    Sources {
        captures_sha256: "01".repeat(32),
        programs_sha256: "02".repeat(32),
        geometry_sha256: "03".repeat(32),
        sensors_sha256: "04".repeat(32),
    }
}

/// A set in which mid-scale counts are a base at mid-stroke; `unix_s` makes sets differ.
pub fn set(unix_s: u64) -> CoefficientSet {
    let triad = TriadCoefficients {
        offset: [32_768.0; 3],
        matrix: [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]],
        offset_uncertainty: [1.0; 3],
        matrix_uncertainty: [[1e-7; 3]; 3],
        delay_s: 0.002,
    };
    let geometry = GeometryFile::load("an-74tk-200").unwrap().geometry;
    CoefficientSet {
        board: *b"fake board 1",
        geometry: "an-74tk-200".try_into().unwrap(),
        geometry_hash: [1; 8],
        unix_s,
        temperature_c: 31.5,
        provenance: sources().provenance(),
        ratiometric: Default::default(),
        build: None,
        triads: [triad; 3],
        base: MotionBase::new(&geometry),
        jacks: JackCoefficients {
            zero_length_m: geometry.mid_length_m() as f32,
            zero_counts: [32_768.0; 6],
            metres_per_count: [2e-5; 6],
        },
    }
}

/// Its bytes.
pub fn encoded(set: &CoefficientSet) -> Vec<u8> {
    let mut buffer = [0; MAX_ENCODED];
    set.encode(&mut buffer).unwrap().to_vec()
}
