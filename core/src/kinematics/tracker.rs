//! Pose after pose of a recorded run.
//!
//! A sample is a short way from the one before it, so each is solved from the last pose. Where that does not work (the
//! first sample, a gap in the record, a bad sample before) it is solved from home. Both keep to home's branch, so that
//! every pose of a run is on it, and no sample is missed that [`Solver::solve`] finds.

use nalgebra::RealField;

use super::forward::{ForwardError, Solution, Solver};
use super::pose::Pose;

/// Solves the samples of a run one after another.
#[derive(Clone, Debug)]
pub struct Tracker<'a, T: RealField + Copy> {
    solver: &'a Solver<T>,
    last: Option<Pose<T>>,
}

impl<'a, T: RealField + Copy> Tracker<'a, T> {
    /// A tracker that has seen no sample yet.
    #[must_use]
    pub fn new(solver: &'a Solver<T>) -> Self {
        Self { solver, last: None }
    }

    /// The pose with hinge-to-hinge `lengths`, m, of the next sample, on home's branch.
    ///
    /// # Errors
    /// Those of [`Solver::solve`]; the sample after is then solved from home.
    pub fn next(&mut self, lengths: &[T; 6]) -> Result<Solution<T>, ForwardError<T>> {
        let tracked = self
            .last
            .and_then(|last| self.solver.track(lengths, &last).ok());
        let found = match tracked {
            Some(solution) => Ok(solution),
            None => self.solver.solve(lengths),
        };
        self.last = found.as_ref().ok().map(|solution| solution.pose);
        found
    }
}
