//! Any coefficient set.

use hexsense_core::channel::{CHANNELS, Ratiometric};
use hexsense_core::records::{
    BuildId, CoefficientSet, JackCoefficients, MotionBase, TriadCoefficients,
};
use host_tests::sets::base;
use proptest::array::uniform32;
use proptest::prelude::*;

/// Any set that is fit to be stored.
pub fn any_set() -> impl Strategy<Value = CoefficientSet> {
    let triads = [any_triad(), any_triad(), any_triad()];
    let base = (any_base(), any_jacks());
    (
        (any::<[u8; 12]>(), "[a-z0-9µ-]{0,16}", any::<[u8; 8]>()),
        (
            any::<u64>(),
            -40.0_f32..125.0,
            uniform32(any::<u8>()),
            0_u16..1 << CHANNELS,
            proptest::option::of(any::<[u8; 8]>()),
        ),
        triads,
        base,
    )
        .prop_map(
            |(
                (board, name, geometry_hash),
                (unix_s, temperature_c, provenance, ratiometric, build),
                triads,
                (base, jacks),
            )| {
                CoefficientSet {
                    board,
                    geometry: heapless::String::try_from(name.as_str()).unwrap(),
                    geometry_hash,
                    unix_s,
                    temperature_c,
                    provenance,
                    ratiometric: Ratiometric::from_bits(ratiometric).unwrap(),
                    build: build.map(BuildId),
                    triads,
                    base,
                    jacks,
                }
            },
        )
}

/// Hinges anywhere within a hand of [`base`]'s.
fn any_base() -> impl Strategy<Value = MotionBase> {
    let off = || prop::array::uniform6(prop::array::uniform3(-0.05_f32..0.05));
    (off(), off(), 0.0_f32..2.2, 3.3_f32..9.0, 2.0_f32..2.3).prop_map(
        |(lower, upper, length_min_m, length_max_m, home_height_m)| {
            let moved = |hinges: [[f32; 3]; 6], off: [[f32; 3]; 6]| {
                std::array::from_fn(|jack| {
                    std::array::from_fn(|axis| hinges[jack][axis] + off[jack][axis])
                })
            };
            MotionBase {
                lower: moved(base().lower, lower),
                upper: moved(base().upper, upper),
                length_min_m,
                length_max_m,
                home_height_m,
            }
        },
    )
}

/// Transducers of any sensitivity, either way round.
fn any_jacks() -> impl Strategy<Value = JackCoefficients> {
    let metres = prop_oneof![1e-6_f32..1e-3, -1e-3_f32..-1e-6];
    (
        0.0_f32..9.0,
        prop::array::uniform6(0.0_f32..65_536.0),
        prop::array::uniform6(metres),
    )
        .prop_map(
            |(zero_length_m, zero_counts, metres_per_count)| JackCoefficients {
                zero_length_m,
                zero_counts,
                metres_per_count,
            },
        )
}

/// Sensors up to a third of their sensitivity off their axes, either way round, in any unit in which no value reaches 1e6.
fn any_triad() -> impl Strategy<Value = TriadCoefficients> {
    let three = |range: std::ops::Range<f32>| std::array::from_fn(|_| range.clone());
    let nine = |range: std::ops::Range<f32>| std::array::from_fn(|_| three(range.clone()));
    let signs = [prop::bool::ANY; 3];
    (
        three(0.0..65_536.0),
        (nine(-0.3..0.3), signs, -6.0_f32..0.8),
        three(0.0..10.0),
        nine(0.0..1.0),
        -0.1_f32..0.1,
    )
        .prop_map(
            |(offset, (cross, signs, decade), offset_uncertainty, matrix_uncertainty, delay_s)| {
                let element = |row: usize, column: usize| {
                    let main = if row == column { 1.0 } else { 0.0 };
                    let sign = if signs[row] { 1.0 } else { -1.0 };
                    10_f32.powf(decade) * sign * (main + cross[row][column])
                };
                TriadCoefficients {
                    offset,
                    matrix: std::array::from_fn(|row| {
                        std::array::from_fn(|column| element(row, column))
                    }),
                    offset_uncertainty,
                    matrix_uncertainty,
                    delay_s,
                }
            },
        )
}
