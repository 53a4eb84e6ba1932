//! Sums and squares with the part that rounding takes away.
//!
//! ```text
//! a + b = s + e        s: the sum as rounded                    O. Møller, BIT 5 (1965); D. E. Knuth, TAOCP 2, 4.2.2
//! a²    = p + e        a = h + l with half the digits each      G. W. Veltkamp; T. J. Dekker, Numer. Math. 18 (1971)
//! ```
//!
//! Home needs ½·(l² − |d|²) to a fraction of the last place of l², where both squares are a hundred million times
//! larger.

use nalgebra::{RealField, convert};

use super::six::Triple;

/// a + b as rounded, and what rounding took away.
pub(super) fn sum<T: RealField + Copy>(a: T, b: T) -> (T, T) {
    let sum = a + b;
    let b_taken = sum - a;
    let a_taken = sum - b_taken;
    (sum, (a - a_taken) + (b - b_taken))
}

/// a² as rounded, and what rounding took away: all of it in `f32`; `f64`, split at the same digit, has some to spare.
fn square<T: RealField + Copy>(a: T) -> (T, T) {
    let scaled = a * convert(4097.0);
    let high = scaled - (scaled - a);
    let low = a - high;
    let square = a * a;
    let taken = ((high * high - square) + (high * low + low * high)) + low * low;
    (square, taken)
}

/// l² − |d|², rounded about once.
pub(super) fn square_less_squares<T: RealField + Copy>(l: T, d: &Triple<T>) -> T {
    let (mut total, mut rest) = square(l);
    for coordinate in d {
        let (product, taken) = square(*coordinate);
        let (next, error) = sum(total, -product);
        total = next;
        rest += error - taken;
    }
    total + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_in_single_precision_differ_as_in_double() {
        for step in 1..200 {
            let d = [0.3, 2.1, -1.7].map(|x: f32| x * (1.0 + step as f32 * 0.013));
            let length = d.iter().map(|x| x * x).sum::<f32>().sqrt();
            let truth =
                f64::from(length).powi(2) - d.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>();
            let found = square_less_squares(length, &d);
            // The carried errors are of the size ε·l², and so their own rounding is of ε²·l².
            let half_place = f64::from(f32::EPSILON) / 2.0;
            let limit = 16.0 * (half_place * f64::from(length)).powi(2) + half_place * truth.abs();
            let off = (f64::from(found) - truth).abs();
            assert!(off <= limit, "{off:e} for {length} m, limit {limit:e}");
        }
    }
}
