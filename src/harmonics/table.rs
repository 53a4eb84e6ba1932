//! Sine and cosine as integers of 15 bits, looked up by phase.
//!
//! A phase is a 64-bit fraction of a turn; adding wraps by itself, and k times a phase is the phase of harmonic k.
//! Between the 1024 entries the value is interpolated linearly, which is off by at most (2π/1024)²/8 = 4.7e-6; rounding
//! to integers adds at most 1.5 steps of 1/32767, 4.6e-5. [`super::solution`] takes both into account exactly.

const BITS: u32 = 10;
const ENTRIES: usize = 1 << BITS;
/// Value of the table at a sine of one.
pub const ONE: i32 = 32_767;

/// One turn of the sine, with the first entry repeated at the end for interpolation.
static SINE: [i16; ENTRIES + 1] = {
    let mut table = [0; ENTRIES + 1];
    let mut index = 0;
    while index <= ENTRIES {
        table[index] = rounded_sine(index);
        index += 1;
    }
    table
};

/// Sine of `index` / 1024 turns, by Taylor's series on the first eighth of a turn; exact to far below one step.
const fn rounded_sine(index: usize) -> i16 {
    let index = index % ENTRIES;
    let (quadrant, within) = (index / (ENTRIES / 4), index % (ENTRIES / 4));
    let angle = core::f64::consts::TAU * within as f64 / ENTRIES as f64;
    let (sine, cosine) = (taylor(angle, angle, 2.0), taylor(angle, 1.0, 1.0));
    let value = match quadrant {
        0 => sine,
        1 => cosine,
        2 => -sine,
        _ => -cosine,
    } * ONE as f64;
    (if value < 0.0 {
        value - 0.5
    } else {
        value + 0.5
    }) as i16
}

/// Σ of the alternating series whose first term is `term` and whose next divides by `n`(`n`+1), and so on.
const fn taylor(angle: f64, mut term: f64, mut n: f64) -> f64 {
    let mut sum = 0.0;
    let mut count = 0;
    while count < 14 {
        sum += term;
        term *= -angle * angle / (n * (n + 1.0));
        n += 2.0;
        count += 1;
    }
    sum
}

/// Sine of `phase` (turns · 2⁶⁴), times [`ONE`].
#[must_use]
#[inline]
pub fn sine(phase: u64) -> i32 {
    let index = (phase >> (64 - BITS)) as usize & (ENTRIES - 1);
    let fraction = (phase >> (64 - BITS - 15)) as i32 & 0x7FFF;
    let (from, to) = (i32::from(SINE[index]), i32::from(SINE[index + 1]));
    from + (((to - from) * fraction) >> 15)
}

/// Cosine of `phase` (turns · 2⁶⁴), times [`ONE`].
#[must_use]
#[inline]
pub fn cosine(phase: u64) -> i32 {
    sine(phase.wrapping_add(1 << 62))
}
