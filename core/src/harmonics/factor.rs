//! Cholesky's factor of the fit's symmetric matrix, in `f64` and without a matrix library: board and host do the same
//! operations in the same order and come to the same bits.
//!
//! No function here or in [`super::solution`] is inlined: the board runs them seldom, and the code stays small.

use super::REGRESSORS;
use super::replay::TRIANGLE;

/// A column of the fit.
pub(super) type Column = [f64; REGRESSORS];

/// Least part of a column, in squares, that the columns before it must leave unexplained: well above the rounding
/// errors of a column that they explain completely.
const LEAST_UNEXPLAINED: f64 = 1e-12;

/// L of L·Lᵀ, its diagonal inverted; row after row.
pub(super) struct Factor([f64; TRIANGLE]);

/// Where a row begins.
const fn row(index: usize) -> usize {
    index * (index + 1) / 2
}

impl Factor {
    /// The factor of a matrix given by its lower triangle; `None` when it does not determine all unknowns.
    #[inline(never)]
    pub(super) fn new(mut matrix: [f64; TRIANGLE]) -> Option<Self> {
        for i in 0..REGRESSORS {
            for j in 0..i {
                let known = dot(&matrix, i, j, j);
                matrix[row(i) + j] = (matrix[row(i) + j] - known) * matrix[row(j) + j];
            }
            let square = matrix[row(i) + i];
            let unexplained = square - dot(&matrix, i, i, i);
            // A comparison with not-a-number is false.
            let determined = unexplained > LEAST_UNEXPLAINED * square;
            if !determined {
                return None;
            }
            matrix[row(i) + i] = 1.0 / libm::sqrt(unexplained);
        }
        Some(Self(matrix))
    }

    /// A column of the inverse.
    #[inline(never)]
    pub(super) fn inverse(&self, column: usize) -> Column {
        let mut unit = [0.0; REGRESSORS];
        unit[column] = 1.0;
        self.solve(unit)
    }

    /// The solution for a right-hand side.
    #[inline(never)]
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
#[inline(never)]
fn dot(matrix: &[f64; TRIANGLE], i: usize, j: usize, length: usize) -> f64 {
    let (a, b) = (&matrix[row(i)..][..length], &matrix[row(j)..][..length]);
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
