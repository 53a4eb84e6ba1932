//! Pose after pose of a moving base.
//!
//! A sample is a short way from the one before it, so each is solved from the last pose; the first is solved from
//! home. Both ways keep to home's branch. Where a sample has no pose near the last one, the tracker's policy decides:
//!
//! | policy | such a sample | use |
//! |---|---|---|
//! | [`ReportFailure`] | is an error; the next one is solved from home | a live base: the next sample comes at once |
//! | [`SolveFromHome`] | is solved from home | a record with gaps and bad samples |
//! | [`SolveJumpsFromHome`] | is solved from home after a [`ForwardError::Jump`], otherwise an error | a record on another branch than home's |
//!
//! The policy is a type, so that a program has only those ways linked that it can go.

use nalgebra::RealField;

use super::forward::{ForwardError, Solution, Solver};
use super::pose::Pose;

/// What a solver answers.
type Found<T> = Result<Solution<T>, ForwardError<T>>;

/// What a tracker does with a sample that has no pose near the last one.
pub trait FailurePolicy {
    /// The pose of a sample with `lengths`, m, after the pose `last`.
    ///
    /// # Errors
    /// Any [`ForwardError`].
    fn track<T: RealField + Copy>(
        &mut self,
        solver: &Solver<T>,
        lengths: &[T; 6],
        last: &Pose<T>,
    ) -> Found<T>;
}

/// Reports every error.
#[derive(Clone, Copy, Debug)]
pub struct ReportFailure;

/// Solves the sample from home, whatever the error.
#[derive(Clone, Copy, Debug)]
pub struct SolveFromHome;

/// Solves a sample from home that is a jump away, and reports every other error.
#[derive(Clone, Copy, Debug, Default)]
pub struct SolveJumpsFromHome {
    /// Jumps so far.
    pub jumps: usize,
}

impl FailurePolicy for ReportFailure {
    #[inline(always)]
    fn track<T: RealField + Copy>(
        &mut self,
        solver: &Solver<T>,
        lengths: &[T; 6],
        last: &Pose<T>,
    ) -> Found<T> {
        solver.track(lengths, last)
    }
}

impl FailurePolicy for SolveFromHome {
    #[inline(always)]
    fn track<T: RealField + Copy>(
        &mut self,
        solver: &Solver<T>,
        lengths: &[T; 6],
        last: &Pose<T>,
    ) -> Found<T> {
        let found = solver.track(lengths, last);
        found.or_else(|_| solver.solve(lengths))
    }
}

impl FailurePolicy for SolveJumpsFromHome {
    #[inline(always)]
    fn track<T: RealField + Copy>(
        &mut self,
        solver: &Solver<T>,
        lengths: &[T; 6],
        last: &Pose<T>,
    ) -> Found<T> {
        match solver.track(lengths, last) {
            Err(ForwardError::Jump { .. }) => {
                self.jumps += 1;
                solver.solve(lengths)
            }
            found => found,
        }
    }
}

/// Solves the samples of a moving base one after another.
#[derive(Clone, Debug)]
pub struct PoseTracker<T: RealField + Copy, P> {
    solver: Solver<T>,
    last: Option<Pose<T>>,
    policy: P,
}

impl<T: RealField + Copy, P: FailurePolicy> PoseTracker<T, P> {
    /// A tracker that has seen no sample yet.
    #[must_use]
    pub fn new(solver: Solver<T>, policy: P) -> Self {
        Self {
            solver,
            last: None,
            policy,
        }
    }

    /// The solver of this base.
    pub fn solver(&self) -> &Solver<T> {
        &self.solver
    }

    /// The policy, with what it counts.
    pub fn policy(&self) -> &P {
        &self.policy
    }

    /// The pose with hinge-to-hinge `lengths`, m, of the next sample.
    ///
    /// # Errors
    /// Any [`ForwardError`]; the next sample is then solved from home.
    #[inline]
    pub fn next(&mut self, lengths: &[T; 6]) -> Found<T> {
        let solution = match self.last.take() {
            Some(last) => self.policy.track(&self.solver, lengths, &last),
            None => self.solver.solve(lengths),
        }?;
        self.last = Some(solution.pose);
        Ok(solution)
    }

    /// As [`PoseTracker::next`], but from `guess` and on whatever branch.
    ///
    /// # Errors
    /// Those of [`Solver::solve_near`].
    pub fn next_near(
        &mut self,
        lengths: &[T; 6],
        guess: &Pose<T>,
    ) -> Result<Solution<T>, ForwardError<T>> {
        self.last = None;
        let solution = self.solver.solve_near(lengths, guess)?;
        self.last = Some(solution.pose);
        Ok(solution)
    }

    /// Forgets the last pose: the next sample is solved from home. Due after a pause, in which the base may have moved.
    pub fn restart(&mut self) {
        self.last = None;
    }
}
