//! Cholesky's factor of the fit's symmetric matrix, in `f64` and without a matrix library: board and host do the same
//! operations in the same order, so that they come to the same bits.

use super::REGRESSORS;
use super::replay::TRIANGLE;

/// A column of the fit.
pub(super) type Column = [f64; REGRESSORS];

/// Least part of a column, in squares, that the columns before must leave unexplained for it to be determined. Below it
/// an uncertainty is a thousand times what it would be alone, and such a fit is of no use.
const LEAST_UNEXPLAINED: f64 = 1e-6;

/// L of L·Lᵀ, its diagonal inverted; row after row.
pub(super) struct Factor([f64; TRIANGLE]);

/// Where a row begins.
const fn row(index: usize) -> usize {
    index * (index + 1) / 2
}

impl Factor {
    /// The factor of a matrix given by its lower triangle; `None` when it does not determine all unknowns.
    pub(super) fn new(mut matrix: [f64; TRIANGLE]) -> Option<Self> {
        for i in 0..REGRESSORS {
            for j in 0..i {
                let known = dot(&matrix, i, j, j);
                matrix[row(i) + j] = (matrix[row(i) + j] - known) * matrix[row(j) + j];
            }
            let square = matrix[row(i) + i];
            let unexplained = square - dot(&matrix, i, i, i);
            let determined = unexplained > LEAST_UNEXPLAINED * square;
            // Not a number is not greater either.
            if !determined {
                return None;
            }
            matrix[row(i) + i] = 1.0 / libm::sqrt(unexplained);
        }
        Some(Self(matrix))
    }

    /// The solution for a right-hand side.
    pub(super) fn solve(&self, mut side: Column) -> Column {
        let Self(factor) = self;
        for i in 0..REGRESSORS {
            for j in 0..i {
                side[i] -= factor[row(i) + j] * side[j];
            }
            side[i] *= factor[row(i) + i];
        }
        for i in (0..REGRESSORS).rev() {
            for j in i + 1..REGRESSORS {
                side[i] -= factor[row(j) + i] * side[j];
            }
            side[i] *= factor[row(i) + i];
        }
        side
    }
}

/// Product of the first `length` elements of rows `i` and `j`.
fn dot(matrix: &[f64; TRIANGLE], i: usize, j: usize, length: usize) -> f64 {
    let (a, b) = (&matrix[row(i)..][..length], &matrix[row(j)..][..length]);
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
