//! Cosine and sine of a phase and of its multiples, as integers of 20 bits, by the same few instructions for every
//! phase.
//!
//! A phase is a fraction of a turn in the bits of an integer; additions wrap by themselves. The table has 2048 entries,
//! of which a quarter is stored (2 KiB). The nearest entry is an angle δ of at most π/2048 away, and the addition
//! theorem to the second order gives the first harmonic to 1e-9. The others follow by Chebyshev's recurrence:
//!
//! ```text
//! sin(a + δ) ≈ sin a + δ cos a − δ²/2 sin a        cos(a + δ) ≈ cos a − δ sin a − δ²/2 cos a
//! cos kθ = 2 cos θ cos (k−1)θ − cos (k−2)θ         sin kθ = 2 cos θ sin (k−1)θ − sin (k−2)θ
//! ```
//!
//! All values differ by less than one part in 10⁶ from the true ones, nearly all of it their rounding to 20 bits. Board
//! and host compute them with the same integers, and [`super::solution`] solves with these very values and with their
//! rounding, [`Rest`].

/// Harmonics that are estimated: the drive frequency and its multiples up to the fifth.
pub const HARMONICS: usize = 5;
/// Bits of a phase that choose an entry; the first two are the quarter of the turn.
const BITS: u32 = 11;
/// Entries of a whole turn.
const ENTRIES: usize = 1 << BITS;
/// Entries of the first quarter.
const KEPT: usize = ENTRIES / 4;
/// A sine of one in the table: 30 bits behind the point.
pub const UNIT: f64 = 1_073_741_824.0;
const UNIT_BITS: u32 = 30;
/// Bits behind the point of the results.
const OUT_BITS: u32 = 20;
/// A sine of one, in the results.
pub const ONE: i32 = 1 << OUT_BITS;
const QUARTER: u32 = 1 << 30;
/// Bits behind the point of the angle δ, rad.
const ANGLE_BITS: u32 = 39;
/// From δ as a part of half an entry, ±2³¹, to rad with [`ANGLE_BITS`]; the product's lower 32 bits are cut off.
const RADIANS: i32 =
    (core::f64::consts::PI / ENTRIES as f64 * (1_u64 << (ANGLE_BITS + 1)) as f64) as i32;

/// The first quarter of a turn of the sine. An entry stands for the phases from its own up to the next, and holds the
/// sine of their middle. So cutting off the lower bits of a phase finds the nearest entry, and the other quarters have
/// the same entries, backwards or negative.
static SINE: [i32; KEPT] = {
    let mut table = [0; KEPT];
    let mut index = 0;
    while index < KEPT {
        // Of (index + ½) / 2048 turns, by Taylor's series; exact to far below one step.
        let angle = core::f64::consts::TAU * (index as f64 + 0.5) / ENTRIES as f64;
        table[index] = (taylor(angle, angle, 2.0) * UNIT + 0.5) as i32;
        index += 1;
    }
    table
};

/// Sine of the middle of the entry of `phase` (turns · 2³²), without a branch.
#[inline(always)]
fn nearest(phase: u32) -> i32 {
    // All ones in the second and fourth quarter, which are read backwards, and in the second half, which is negative.
    let backwards = ((phase << 1) as i32 >> 31) as u32;
    let negative = phase as i32 >> 31;
    let entry = SINE[((phase >> (u32::BITS - BITS)) ^ backwards) as usize % KEPT];
    (entry ^ negative) - negative
}

/// Σ of the alternating series with the first term `term`, whose next term divides by `n`(`n`+1), and so on, until a
/// term no longer counts.
#[inline(never)]
const fn taylor(angle: f64, mut term: f64, mut n: f64) -> f64 {
    let mut sum = 0.0;
    while sum + term != sum {
        sum += term;
        term *= -angle * angle / (n * (n + 1.0));
        n += 2.0;
    }
    sum
}

/// Cosine and sine of the multiples 1 to 5 of a phase, times [`ONE`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Waves {
    /// cos θ, cos 2θ, … cos 5θ.
    pub cosine: [i32; HARMONICS],
    /// sin θ, sin 2θ, … sin 5θ.
    pub sine: [i32; HARMONICS],
}

impl Waves {
    /// The waves at `phase` (turns · 2³²).
    #[must_use]
    #[inline]
    pub fn at(phase: u32) -> Self {
        let (cosine, sine) = first(phase);
        Self {
            cosine: multiples(cosine, 1 << UNIT_BITS, cosine),
            sine: multiples(cosine, 0, sine),
        }
    }
}

