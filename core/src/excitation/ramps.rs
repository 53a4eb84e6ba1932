//! Ramps and holds: a table of levels, one for the end of each subinterval Δt.
//!
//! ```text
//!  +U      ____                    levels  +U +U  0  0 −U −U  0  0     (the default, 8Δt)
//!   0 ____/    \____        ____
//!  −U               \____/
//! ```
//!
//! A subinterval with a new level is a ramp, one with the level before is a hold. Any other staircase is another table.
//! A linear ramp starts and stops with a jolt; a jerk-limited one follows [`smooth_step`], and its top speed is 15/8 of
//! the linear ramp's.

use heapless::Vec;

use super::smooth_step;

/// Most subintervals of a table.
pub const MAX_LEVELS: usize = 16;

/// The shape of a ramp from level to level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RampShape {
    /// At constant speed.
    Linear,
    /// With zero speed and acceleration at both ends.
    JerkLimited,
}

/// A table of ramps and holds that starts from zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Ramps {
    /// Subinterval Δt, s.
    pub step_s: f64,
    /// Level at the end of each subinterval, m or rad.
    pub levels: Vec<f64, MAX_LEVELS>,
    /// The shape of the ramps.
    pub shape: RampShape,
}

/// A stretch of time in which the program stands still at one level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold {
    /// Start, s from the start of the program.
    pub start_s: f64,
    /// Length, s.
    pub length_s: f64,
    /// Level, m or rad.
    pub level: f64,
}

impl Ramps {
    /// The default table: up to `amplitude`, hold, back to zero, hold, down to −`amplitude`, hold, back, hold.
    #[must_use]
    pub fn up_and_down(amplitude: f64, step_s: f64, shape: RampShape) -> Self {
        let levels = [
            amplitude, amplitude, 0.0, 0.0, -amplitude, -amplitude, 0.0, 0.0,
        ];
        Self {
            step_s,
            levels: levels.into_iter().collect(),
            shape,
        }
    }

    /// Length of the table, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.step_s * self.levels.len() as f64
    }

    /// Displacement at `t_s` seconds; zero before the start and the last level after the end.
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        let place = t_s.max(0.0) / self.step_s;
        let index = place as usize;
        let Some(to) = self.levels.get(index) else {
            return self.levels.last().copied().unwrap_or(0.0);
        };
        let from = self.level_before(index);
        let fraction = place - index as f64;
        from + (to - from)
            * match self.shape {
                RampShape::Linear => fraction,
                RampShape::JerkLimited => smooth_step(fraction),
            }
    }

    /// The holds of the table.
    pub fn holds(&self) -> impl Iterator<Item = Hold> + '_ {
        self.levels
            .iter()
            .enumerate()
            .filter(|(index, level)| self.level_before(*index) == **level)
            .map(|(index, level)| Hold {
                start_s: index as f64 * self.step_s,
                length_s: self.step_s,
                level: *level,
            })
    }

    fn level_before(&self, index: usize) -> f64 {
        index
            .checked_sub(1)
            .and_then(|before| self.levels.get(before))
            .copied()
            .unwrap_or(0.0)
    }
}
