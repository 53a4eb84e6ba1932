//! Linear least squares with few unknowns, row by row and without allocation.
//!
//! The normal equations are summed in `f64`. Every fit of this crate has well-scaled columns (sines, fractions of a
//! window, unit-sized physical quantities), so this costs no accuracy:
//!
//! ```text
//! minimise Σ w (y − x·β)²     ⇒  (Σ w x xᵀ) β = Σ w x y      cov β = σ² (Σ w x xᵀ)⁻¹
//! ```

use nalgebra::{SMatrix, SVector};

/// Least part of a column, in squares, that the other columns must leave unexplained for it to be determined: well
/// above the rounding errors of a column that they explain completely.
const LEAST_UNEXPLAINED: f64 = 1e-12;

/// Normal equations of a fit with `P` unknowns.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NormalEquations<const P: usize>(SharedEquations<P, 1>);

/// Normal equations of `C` fits with the same columns and weights and different values: the matrix, most of the work,
/// is formed and inverted once.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedEquations<const P: usize, const C: usize> {
    gram: SMatrix<f64, P, P>,
    moments: SMatrix<f64, P, C>,
    squares: [f64; C],
    rows: u32,
}

/// Solution of a fit with `P` unknowns.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution<const P: usize> {
    /// The unknowns, in the units of their columns.
    pub unknowns: SVector<f64, P>,
    /// (Σ w x xᵀ)⁻¹: times the variance of a row of weight one, the covariance of the unknowns.
    pub cofactors: SMatrix<f64, P, P>,
    /// Σ w (y − x·β)², never below zero.
    pub residual_square: f64,
    /// Rows less unknowns.
    pub degrees_of_freedom: u32,
}

impl<const P: usize, const C: usize> Default for SharedEquations<P, C> {
    fn default() -> Self {
        Self {
            gram: SMatrix::zeros(),
            moments: SMatrix::zeros(),
            squares: [0.0; C],
            rows: 0,
        }
    }
}

impl<const P: usize> NormalEquations<P> {
    /// Adds the row `columns`·β = `value` with weight `weight` (1/variance; 1 for a plain fit).
    pub fn add(&mut self, columns: &SVector<f64, P>, value: f64, weight: f64) {
        self.0.add(columns, &[value], weight);
    }

    /// Solves for the unknowns; `None` when the rows do not determine them all.
    #[must_use]
    pub fn solve(&self) -> Option<Solution<P>> {
        self.0.solve().map(|[solution]| solution)
    }
}

impl<const P: usize, const C: usize> SharedEquations<P, C> {
    /// Adds the row `columns`·β = `values[c]` to each fit c, with weight `weight` (1/variance; 1 for a plain fit).
    pub fn add(&mut self, columns: &SVector<f64, P>, values: &[f64; C], weight: f64) {
        self.gram.ger(weight, columns, columns, 1.0);
        for (channel, value) in values.iter().enumerate() {
            let mut moment = self.moments.column_mut(channel);
            moment.axpy(weight * value, columns, 1.0);
            self.squares[channel] += weight * value * value;
        }
        self.rows += 1;
    }

    /// Solves all fits; `None` when the rows do not determine all unknowns.
    #[must_use]
    pub fn solve(&self) -> Option<[Solution<P>; C]> {
        let cholesky = self.gram.cholesky()?;
        let pivots = cholesky.l_dirty().diagonal();
        let determined = pivots
            .iter()
            .zip(self.gram.diagonal().iter())
            .all(|(pivot, square)| pivot * pivot > LEAST_UNEXPLAINED * square);
        let cofactors = cholesky.inverse();
        let unknowns = cofactors * self.moments;
        if !determined || !unknowns.iter().all(|unknown| unknown.is_finite()) {
            return None;
        }
        let degrees_of_freedom = self.rows.saturating_sub(P as u32);
        Some(core::array::from_fn(|channel| {
            let unknowns: SVector<f64, P> = unknowns.column(channel).into();
            let explained = unknowns.dot(&self.moments.column(channel));
            Solution {
                residual_square: (self.squares[channel] - explained).max(0.0),
                unknowns,
                cofactors,
                degrees_of_freedom,
            }
        }))
    }
}