/// The true cosines and sines less [`Waves`], times [`UNIT`]; to some 1e-9, the fifth to 1e-8.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rest {
    /// Of cos θ, cos 2θ, … cos 5θ.
    pub cosine: [i32; HARMONICS],
    /// Of sin θ, sin 2θ, … sin 5θ.
    pub sine: [i32; HARMONICS],
}

impl Rest {
    /// The rest of `waves`, which were looked up by the upper half of `phase` (turns · 2⁶⁴).
    ///
    /// The multiples are powers of cos θ + i·sin θ, which do not multiply errors as the recurrence does near zero.
    #[must_use]
    pub fn of(waves: &Waves, phase: u64) -> Self {
        let one = turned(first((phase >> 32) as u32), phase as u32);
        let mut rest = Self {
            cosine: [0; HARMONICS],
            sine: [0; HARMONICS],
        };
        let mut power = one;
        for k in 0..HARMONICS {
            rest.cosine[k] = power.0 - (waves.cosine[k] << (UNIT_BITS - OUT_BITS));
            rest.sine[k] = power.1 - (waves.sine[k] << (UNIT_BITS - OUT_BITS));
            power = (
                scaled(product(power.0, one.0) - product(power.1, one.1)),
                scaled(product(power.0, one.1) + product(power.1, one.0)),
            );
        }
        rest
    }
}

/// Turned by the part of a phase below the table's resolution, turns · 2⁶⁴: a step or two of the unit.
fn turned((cosine, sine): (i32, i32), below: u32) -> (i32, i32) {
    const BITS: u32 = 40;
    const UNITS: i64 = (core::f64::consts::TAU * UNIT * (1_u64 << BITS) as f64
        / 18_446_744_073_709_551_616.0) as i64;
    let angle = ((i64::from(below) * UNITS + (1 << (BITS - 1))) >> BITS) as i32;
    (
        cosine - scaled(product(sine, angle)),
        sine + scaled(product(cosine, angle)),
    )
}

fn product(a: i32, b: i32) -> i64 {
    i64::from(a) * i64::from(b)
}

/// A product of two units as one, rounded.
fn scaled(wide: i64) -> i32 {
    ((wide + (1 << (UNIT_BITS - 1))) >> UNIT_BITS) as i32
}

/// Sine and cosine of an angle of at most half a turn, rad, by the same operations everywhere; to 1e-15.
#[inline(never)]
pub(super) fn sine_cosine(angle: f64) -> (f64, f64) {
    (taylor(angle, angle, 2.0), taylor(angle, 1.0, 1.0))
}

/// Upper half of the product.
#[inline(always)]
fn high(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 32) as i32
}

/// Cosine and sine of a phase, with [`UNIT_BITS`].
#[inline(always)]
fn first(phase: u32) -> (i32, i32) {
    let sine = nearest(phase);
    let cosine = nearest(phase.wrapping_add(QUARTER));
    let within = ((phase << BITS) ^ (1 << 31)) as i32;
    let angle = high(within, RADIANS);
    let square = high(angle, angle);
    // Position of a product's point after its lower half is cut off, and its distance above the unit's.
    const FIRST_ORDER: u32 = ANGLE_BITS - 32;
    const SECOND_ORDER: u32 = 2 * ANGLE_BITS - 32 - 32 + 1;
    (
        cosine - (high(angle, sine) >> FIRST_ORDER) - (high(square, cosine) >> SECOND_ORDER),
        sine + (high(angle, cosine) >> FIRST_ORDER) - (high(square, sine) >> SECOND_ORDER),
    )
}

/// A wave and its multiples by Chebyshev's recurrence: `zeroth` at zero times the phase, `first` at once; rounded.
#[inline(always)]
fn multiples(cosine: i32, zeroth: i32, first: i32) -> [i32; HARMONICS] {
    const HALF: i32 = 1 << (UNIT_BITS - OUT_BITS - 1);
    // Twice the product, whose point is at 28.
    let next = |now, before| (high(cosine, now) << (32 - UNIT_BITS + 1)).wrapping_sub(before);
    let second = next(first, zeroth);
    let third = next(second, first);
    let fourth = next(third, second);
    let fifth = next(fourth, third);
    let rounded = |wave: i32| (wave + HALF) >> (UNIT_BITS - OUT_BITS);
    [
        rounded(first),
        rounded(second),
        rounded(third),
        rounded(fourth),
        rounded(fifth),
    ]
}
