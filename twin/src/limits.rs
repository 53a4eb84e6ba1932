//! The limits of the jacks, which a controller checks before it moves anything.

use thiserror::Error;

use crate::geometry::Geometry;
use crate::program::Program;

/// Factor by which a value may exceed its limit: the rounding of the rows of a file.
const ROUNDING: f64 = 1.001;
/// Time over which the acceleration of a program is taken, s; over single rows the rounding of the file would dominate.
const ACCELERATION_WINDOW_S: f64 = 0.01;

/// Limits of each jack.
#[derive(Debug, Clone)]
pub struct Limits {
    half_stroke_m: f64,
    speed_m_s: f64,
    acceleration_m_s2: f64,
}

/// A row of a program that no jack may follow.
#[derive(Debug, Error, PartialEq)]
#[error("jack {jack} at {time_s:.3} s: {quantity} {value:.4} {unit}, limit ±{limit:.4} {unit}")]
pub struct BeyondLimit {
    /// The jack, 1 to 6.
    pub jack: usize,
    /// Time of the program, s.
    pub time_s: f64,
    /// `displacement`, `speed` or `acceleration`.
    pub quantity: &'static str,
    /// Its value, unit.
    pub value: f64,
    /// Its limit to either side, unit.
    pub limit: f64,
    /// m, m/s or m/s².
    pub unit: &'static str,
}

impl Limits {
    /// The limits of a base; a quantity without a limit in its file has none.
    #[must_use]
    pub fn of(geometry: &Geometry) -> Self {
        Self {
            half_stroke_m: 0.5 * geometry.stroke_m(),
            speed_m_s: geometry.speed_max_m_s.unwrap_or(f64::INFINITY),
            acceleration_m_s2: geometry.acceleration_max_m_s2.unwrap_or(f64::INFINITY),
        }
    }

    /// Checks every row of a program: displacement, speed to the next row, acceleration over 10 ms.
    ///
    /// # Errors
    /// [`BeyondLimit`] for the first row that no jack may follow.
    pub fn check(&self, program: &Program) -> Result<(), BeyondLimit> {
        (0..program.rows().len())
            .try_for_each(|row| (0..6).try_for_each(|jack| self.check_row(program, row, jack)))
    }

    fn check_row(&self, program: &Program, row: usize, jack: usize) -> Result<(), BeyondLimit> {
        let period_s = program.period_s();
        let window = ((ACCELERATION_WINDOW_S / period_s).round() as usize).max(1);
        let span_s = window as f64 * period_s;
        let at = |row: usize| program.rows().get(row).map(|values| values[jack]);
        let displacement = program.rows()[row][jack];
        let speed = at(row + 1).map(|next| (next - displacement) / period_s);
        let acceleration = at(row + window)
            .zip(at(row + 2 * window))
            .map(|(middle, last)| (last - 2.0 * middle + displacement) / (span_s * span_s));
        for (quantity, unit, value, limit) in [
            ("displacement", "m", Some(displacement), self.half_stroke_m),
            ("speed", "m/s", speed, self.speed_m_s),
            ("acceleration", "m/s²", acceleration, self.acceleration_m_s2),
        ] {
            if let Some(value) = value.filter(|value| value.abs() > limit * ROUNDING) {
                return Err(BeyondLimit {
                    jack: jack + 1,
                    time_s: row as f64 * period_s,
                    quantity,
                    value,
                    limit,
                    unit,
                });
            }
        }
        Ok(())
    }
}
