//! Newton's method on the equations of [`super::excursion`].
//!
//! ```text
//! d_k·u + (c_k × d_k)·w = F_k     solved for the step (u, w)
//! ```
//!
//! Three refinements of the Newton-Kantorovich iteration:
//! - Where one more step with the last matrix is enough, the matrix is kept (Kantorovich's modified method, a chord
//!   step): it leaves about twice the last contraction times the last residual.
//! - From home the matrix is known beforehand, and the step is carried to second order: with t_k = w × b_k, Newton's
//!   step leaves −½·|u + t_k|² − ½·d°_k·(w × t_k) out of F_k.
//! - A step longer than half of the one before it means that the start was too far off: Newton's method may leave the
//!   branch (the monotonicity test of P. Deuflhard, "Newton Methods for Nonlinear Problems", 2004).
//!   The iteration stops there, and the caller takes another way.

use nalgebra::{RealField, convert};

use super::{
    excursion::{Excursion, Home, Placed},
    linear::Factors,
    six::{Six, Triple, combine, cross, dot, each},
};

/// A Newton matrix with the order its jacks had to be put in, if another than home's.
#[derive(Clone, Copy)]
struct Matrix<T> {
    factors: Factors<T>,
    order: Option<[usize; 6]>,
}

/// Where the iteration has arrived.
#[derive(Clone, Copy)]
pub(super) struct Arrival<T> {
    pub excursion: Excursion<T>,
    /// Greatest |F_k|, m².
    pub residual: T,
    /// Determinant of the matrix at the start.
    pub first_determinant: T,
    /// Determinant of the last matrix, or of one at the arrival.
    pub determinant: T,
    /// Square of the distance moved since that matrix was made, m².
    pub moved_squared: T,
    /// Whether both matrices were led by three jacks well apart, so that their determinants are exact.
    pub sure: bool,
}

/// Which three jacks lead in solving for a step.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Pivoting {
    /// Those that are best at home; elsewhere a step may lose digits, which the next one makes up for.
    AsAtHome,
    /// Those that are best where the step is made.
    Best,
}

/// Why the iteration stopped short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stop {
    /// A step was not shorter than half of the one before, or not a number.
    NotContracting,
    /// The budget of iterations is spent.
    Exhausted,
}

impl<T: RealField + Copy> Home<T> {
    /// The second-order step from home towards `demand`, and the square of its length to first order, m².
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn predict(&self, demand: &Six<T>) -> (Excursion<T>, T) {
        let (u, w) = self.factors.solve(demand);
        let turn = each(&w, Six::splat);
        let t = cross(&turn, &self.upper);
        let e = combine(
            &t,
            &u,
            #[inline(always)]
            |t, u| t + Six::splat(u),
        );
        let half: T = convert(0.5);
        let omitted = (dot(&e, &e) + dot(&self.jacks, &cross(&turn, &t))) * half;
        let (u2, w2) = self.factors.solve(&omitted);
        let (shift, turn) = (
            combine(
                &u,
                &u2,
                #[inline(always)]
                |a, b| a - b,
            ),
            combine(
                &w,
                &w2,
                #[inline(always)]
                |a, b| a - b,
            ),
        );
        (
            Self::none().moved(&shift, &turn),
            self.length_squared(&u, &w),
        )
    }

    #[inline(always)]
    fn length_squared(&self, u: &Triple<T>, w: &Triple<T>) -> T {
        dot(u, u) + self.radius_squared * dot(w, w)
    }

    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn matrix(&self, placed: &Placed<T>, pivoting: Pivoting) -> Matrix<T> {
        let rows = placed.rows();
        match pivoting {
            Pivoting::AsAtHome => Matrix {
                factors: rows.factor(),
                order: None,
            },
            Pivoting::Best => {
                let order = rows.best_order();
                Matrix {
                    factors: rows.ordered(&order).factor(),
                    order: Some(order),
                }
            }
        }
    }

    /// Determinant of the Newton matrix at `excursion`; zero or not finite if it is singular.
    pub fn determinant(&self, excursion: &Excursion<T>) -> T {
        let (placed, _) = self.place(excursion, &Six::splat(T::zero()));
        let matrix = self.matrix(&placed, Pivoting::AsAtHome);
        if self.well_led(&matrix) {
            matrix.factors.determinant
        } else {
            self.matrix(&placed, Pivoting::Best).factors.determinant
        }
    }

    /// Whether the three jacks that lead are well enough apart, against home, for the determinant to be exact.
    #[inline(always)]
    fn well_led(&self, matrix: &Matrix<T>) -> bool {
        matrix.factors.leading.abs() * convert(32.0) > self.factors.leading.abs()
    }

    /// [`Home::iterate`] for starts far from home and bad ones.
    #[cold]
    #[inline(never)]
    pub fn iterate_pivoting(
        &self,
        start: Excursion<T>,
        demand: &Six<T>,
        tolerance: T,
        budget: &mut u32,
    ) -> Result<Arrival<T>, Stop> {
        self.iterate(
            start,
            self.radius_squared,
            demand,
            tolerance,
            Pivoting::Best,
            budget,
        )
    }

    /// Newton's iteration from `start`, that a step of the squared length `last` led to, until the greatest
    /// |F_k| is at most `tolerance`, m². One iteration at least; each takes one off the `budget`.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn iterate(
        &self,
        start: Excursion<T>,
        mut last: T,
        demand: &Six<T>,
        tolerance: T,
        pivoting: Pivoting,
        budget: &mut u32,
    ) -> Result<Arrival<T>, Stop> {
        let mut excursion = start;
        let (placed, mut residuals) = self.place(&excursion, demand);
        let mut residual = residuals.largest();
        let mut matrix = self.matrix(&placed, pivoting);
        let first_determinant = matrix.factors.determinant;
        let sure = self.well_led(&matrix);
        let mut moved_squared = T::zero();
        loop {
            *budget = budget.checked_sub(1).ok_or(Stop::Exhausted)?;
            let (u, w) = matrix.solve(&residuals);
            let length_squared = self.length_squared(&u, &w);
            let contracting = length_squared <= last * convert(0.25);
            if !contracting {
                return Err(Stop::NotContracting);
            }
            last = length_squared;
            moved_squared += length_squared;
            excursion = excursion.moved(&u, &w);
            let before = residual;
            let placed;
            (placed, residuals) = self.place(&excursion, demand);
            residual = residuals.largest();
            if residual <= tolerance {
                break;
            }
            let chord_will_do = residual * residual * convert(4.0) <= tolerance * before;
            if !chord_will_do {
                matrix = self.matrix(&placed, pivoting);
                moved_squared = T::zero();
            }
        }
        // The last residual is worth one more step, unless it is tiny.
        if residual * convert(64.0) > tolerance {
            let (u, w) = matrix.solve(&residuals);
            excursion = excursion.moved(&u, &w);
        }
        Ok(Arrival {
            excursion,
            residual,
            first_determinant,
            determinant: matrix.factors.determinant,
            moved_squared,
            sure: sure & self.well_led(&matrix),
        })
    }
}

impl<T: RealField + Copy> Matrix<T> {
    #[inline(always)]
    fn solve(&self, residuals: &Six<T>) -> (Triple<T>, Triple<T>) {
        match self.order {
            None => self.factors.solve(residuals),
            Some(order) => self.factors.solve(&residuals.ordered(&order)),
        }
    }
}
