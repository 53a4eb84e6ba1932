//! The integer sines.

use std::f64::consts::TAU;

use hexsense_core::harmonics::table::{ONE, Waves};

/// Phases spread over the turn, off the table's entries, and the ends of the turn's quarters.
fn phases() -> impl Iterator<Item = u32> {
    let ends = (0..4_u32).flat_map(|quarter| [quarter << 30, (quarter << 30).wrapping_sub(1)]);
    (0..500_000_u32)
        .map(|index| index.wrapping_mul(0x9E37_79B9))
        .chain(ends)
}

#[test]
fn waves_are_sines_to_little_more_than_their_rounding() {
    let mut worst: f64 = 0.0;
    for phase in phases() {
        let waves = Waves::at(phase);
        for k in 1..=5 {
            let angle = TAU * (k as f64 * f64::from(phase) / 2_f64.powi(32)).fract();
            let off = |value: i32, truth: f64| (f64::from(value) / f64::from(ONE) - truth).abs();
            worst = worst
                .max(off(waves.cosine[k - 1], angle.cos()))
                .max(off(waves.sine[k - 1], angle.sin()));
        }
    }
    // Half a step of 2⁻²⁰, and the error that five steps of the recurrence add near zero and half a turn.
    let rounding = 0.5 / f64::from(ONE);
    assert!(
        worst > rounding && worst < 1.5 * rounding,
        "{worst:e} against {rounding:e}"
    );
}

#[test]
fn the_waves_are_those_that_boards_have() {
    let digest = (0..4_096_u32).fold(0_u64, |digest, index| {
        let waves = Waves::at((index << 20) + 0x7_5BCD);
        waves
            .cosine
            .iter()
            .chain(&waves.sine)
            .fold(digest, |digest, value| {
                digest.wrapping_mul(0x0100_0000_01B3) ^ u64::from(*value as u32)
            })
    });
    assert_eq!(
        digest, 0x3389_35B6_F06F_5C61,
        "the host replays the board's sines, so they are part of the wire: bump wire::VERSION"
    );
}
