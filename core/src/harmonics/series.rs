//! The harmonic fit of a recorded series, and the drive frequency found from it.
//!
//! The motion controller's clock is not the board's, so the drive frequency is fitted to the measured pose:
//! Gauss-Newton on ω with the columns of the fit and the derivative of the first harmonic with respect to ω,
//!
//! ```text
//! ∂u/∂ω = n·(−a₁ sin ωn + b₁ cos ωn)
//! ```

use nalgebra::SVector;

use super::{Cofactors, HARMONICS, Harmonic, Harmonics, REGRESSORS};
use crate::least_squares::{NormalEquations, SharedEquations, Solution};

/// Columns of the fit at phase `theta` (rad) and place `fraction` in the window (−½ to ½).
fn regressors(theta: f64, fraction: f64) -> SVector<f64, REGRESSORS> {
    let mut row = SVector::zeros();
    row[0] = 1.0;
    row[1] = fraction;
    let (sine, cosine) = libm::sincos(theta);
    (row[2], row[3]) = (cosine, sine);
    for k in 1..HARMONICS {
        let (c, s) = (row[2 * k], row[1 + 2 * k]);
        (row[2 + 2 * k], row[3 + 2 * k]) = (c * cosine - s * sine, s * cosine + c * sine);
    }
    row
}

/// The fit of one signal or of several that were sampled together.
#[derive(Debug, Clone, Copy)]
pub struct Series;

impl Series {
    /// Fits a slice at `omega` rad per sample, below π/5, so that the fifth harmonic is not an alias; sample 0 has
    /// phase zero. `None` when it is too short for the twelve unknowns or holds a number that is not finite.
    #[must_use]
    pub fn fit(omega: f64, values: &[f64]) -> Option<Harmonics> {
        Self::fit_all(omega, values.iter().map(|value| [*value])).map(|[fit]| fit)
    }

    /// Fits `C` signals sampled at the same instants, one item of `samples` for each instant; otherwise as
    /// [`Series::fit`].
    #[must_use]
    pub fn fit_all<const C: usize>(
        omega: f64,
        samples: impl ExactSizeIterator<Item = [f64; C]>,
    ) -> Option<[Harmonics; C]> {
        let length = samples.len();
        let mut equations = SharedEquations::<REGRESSORS, C>::default();
        for (n, values) in samples.enumerate() {
            let row = regressors(omega * n as f64, fraction(n, length));
            equations.add(&row, &values, 1.0);
        }
        let solutions = equations.solve()?;
        if solutions[0].degrees_of_freedom == 0 {
            return None;
        }
        Some(solutions.map(|solution| {
            let variance = solution.residual_square / f64::from(solution.degrees_of_freedom);
            let rms = libm::sqrt(solution.residual_square / length as f64);
            fitted(&solution, variance, rms)
        }))
    }
}

fn fitted(solution: &Solution<REGRESSORS>, variance: f64, residual_rms: f64) -> Harmonics {
    let (unknowns, inverse) = (&solution.unknowns, &solution.cofactors);
    let harmonics = core::array::from_fn(|k| Harmonic {
        cosine: unknowns[2 + 2 * k],
        sine: unknowns[3 + 2 * k],
    });
    let cofactors = Cofactors {
        offset: inverse[(0, 0)],
        drift: inverse[(1, 1)],
        harmonics: core::array::from_fn(|k| {
            let (cosine, sine) = (2 + 2 * k, 3 + 2 * k);
            [(cosine, cosine), (cosine, sine), (sine, sine)].map(|place| inverse[place])
        }),
    };
    Harmonics {
        offset: unknowns[0],
        drift: unknowns[1],
        harmonics,
        residual_rms,
        uncertainty: cofactors.uncertainty(&harmonics, variance),
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
    let mut first = Series::fit(omega, values)?.first();
    for _ in 0..STEPS {
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
        let unknowns = equations.solve()?.unknowns;
        let step = unknowns[REGRESSORS] / values.len() as f64;
        omega += step;
        if !((0.8 * start)..=(1.2 * start)).contains(&omega) {
            return None;
        }
        if step.abs() < 1e-10 * omega {
            return Some(omega);
        }
        first = Harmonic {
            cosine: unknowns[2],
            sine: unknowns[3],
        };
    }
    None
}
