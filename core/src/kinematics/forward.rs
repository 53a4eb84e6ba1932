//! Forward kinematics: the pose from the six jack lengths, equation (3).
//!
//! F_k(q) = |p + A·b_k − a_k| − l_k = 0 has up to forty real solutions (P. Dietmaier 1998), the assembly branches; a
//! base stays on the one it was built on, because a change of branch leads through a singular pose, where its jacks
//! do not hold it. So a solution is useful only with its branch, and there are three calls:
//!
//! | call | starts from | keeps the branch | use |
//! |---|---|---|---|
//! | [`Solver::solve`] | home | yes | the first sample, samples far apart |
//! | [`Solver::track`] | the last pose | yes, and refuses a jump | sample after sample of a moving base |
//! | [`Solver::solve_near`] | a guess | no | looking for poses, other branches |
//!
//! All three try Newton's method first (`newton.rs`) on the equations in `excursion.rs`. Where it does not contract,
//! the first two follow the branch along a path in the lengths and the third descends (`path.rs`). The sign of det J
//! at the solution is compared with that at the start. A returned solution has a measured residual below the
//! tolerance; everything else is a [`ForwardError`].
//!
//! From home the solver finds every pose that a straight path (position, rotation vector) joins to home inside the
//! stroke and without a change of the sign of det J; the tests check this with ten thousand poses of each preset.

use nalgebra::{RealField, convert};
use simba::scalar::SupersetOf;

pub use super::outcome::{ForwardError, Options, Solution};

use super::{
    excursion::{Excursion, Home},
    geometry::Geometry,
    jacobian::{bound_times_determinant, condition, condition_bound, jacobian},
    newton::{Arrival, Pivoting},
    path::Stuck,
    pose::Pose,
    six::Six,
};

/// Forward kinematics of one base: everything that depends on the base alone is computed once.
#[derive(Clone, Debug)]
pub struct Solver<T: RealField + Copy> {
    pub(super) geometry: Geometry<T>,
    pub(super) options: Options<T>,
    condition: Condition<T>,
    pub(super) home: Home<T>,
    tolerance_m: T,
    /// Over |det J| it bounds the condition number, with an eighth to spare.
    condition_scale: T,
}

/// Where a search starts and what it may find.
#[derive(Clone, Copy)]
enum Start<'a, T: RealField + Copy> {
    /// Home; poses on its branch.
    Home,
    /// The last pose; poses on its branch, and not far off.
    Last(&'a Pose<T>),
    /// A guess; poses on any branch.
    Guess(&'a Pose<T>),
}

/// One search.
struct Task<'a, T> {
    lengths: &'a [T; 6],
    demand: Six<T>,
    tolerance: T,
    from: Excursion<T>,
}

/// What the limit of the condition number is compared with. Called through a pointer for the same reason as a [`Way`].
type Condition<T> = fn(&Geometry<T>, &Pose<T>) -> T;

/// A way round, of `path.rs`. Called through a pointer so that a program has only those linked that it can go.
type Way<T> = fn(&Home<T>, Excursion<T>, &Six<T>, T, &mut u32) -> Result<Arrival<T>, Stuck<T>>;

impl<T: RealField + Copy> Solver<T> {
    /// A solver for `geometry`. What it needs to know of the base is computed here, once, in the precision of
    /// `geometry`, whatever precision it solves in. Where the bound of the condition number is over the limit, the
    /// number itself decides.
    pub fn new<S: RealField + Copy>(geometry: &Geometry<S>, options: Options<T>) -> Self
    where
        T: SupersetOf<S>,
    {
        Self::with_condition(geometry, options, exact_condition)
    }

    /// As [`Solver::new`], but the bound of the condition number decides: a pose up to ten times better than the limit
    /// may be refused as singular. Spares a small processor the singular value decomposition.
    pub fn bounded<S: RealField + Copy>(geometry: &Geometry<S>, options: Options<T>) -> Self
    where
        T: SupersetOf<S>,
    {
        Self::with_condition(geometry, options, condition_bound)
    }

    fn with_condition<S: RealField + Copy>(
        geometry: &Geometry<S>,
        options: Options<T>,
        condition: Condition<T>,
    ) -> Self
    where
        T: SupersetOf<S>,
    {
        let home: Home<T> = Home::new(geometry);
        let geometry: Geometry<T> = geometry.cast();
        let last_place = T::default_epsilon() * geometry.length_max_m();
        Self {
            geometry,
            options,
            condition,
            tolerance_m: options.tolerance_m.max(last_place * convert(4.0)),
            condition_scale: bound_times_determinant(home.radius_squared) * convert(1.125),
            home,
        }
    }

    /// The base this solver is for.
    pub fn geometry(&self) -> &Geometry<T> {
        &self.geometry
    }

    /// Condition number of the Jacobian at `pose`, 1 at best, or its bound if this solver is
    /// [bounded](Solver::bounded); metres and radians are its units.
    pub fn condition(&self, pose: &Pose<T>) -> T {
        (self.condition)(&self.geometry, pose)
    }

    /// The pose on home's branch with hinge-to-hinge `lengths`, m.
    ///
    /// # Errors
    /// Any [`ForwardError`] but `StartNotFinite` and `Jump`.
    // Taken into a caller's loop, the iteration loses registers to it and a seventh of its speed.
    #[inline(never)]
    pub fn solve(&self, lengths: &[T; 6]) -> Result<Solution<T>, ForwardError<T>> {
        self.search(lengths, Start::Home)
    }

