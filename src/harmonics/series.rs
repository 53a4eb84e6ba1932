//! The harmonic fit of a recorded series, and the drive frequency found from it.
//!
//! The motion controller's clock is not the board's, so the frequency that was driven is fitted from the measured
//! pose: Gauss-Newton on ω with the columns of the fit and the derivative of the first harmonic with respect to ω,
//!
//! ```text
//! ∂u/∂ω = n·(−a₁ sin ωn + b₁ cos ωn)
//! ```

use nalgebra::SVector;

use super::{HARMONICS, Harmonics, REGRESSORS};
use crate::least_squares::NormalEquations;

/// Columns of the fit at phase `theta` (rad) and place `fraction` in the window (−½ to ½).
fn regressors(theta: f64, fraction: f64) -> SVector<f64, REGRESSORS> {
    let mut row = SVector::zeros();
    row[0] = 1.0;
    row[1] = fraction;
    for k in 0..HARMONICS {
        (row[3 + 2 * k], row[2 + 2 * k]) = libm::sincos((k + 1) as f64 * theta);
    }
    row
}

/// A fit at `omega` rad per sample over a window of `length` samples; sample 0 has phase zero.
#[derive(Debug, Clone)]
pub struct Series {
    omega: f64,
    length: usize,
    taken: usize,
    equations: NormalEquations<REGRESSORS>,
}

impl Series {
    /// Starts a fit over `length` samples at `omega` rad per sample; below π/5, so that the fifth harmonic is no alias.
    #[must_use]
    pub fn new(omega: f64, length: usize) -> Self {
        Self {
            omega,
            length,
            taken: 0,
            equations: NormalEquations::default(),
        }
    }

    /// Fits a whole slice; `None` when it is too short for the twelve unknowns or holds a number that is not finite.
    #[must_use]
    pub fn fit(omega: f64, values: &[f64]) -> Option<Harmonics> {
        let mut series = Self::new(omega, values.len());
        values.iter().for_each(|value| series.push(*value));
        series.solve()
    }

    /// Takes the next sample.
    pub fn push(&mut self, value: f64) {
        let (theta, fraction) = (
            self.omega * self.taken as f64,
            fraction(self.taken, self.length),
        );
        self.equations.add(&regressors(theta, fraction), value, 1.0);
        self.taken += 1;
    }

    /// The harmonics; `None` when the samples do not determine them.
    #[must_use]
    pub fn solve(&self) -> Option<Harmonics> {
        let solution = self
            .equations
            .solve()
            .filter(|solution| solution.degrees_of_freedom > 0)?;
        let variance = solution.residual_square / f64::from(solution.degrees_of_freedom);
        let rms = libm::sqrt(solution.residual_square / self.taken as f64);
        Some(Harmonics::from_fit(
            &solution.unknowns,
            &(solution.cofactors * variance),
            rms,
        ))
    }
}

fn fraction(sample: usize, length: usize) -> f64 {
    (sample as f64 + 0.5) / length as f64 - 0.5
}

/// Refines the drive frequency from `start` (rad per sample) on a series that is mostly that one sine.
///
/// Returns rad per sample; `None` when the series does not determine it, or the search leaves ±20 % of `start` or
/// does not come to rest.
#[must_use]
pub fn fit_frequency(values: &[f64], start: f64) -> Option<f64> {
    const STEPS: usize = 12;
    let mut omega = start;
    for _ in 0..STEPS {
        let first = Series::fit(omega, values)?.first();
        let mut equations = NormalEquations::<{ REGRESSORS + 1 }>::default();
        for (n, value) in values.iter().enumerate() {
            let fraction = fraction(n, values.len());
            let base = regressors(omega * n as f64, fraction);
            let mut row = SVector::<f64, { REGRESSORS + 1 }>::zeros();
            row.fixed_rows_mut::<REGRESSORS>(0).copy_from(&base);
            // The place in the window instead of n keeps the columns of one size.
            row[REGRESSORS] = fraction * (first.sine * base[2] - first.cosine * base[3]);
            equations.add(&row, *value, 1.0);
        }
        let step = equations.solve()?.unknowns[REGRESSORS] / values.len() as f64;
        omega += step;
        if !((0.8 * start)..=(1.2 * start)).contains(&omega) {
            return None;
        }
        if step.abs() < 1e-10 * omega {
            return Some(omega);
        }
    }
    None
}
