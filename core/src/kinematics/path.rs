//! What the solver does where Newton's method does not contract: it follows the branch, or descends to the nearest pose.
//!
//! [`Home::follow`] takes the squares of the lengths along a straight line from those of a known pose to the
//! wanted ones, F(λ) = λ·F(1) + (1 − λ)·F(0), in steps on which Newton's method contracts and det J keeps its sign.
//! So the pose stays on its branch. The stroke is a box, so a path between two sets of lengths inside it stays inside
//! it. The path ends early only where the branch does, at a singular pose.
//!
//! [`Home::descend`] minimises |F|² from a guess (Levenberg-Marquardt: D. W. Marquardt, J. SIAM 11 (1963)). With the
//! Newton matrix N and D the unit matrix with the squared radius of the hinges in its lower half,
//!
//! ```text
//! (NᵀN + μ·D)·(u, w) = Nᵀ·F
//! ```
//!
//! It needs no regular Jacobian, and it keeps to no branch: it is for guesses, not for tracking.

use nalgebra::{Matrix6, RealField, Vector6, convert};

use super::{
    excursion::{Excursion, Home, Placed},
    newton::{Arrival, Stop},
    six::{Six, dot},
};

/// A way that led to no pose.
#[derive(Clone, Copy)]
pub(super) struct Stuck<T> {
    /// Where it ended.
    pub excursion: Excursion<T>,
    /// Why.
    pub end: End,
}

/// Why a way ended.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// The budget of iterations is spent.
    Exhausted,
    /// Not even the first step could be made.
    AtStart,
    /// No step led on.
    OnTheWay,
}

impl<T: RealField + Copy> Home<T> {
    /// Follows the branch of `start` until |F| for `demand` is at most `tolerance`, m².
    #[cold]
    #[inline(never)]
    pub fn follow(
        &self,
        start: Excursion<T>,
        demand: &Six<T>,
        tolerance: T,
        budget: &mut u32,
    ) -> Result<Arrival<T>, Stuck<T>> {
        let (_, away) = self.place(&start, demand);
        let sign = self.determinant(&start).signum();
        // On the way a ten-thousandth of the radius is near enough, and the end of the branch is known as well.
        let coarse = tolerance.max(self.radius_squared * convert(1e-4));
        let mut here = start;
        let (mut done, mut step) = (T::zero(), convert::<f64, T>(0.5));
        loop {
            let aim = (done + step).min(T::one());
            let left = T::one() - aim;
            let on_the_way = *demand - away * left;
            let near_enough = if left > T::zero() { coarse } else { tolerance };
            let arrival = self.iterate_pivoting(here, &on_the_way, near_enough, budget);
            match arrival {
                Ok(arrival) if self.determinant(&arrival.excursion) * sign > T::zero() => {
                    if left <= T::zero() {
                        return Ok(arrival);
                    }
                    here = arrival.excursion;
                    done = aim;
                    step *= convert(2.0);
                }
                Ok(_) | Err(Stop::NotContracting) if step * away.largest() > coarse => {
                    step *= convert(0.25)
                }
                arrival => {
                    let end = match arrival {
                        Err(Stop::Exhausted) => End::Exhausted,
                        _ if done > T::zero() => End::OnTheWay,
                        _ => End::AtStart,
                    };
                    return Err(Stuck {
                        excursion: here,
                        end,
                    });
                }
            }
        }
    }

    /// Descends from `start` until |F| for `demand` is at most `tolerance`, m².
    #[cold]
    #[inline(never)]
    pub fn descend(
        &self,
        start: Excursion<T>,
        demand: &Six<T>,
        tolerance: T,
        budget: &mut u32,
    ) -> Result<Arrival<T>, Stuck<T>> {
        let mut here = start;
        let (mut placed, mut residuals) = self.place(&here, demand);
        let mut damping: T = convert(1e-3);
        while residuals.largest() > tolerance {
            let stuck = |end| Stuck {
                excursion: here,
                end,
            };
            *budget = budget.checked_sub(1).ok_or(stuck(End::Exhausted))?;
            let next = self.damped(&here, &placed, &residuals, damping);
            let (next_placed, next_residuals) = self.place(&next, demand);
            if (next_residuals * next_residuals).sum() < (residuals * residuals).sum() {
                (here, placed, residuals) = (next, next_placed, next_residuals);
                damping *= convert(0.1);
            } else if damping < convert(1e6) {
                damping *= convert(10.0);
            } else {
                return Err(stuck(End::OnTheWay));
            }
        }
        let end = |stop| match stop {
            Stop::Exhausted => End::Exhausted,
            Stop::NotContracting => End::OnTheWay,
        };
        self.iterate_pivoting(here, demand, tolerance, budget)
            .map_err(|stop| Stuck {
                excursion: here,
                end: end(stop),
            })
    }

    /// `here` after one step with `damping` relative to the mean square of the jacks' lengths; `here` itself if the
    /// step cannot be computed.
    fn damped(
        &self,
        here: &Excursion<T>,
        placed: &Placed<T>,
        residuals: &Six<T>,
        damping: T,
    ) -> Excursion<T> {
        let rows = placed.rows();
        let matrix = Matrix6::from_fn(|k, axis| {
            if axis < 3 {
                rows.direction[axis].0[k]
            } else {
                rows.moment[axis - 3].0[k]
            }
        });
        let mean_square = dot(&rows.direction, &rows.direction).sum() / convert(6.0);
        let mut normal = matrix.tr_mul(&matrix);
        for axis in 0..6 {
            let weight = if axis < 3 {
                T::one()
            } else {
                self.radius_squared
            };
            normal[(axis, axis)] += damping * mean_square * weight;
        }
        let right = matrix.tr_mul(&Vector6::from(residuals.0));
        match normal.cholesky() {
            Some(factor) => {
                let step = factor.solve(&right);
                here.moved(&[step[0], step[1], step[2]], &[step[3], step[4], step[5]])
            }
            None => *here,
        }
    }
}