    /// The pose with hinge-to-hinge `lengths`, m, on the branch of `last` and not far from it.
    ///
    /// # Errors
    /// Any [`ForwardError`].
    #[inline(never)]
    pub fn track(&self, lengths: &[T; 6], last: &Pose<T>) -> Result<Solution<T>, ForwardError<T>> {
        self.search(lengths, Start::Last(last))
    }

    /// A pose with hinge-to-hinge `lengths`, m, near `guess`, on whatever branch.
    ///
    /// # Errors
    /// Any [`ForwardError`] but `BranchChanged` and `Jump`.
    pub fn solve_near(
        &self,
        lengths: &[T; 6],
        guess: &Pose<T>,
    ) -> Result<Solution<T>, ForwardError<T>> {
        self.search(lengths, Start::Guess(guess))
    }

    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn search(
        &self,
        lengths: &[T; 6],
        start: Start<'_, T>,
    ) -> Result<Solution<T>, ForwardError<T>> {
        self.check(lengths)?;
        let from = match start {
            Start::Home => Home::none(),
            Start::Last(pose) | Start::Guess(pose) => self.home.excursion(pose),
        };
        let shortest = lengths
            .iter()
            .fold(lengths[0], |least, &l| if l < least { l } else { least });
        let demand = self.home.demand(lengths);
        let task = Task {
            lengths,
            demand,
            tolerance: self.tolerance_m * shortest,
            from,
        };
        let mut budget = self.options.max_iterations;
        // A start counts as though a step of one radius had led to it: the next must be half of that or less.
        let (first, last_squared) = match start {
            Start::Home => {
                budget = budget.saturating_sub(1);
                self.home.predict(&demand)
            }
            Start::Last(_) | Start::Guess(_) => (from, self.home.radius_squared),
        };
        let direct = self.home.iterate(
            first,
            last_squared,
            &demand,
            task.tolerance,
            Pivoting::AsAtHome,
            &mut budget,
        );
        let direct = direct.map(|arrival| self.settled(arrival, &task));
        let way = match start {
            Start::Home | Start::Last(_) => Home::follow,
            Start::Guess(_) => Home::descend,
        };
        let arrival = match direct {
            Ok(arrival) if self.may_stay(&arrival, start) => arrival,
            other => self.detour(&task, way, other.is_ok(), &mut budget)?,
        };
        let solution = Solution {
            pose: self.home.pose(&arrival.excursion),
            iterations: self.options.max_iterations - budget,
            residual_m: arrival.residual / shortest,
            condition_bound: self.condition_bound(arrival.determinant, lengths),
        };
        if let Start::Last(last) = start
            && self.jumped(&solution.pose, last)
        {
            return Err(self.jump(&solution.pose, last));
        }
        if solution.condition_bound <= self.options.max_condition {
            Ok(solution)
        } else {
            self.weigh(solution)
        }
    }

    /// The bound of the condition number of [`super::jacobian`](mod@super::jacobian); the Newton matrix has the rows of
    /// J times the lengths.
    #[inline(always)]
    fn condition_bound(&self, determinant: T, lengths: &[T; 6]) -> T {
        let [a, b, c, d, e, f] = *lengths;
        self.condition_scale * ((a * b * c) * (d * e * f)) / determinant.abs()
    }

    /// The arrival with a determinant that is good for it. That of the last matrix is while cond(J) times the way made
    /// since, in radii, is under 0.01: J⁻¹·δJ is under 0.02 then, det J has kept its sign and lost at most the eighth
    /// that the bound of the condition number allows for.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn settled(&self, arrival: Arrival<T>, task: &Task<'_, T>) -> Arrival<T> {
        let bound = self.condition_bound(arrival.determinant, task.lengths);
        let near =
            arrival.moved_squared * bound * bound <= self.home.radius_squared * convert(1e-4);
        if near & arrival.sure {
            arrival
        } else {
            self.settled_anew(arrival, &task.from)
        }
    }

    #[cold]
    #[inline(never)]
    fn settled_anew(&self, arrival: Arrival<T>, from: &Excursion<T>) -> Arrival<T> {
        let determinant = self.home.determinant(&arrival.excursion);
        let first_determinant = if arrival.sure {
            arrival.first_determinant
        } else {
            self.home.determinant(from)
        };
        Arrival {
            first_determinant,
            determinant,
            ..arrival
        }
    }

    /// Whether the branch of the arrival is one that a search from `start` may end on.
    #[inline(always)]
    fn may_stay(&self, arrival: &Arrival<T>, start: Start<'_, T>) -> bool {
        match start {
            Start::Home => arrival.determinant * self.home.factors.determinant > T::zero(),
            Start::Last(_) => arrival.determinant * arrival.first_determinant > T::zero(),
            Start::Guess(_) => true,
        }
    }

    /// The way round for a task that Newton's method did not do, or did on `another_branch`.
    #[cold]
    #[inline(never)]
    fn detour(
        &self,
        task: &Task<'_, T>,
        way: Way<T>,
        another_branch: bool,
        budget: &mut u32,
    ) -> Result<Arrival<T>, ForwardError<T>> {
        if !self.home.pose(&task.from).is_finite() {
            return Err(ForwardError::StartNotFinite);
        }
        let arrival = way(&self.home, task.from, &task.demand, task.tolerance, budget);
        match arrival {
            Ok(arrival) => Ok(self.settled(arrival, task)),
            Err(_) if another_branch => Err(ForwardError::BranchChanged),
            Err(stuck) => Err(self.explain(&stuck, task.lengths)),
        }
    }
}

fn exact_condition<T: RealField + Copy>(geometry: &Geometry<T>, pose: &Pose<T>) -> T {
    condition(&jacobian(geometry, pose))
}
