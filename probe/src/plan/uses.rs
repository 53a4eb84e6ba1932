//! How much of stroke, speed and acceleration a movement uses.
//!
//! Lengths come from inverse kinematics at every row, speed and acceleration from differences of neighbouring rows,
//!
//! ```text
//! v_i = (l_{i+1} − l_{i−1}) / 2h        a_i = (l_{i+1} − 2 l_i + l_{i−1}) / h²
//! ```
//!
//! *Use* is a fraction of what there is: of the way from home to the end of the stroke, of the highest speed, of the
//! highest acceleration. A use of 1 is the limit itself.

use std::fmt;

use hexsense_core::kinematics::inverse;

use super::Run;
use crate::geometry_file::GeometryFile;

/// Jacks of a base.
pub const JACKS: usize = 6;

/// What is limited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Hinge-to-hinge length, m.
    Length,
    /// Speed of a jack, m/s.
    Speed,
    /// Acceleration of a jack, m/s².
    Acceleration,
}

impl Quantity {
    /// All, in the order of [`JackRow::values`].
    pub const ALL: [Self; 3] = [Self::Length, Self::Speed, Self::Acceleration];

    /// Unit of values and limits.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Length => "m",
            Self::Speed => "m/s",
            Self::Acceleration => "m/s²",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Length => "length",
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
        })
    }
}

/// The place where a movement comes closest to a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Use {
    /// The jack, 1 to 6.
    pub jack: usize,
    /// Time from the start of the program, s.
    pub time_s: f64,
    /// Length, speed or acceleration there: m, m/s, m/s².
    pub value: f64,
    /// The limit that it comes closest to; infinite where the geometry file names none.
    pub limit: f64,
    /// Fraction of the room that is used; 1 at the limit.
    pub fraction: f64,
}

impl Use {
    const NONE: Self = Self {
        jack: 1,
        time_s: 0.0,
        value: 0.0,
        limit: f64::INFINITY,
        fraction: 0.0,
    };

    fn or_worse(&mut self, other: Self) {
        if other.fraction > self.fraction
            || (other.limit.is_infinite() && other.value.abs() > self.value.abs())
        {
            *self = other;
        }
    }
}

/// How close a movement comes to the limits of the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uses {
    /// Of the way from home to the nearer end of the stroke.
    pub length: Use,
    /// Of the highest speed.
    pub speed: Use,
    /// Of the highest acceleration.
    pub acceleration: Use,
}

impl Uses {
    /// Each quantity with its use.
    #[must_use]
    pub fn all(&self) -> [(Quantity, Use); 3] {
        [
            (Quantity::Length, self.length),
            (Quantity::Speed, self.speed),
            (Quantity::Acceleration, self.acceleration),
        ]
    }

    /// The largest fraction of any limit.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.all()
            .iter()
            .fold(0.0, |worst, (_, used)| worst.max(used.fraction))
    }
}

/// All jacks at one time.
#[derive(Debug, Clone, Copy)]
pub struct JackRow {
    /// Time from the start of the program, s.
    pub time_s: f64,
    /// Lengths (m), speeds (m/s) and accelerations (m/s²) of the jacks.
    pub values: [[f64; JACKS]; 3],
}

/// All rows of a run, `step_s` apart, from the start of the program to its end.
pub fn rows<'a>(
    run: &Run,
    geometry: &'a GeometryFile,
    step_s: f64,
) -> impl Iterator<Item = JackRow> + use<'a> {
    let program = run.program();
    let last = (program.duration_s() / step_s).ceil() as usize;
    let base = &geometry.geometry;
    let lengths = move |row: usize| inverse(base, &program.pose(base, row as f64 * step_s));
    let mut now = lengths(0);
    let mut before = now;
    (0..=last).map(move |row| {
        let after = if row < last { lengths(row + 1) } else { now };
        let speeds = core::array::from_fn(|jack| (after[jack] - before[jack]) / (2.0 * step_s));
        let accelerations = core::array::from_fn(|jack| {
            (after[jack] - 2.0 * now[jack] + before[jack]) / (step_s * step_s)
        });
        let values = [now, speeds, accelerations];
        (before, now) = (now, after);
        JackRow {
            time_s: row as f64 * step_s,
            values,
        }
    })
}

/// What the jacks of a base have room for.
#[derive(Debug, Clone, Copy)]
pub struct Room {
    home: [f64; JACKS],
    shortest: f64,
    longest: f64,
    speed_max: f64,
    acceleration_max: f64,
}

impl Room {
    /// The room of a base.
    #[must_use]
    pub fn of(geometry: &GeometryFile) -> Self {
        let base = &geometry.geometry;
        Self {
            home: inverse(base, &base.home()),
            shortest: base.length_min_m(),
            longest: base.length_max_m(),
            speed_max: geometry.speed_max_m_s.unwrap_or(f64::INFINITY),
            acceleration_max: geometry.acceleration_max_m_s2.unwrap_or(f64::INFINITY),
        }
    }

    /// Limit of a quantity; of a length the end of the stroke on the side of home where `value` is.
    #[must_use]
    pub fn limit(&self, quantity: Quantity, jack: usize, value: f64) -> f64 {
        match quantity {
            Quantity::Length if value < self.home[jack] => self.shortest,
            Quantity::Length => self.longest,
            Quantity::Speed => self.speed_max,
            Quantity::Acceleration => self.acceleration_max,
        }
    }

    /// Use of a value with its sign: negative for jacks that are shorter than at home, that shorten, or that
    /// accelerate so; 0 where there is no limit.
    #[must_use]
    pub fn fraction(&self, quantity: Quantity, jack: usize, value: f64) -> f64 {
        let limit = self.limit(quantity, jack, value);
        match quantity {
            Quantity::Length if value == self.home[jack] => 0.0,
            Quantity::Length => (value - self.home[jack]) / (limit - self.home[jack]).abs(),
            Quantity::Speed | Quantity::Acceleration => value / limit,
        }
    }
}

/// What one run uses, sampled every `step_s`.
#[must_use]
pub fn uses(run: &Run, geometry: &GeometryFile, step_s: f64) -> Uses {
    let room = Room::of(geometry);
    let mut uses = [Use::NONE; 3];
    for row in rows(run, geometry, step_s) {
        for (quantity, used) in Quantity::ALL.into_iter().zip(&mut uses) {
            for (jack, value) in row.values[quantity as usize].into_iter().enumerate() {
                used.or_worse(Use {
                    jack: jack + 1,
                    time_s: row.time_s,
                    value,
                    limit: room.limit(quantity, jack, value),
                    fraction: room.fraction(quantity, jack, value).abs(),
                });
            }
        }
    }
    let [length, speed, acceleration] = uses;
    Uses {
        length,
        speed,
        acceleration,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::campaign;

    #[test]
    fn speed_and_acceleration_of_a_heave_are_those_of_the_jacks() {
        // At home the jacks' share of a small heave is h/l, the cosine of their slope.
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let plan = campaign::plan(&geometry).unwrap();
        let mut run = plan.run("heave").unwrap().clone();
        run.sine[0].amplitude_m = Some(0.001);
        run.sine[0].fade_s = 60.0;
        let home = geometry.geometry.home();
        let slope = home.position.y / inverse(&geometry.geometry, &home)[0];
        let omega = std::f64::consts::TAU * 0.5;
        let uses = uses(&run, &geometry, 0.002);
        let is = |value: f64, expected: f64| (value.abs() / expected - 1.0).abs() < 1e-3;
        assert!(is(uses.speed.value, 0.001 * omega * slope));
        assert!(is(uses.acceleration.value, 0.001 * omega * omega * slope));
    }
}
