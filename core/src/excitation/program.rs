//! A program: the degrees of freedom that move, and their signals.

use heapless::Vec;
use nalgebra::Vector3;

use super::{Multisine, Ramps, Sine};
use crate::kinematics::{Angles, Convention, Geometry, Pose, displacements};

/// Degrees of freedom, in the order of displacements: X, Y, Z, γ, ψ, ϑ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DegreeOfFreedom {
    /// Along X, forward, m.
    Surge,
    /// Along Y, up, m.
    Heave,
    /// Along Z, right, m.
    Sway,
    /// γ about X, rad.
    Roll,
    /// ψ about Y, rad.
    Yaw,
    /// ϑ about Z, rad.
    Pitch,
}

impl DegreeOfFreedom {
    /// All, in order.
    pub const ALL: [Self; 6] = [
        Self::Surge,
        Self::Heave,
        Self::Sway,
        Self::Roll,
        Self::Yaw,
        Self::Pitch,
    ];

    /// Name as people write it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Surge => "surge",
            Self::Heave => "heave",
            Self::Sway => "sway",
            Self::Roll => "roll",
            Self::Yaw => "yaw",
            Self::Pitch => "pitch",
        }
    }

    /// Whether it is an angle.
    #[must_use]
    pub const fn is_rotation(self) -> bool {
        matches!(self, Self::Roll | Self::Yaw | Self::Pitch)
    }
}

/// The movement of one degree of freedom.
#[derive(Debug, Clone, PartialEq)]
pub enum Signal {
    /// Ramps and holds.
    Ramps(Ramps),
    /// A sine.
    Sine(Sine),
    /// Several sines.
    Multisine(Multisine),
}

impl Signal {
    /// Displacement at `t_s` seconds, m or rad.
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        match self {
            Self::Ramps(ramps) => ramps.at(t_s),
            Self::Sine(sine) => sine.at(t_s),
            Self::Multisine(multisine) => multisine.at(t_s),
        }
    }

    /// Length, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match self {
            Self::Ramps(ramps) => ramps.duration_s(),
            Self::Sine(sine) => sine.duration_s(),
            Self::Multisine(multisine) => multisine.timing().duration_s(),
        }
    }
}

/// A movement of the base from home and back. Without signals the base stays at home.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Program {
    /// The signals; a degree of freedom with two signals moves by their sum.
    pub signals: Vec<(DegreeOfFreedom, Signal), 6>,
}

impl Program {
    /// One degree of freedom moved by one signal.
    #[must_use]
    pub fn of(freedom: DegreeOfFreedom, signal: Signal) -> Self {
        Self {
            signals: core::iter::once((freedom, signal)).collect(),
        }
    }

    /// Length of the longest signal, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.signals
            .iter()
            .map(|(_, signal)| signal.duration_s())
            .fold(0.0, f64::max)
    }

    /// Displacements from home at `t_s` seconds: m, m, m, rad, rad, rad in the order of [`DegreeOfFreedom::ALL`].
    #[must_use]
    pub fn displacement(&self, t_s: f64) -> [f64; 6] {
        let mut displacement = [0.0; 6];
        for (freedom, signal) in &self.signals {
            displacement[*freedom as usize] += signal.at(t_s);
        }
        displacement
    }

    /// Pose of the base at `t_s` seconds.
    #[must_use]
    pub fn pose(&self, geometry: &Geometry<f64>, t_s: f64) -> Pose<f64> {
        let [x, y, z, roll, yaw, pitch] = self.displacement(t_s);
        let position = geometry.home().position + Vector3::new(x, y, z);
        Convention::Gost.pose(position, Angles { roll, pitch, yaw })
    }

    /// The six jack programs: displacements from mid-stroke, m, every `period_s` seconds from the start to the first row at
    /// or behind the end.
    pub fn jack_rows(
        &self,
        geometry: &Geometry<f64>,
        period_s: f64,
    ) -> impl Iterator<Item = [f64; 6]> {
        let last = libm::ceil(self.duration_s() / period_s) as usize;
        (0..=last)
            .map(move |row| displacements(geometry, &self.pose(geometry, row as f64 * period_s)))
    }
}
