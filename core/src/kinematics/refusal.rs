//! What forward kinematics refuses: lengths before a search, poses after it, and searches that end without a pose.

use nalgebra::{RealField, convert};

use super::{
    forward::Solver,
    inverse::inverse,
    outcome::{ForwardError, Solution},
    path::{End, Stuck},
    pose::Pose,
    six::Six,
};

impl<T: RealField + Copy> Solver<T> {
    /// Refuses lengths that are not numbers or lie outside the stroke.
    #[inline(always)]
    pub(super) fn check(&self, lengths: &[T; 6]) -> Result<(), ForwardError<T>> {
        let least = self.geometry.length_min_m() - self.options.stroke_margin_m;
        let greatest = self.geometry.length_max_m() + self.options.stroke_margin_m;
        let inside = lengths
            .iter()
            .fold(true, |inside, &l| inside & (l >= least) & (l <= greatest));
        if inside {
            Ok(())
        } else {
            Err(self.refuse(lengths))
        }
    }

    #[cold]
    fn refuse(&self, lengths: &[T; 6]) -> ForwardError<T> {
        let from_mid = |k: usize| (lengths[k] - self.geometry.mid_length_m()).abs();
        let mut farthest = 0;
        for (k, &length_m) in lengths.iter().enumerate() {
            if !length_m.is_finite() {
                return ForwardError::NotFinite {
                    jack: k as u8 + 1,
                    length_m,
                };
            }
            if from_mid(k) > from_mid(farthest) {
                farthest = k;
            }
        }
        ForwardError::OutsideStroke {
            jack: farthest as u8 + 1,
            length_m: lengths[farthest],
            length_min_m: self.geometry.length_min_m(),
            length_max_m: self.geometry.length_max_m(),
        }
    }

    /// Whether O or the body has gone farther than it may from one tracked pose to the next.
    #[inline(always)]
    pub(super) fn jumped(&self, pose: &Pose<T>, last: &Pose<T>) -> bool {
        let moved = (pose.position - last.position).norm_squared();
        let turn = last.rotation.conjugate().into_inner() * pose.rotation.into_inner();
        // The vector part of a unit quaternion is the sine of half the angle, here less than half the angle.
        let half_jump_rad = self.options.jump_rad * convert(0.5);
        (moved > self.options.jump_m * self.options.jump_m)
            | (turn.imag().norm_squared() > half_jump_rad * half_jump_rad)
    }

    /// The error that [`Solver::jumped`] stands for.
    #[cold]
    pub(super) fn jump(&self, pose: &Pose<T>, last: &Pose<T>) -> ForwardError<T> {
        let (distance_m, angle_rad) = pose.distance(last);
        let (limit_m, limit_rad) = (self.options.jump_m, self.options.jump_rad);
        ForwardError::Jump {
            distance_m,
            angle_rad,
            limit_m,
            limit_rad,
        }
    }

    /// The solution if its condition number, not just the bound, is under the limit.
    #[cold]
    #[inline(never)]
    pub(super) fn weigh(&self, solution: Solution<T>) -> Result<Solution<T>, ForwardError<T>> {
        let (condition, limit) = (self.condition(&solution.pose), self.options.max_condition);
        if condition <= limit {
            Ok(solution)
        } else {
            Err(ForwardError::Singular { condition, limit })
        }
    }

    /// Why a way led to no pose.
    pub(super) fn explain(&self, stuck: &Stuck<T>, lengths: &[T; 6]) -> ForwardError<T> {
        let pose = self.home.pose(&stuck.excursion);
        let there = inverse(&self.geometry, &pose);
        let short_m = (Six(*lengths) - Six(there)).largest();
        let (condition, limit) = (self.condition(&pose), self.options.max_condition);
        let iterations = self.options.max_iterations;
        match stuck.end {
            End::Exhausted => ForwardError::NoConvergence {
                iterations,
                short_m,
            },
            End::AtStart if condition > limit => ForwardError::Singular { condition, limit },
            End::AtStart | End::OnTheWay => ForwardError::Unreachable { short_m },
        }
    }
}
