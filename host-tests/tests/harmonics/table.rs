//! The integer sines.

use std::f64::consts::TAU;

use hexsense::harmonics::table::{ONE, cosine, sine};

/// Phases spread over the turn, off the table's entries.
fn phases() -> impl Iterator<Item = u64> {
    (0..200_000_u64).map(|index| index.wrapping_mul(0x9E37_79B9_7F4A_7C15))
}

#[test]
fn the_table_is_off_by_less_than_its_rounding_and_interpolation() {
    // Entries are rounded by half a step, the interpolated value is cut off by one, and a chord lies below its arc.
    let bound = 1.5 / f64::from(ONE) + (TAU / 1_024.0).powi(2) / 8.0;
    let mut worst: f64 = 0.0;
    for phase in phases() {
        let angle = TAU * phase as f64 / 2_f64.powi(64);
        for (value, truth) in [(sine(phase), angle.sin()), (cosine(phase), angle.cos())] {
            worst = worst.max((f64::from(value) / f64::from(ONE) - truth).abs());
        }
    }
    assert!(worst < bound, "{worst:e} against {bound:e}");
}

#[test]
fn quarter_turns_are_exact() {
    for (quarter, (s, c)) in [(0, 1), (1, 0), (0, -1), (-1, 0)].into_iter().enumerate() {
        let phase = (quarter as u64) << 62;
        assert_eq!((sine(phase), cosine(phase)), (s * ONE, c * ONE));
    }
}

#[test]
fn the_table_is_the_one_that_boards_have() {
    let digest = (0..4_096_u64).fold(0_u64, |digest, index| {
        let phase = (index << 52).wrapping_add(0x0007_5BCD_1500_0000);
        let digest = digest.wrapping_mul(0x0100_0000_01B3) ^ u64::from(sine(phase) as u32);
        digest.wrapping_mul(0x0100_0000_01B3) ^ u64::from(cosine(phase) as u32)
    });
    assert_eq!(
        digest, 0xF781_0A94_6687_AE30,
        "the host replays the board's sines, so they are part of the wire: bump wire::VERSION"
    );
}
