//! How far the jacks swing in their hinges along a movement.
//!
//! A universal or ball joint turns only so far about its axis. The axis is taken to be where the jack points at home,
//! as joints are mounted: that of a lower hinge is fixed to the earth, that of an upper hinge to the platform. With the
//! jack's direction e_k = d_k/|d_k| and e°_k that at home
//!
//! ```text
//! lower: cos β = e_k·e°_k          upper: cos β = (Aᵀ·e_k)·e°_k
//! ```
//!
//! Between two samples an angle changes by no more than its direction turns. A point between them is nearer to one of the
//! two, which leaves a factor of two for a path that is not straight: the largest turn from one sample to the next is
//! added before an angle is compared with its limit.

use std::fmt;

use hexsense_core::kinematics::Geometry;
use hexsense_core::kinematics::inverse::jacks;
use nalgebra::Vector3;

use super::Run;
use super::uses::JACKS;
use crate::geometry_file::GeometryFile;

/// The two ends of a jack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joint {
    /// Fixed to the earth.
    Lower,
    /// Fixed to the platform.
    Upper,
}

impl Joint {
    /// Both, in the order of [`Swings::angles_rad`].
    pub const ALL: [Self; 2] = [Self::Lower, Self::Upper];

    /// Largest angle that the geometry file allows, degrees; `None` without a limit.
    #[must_use]
    pub fn limit_deg(self, geometry: &GeometryFile) -> Option<f64> {
        match self {
            Self::Lower => geometry.lower_hinge_angle_max_deg,
            Self::Upper => geometry.upper_hinge_angle_max_deg,
        }
    }
}

impl fmt::Display for Joint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Lower => "lower hinge",
            Self::Upper => "upper hinge",
        })
    }
}

/// The hinge of a run that comes closest to its limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HingeUse {
    /// Which end of the jack.
    pub joint: Joint,
    /// The jack, 1 to 6.
    pub jack: usize,
    /// Time of the sample, s from the start of the program.
    pub time_s: f64,
    /// Angle from the hinge's axis that is not exceeded around that sample, degrees.
    pub angle_deg: f64,
    /// The limit, degrees.
    pub limit_deg: f64,
}

impl HingeUse {
    /// Fraction of the limit; 1 at the limit.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        self.angle_deg / self.limit_deg
    }
}

/// Angles of all hinges at one time.
#[derive(Debug, Clone, Copy)]
pub struct Swings {
    /// Time from the start of the program, s.
    pub time_s: f64,
    /// Angles from the axes, rad: of the lower hinges, then of the upper ones.
    pub angles_rad: [[f64; JACKS]; 2],
    /// How far the directions have turned since the sample before, rad.
    pub turned_rad: [[f64; JACKS]; 2],
}

/// Directions of the jacks as their lower and their upper hinges see them.
type Directions = [[Vector3<f64>; JACKS]; 2];

/// Angles of all hinges along a run, `step_s` apart, from the start of the program to its end.
pub fn swings<'a>(
    run: &Run,
    geometry: &'a Geometry<f64>,
    step_s: f64,
) -> impl Iterator<Item = Swings> + use<'a> {
    let program = run.program();
    let last = (program.duration_s() / step_s).ceil() as usize;
    let directions = move |time_s: f64| -> Directions {
        let pose = program.pose(geometry, time_s);
        let earth = jacks(geometry, &pose);
        [earth, earth.map(|d| pose.rotation.inverse() * d)]
    };
    let axes: Directions = [jacks(geometry, &geometry.home()); 2];
    let mut before = directions(0.0);
    (0..=last).map(move |row| {
        let time_s = row as f64 * step_s;
        let now = directions(time_s);
        let swings = Swings {
            time_s,
            angles_rad: between(&now, &axes),
            turned_rad: between(&now, &before),
        };
        before = now;
        swings
    })
}

fn between(one: &Directions, other: &Directions) -> [[f64; JACKS]; 2] {
    // Near zero the arc cosine would lose half of the digits.
    let angle = |a: &Vector3<f64>, b: &Vector3<f64>| a.cross(b).norm().atan2(a.dot(b));
    [0, 1].map(|joint| std::array::from_fn(|jack| angle(&one[joint][jack], &other[joint][jack])))
}

/// The hinge of a run, sampled every `step_s`, that comes closest to its limit; `None` where the geometry file has no
/// limit of hinges.
#[must_use]
pub fn closest(run: &Run, geometry: &GeometryFile, step_s: f64) -> Option<HingeUse> {
    let uses = Joint::ALL.map(|joint| widest(joint, run, geometry, step_s));
    uses.into_iter()
        .flatten()
        .max_by(|a, b| a.fraction().total_cmp(&b.fraction()))
}

/// The hinge of one kind that comes closest to the limit of its kind.
fn widest(joint: Joint, run: &Run, geometry: &GeometryFile, step_s: f64) -> Option<HingeUse> {
    let limit_deg = joint.limit_deg(geometry)?;
    let mut widest = HingeUse {
        joint,
        jack: 1,
        time_s: 0.0,
        angle_deg: 0.0,
        limit_deg,
    };
    let mut largest_turn_rad = 0.0_f64;
    for swings in swings(run, &geometry.geometry, step_s) {
        for jack in 0..JACKS {
            let angle_deg = swings.angles_rad[joint as usize][jack].to_degrees();
            largest_turn_rad = largest_turn_rad.max(swings.turned_rad[joint as usize][jack]);
            if angle_deg > widest.angle_deg {
                widest = HingeUse {
                    jack: jack + 1,
                    time_s: swings.time_s,
                    angle_deg,
                    ..widest
                };
            }
        }
    }
    widest.angle_deg += largest_turn_rad.to_degrees();
    Some(widest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::campaign;

    #[test]
    fn a_heave_swings_both_hinges_of_a_jack_by_the_change_of_its_slope() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let plan = campaign::plan(&geometry).unwrap();
        let mut run = plan.run("heave").unwrap().clone();
        run.sine[0].amplitude_m = Some(0.25);
        let base = &geometry.geometry;
        let home = jacks(base, &base.home())[0];
        let slope = |height: f64| (home.y + height).atan2(home.x.hypot(home.z));
        let expected = (slope(0.25) - slope(0.0)).max(slope(0.0) - slope(-0.25));
        let mut largest = [0.0_f64; 2];
        for swings in swings(&run, base, 0.002) {
            for (largest, angles) in largest.iter_mut().zip(swings.angles_rad) {
                *largest = angles.into_iter().fold(*largest, f64::max);
            }
        }
        for largest in largest {
            assert!((largest - expected).abs() < 1e-6, "{largest} {expected}");
        }
    }

    /// Where all jacks are parallel to their lower hinges' axes only the platform's turn is left for the upper ones.
    #[test]
    fn the_upper_hinges_feel_the_turn_of_the_platform() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let plan = campaign::plan(&geometry).unwrap();
        let base = &geometry.geometry;
        for swings in swings(plan.run("pitch").unwrap(), base, 0.05) {
            let turn = plan
                .run("pitch")
                .unwrap()
                .program()
                .displacement(swings.time_s)[5]
                .abs();
            for (lower, upper) in swings.angles_rad[0].into_iter().zip(swings.angles_rad[1]) {
                // Triangle inequality on the sphere of directions.
                assert!((upper - lower).abs() <= turn + 1e-12 && upper <= lower + turn + 1e-12);
            }
            let widest = swings.angles_rad[1].into_iter().fold(0.0, f64::max);
            assert!(turn < 0.1 || widest > 0.5 * turn, "{widest} {turn}");
        }
    }

    #[test]
    fn no_angle_between_samples_is_above_the_one_that_is_compared() {
        let mut geometry = GeometryFile::load("an-74tk-200").unwrap();
        geometry.lower_hinge_angle_max_deg = Some(45.0);
        geometry.upper_hinge_angle_max_deg = Some(45.0);
        let plan = campaign::plan(&geometry).unwrap();
        let run = plan.run("held-out").unwrap();
        let coarse = closest(run, &geometry, 0.05).unwrap();
        let fine = swings(run, &geometry.geometry, 1e-3)
            .flat_map(|swings| swings.angles_rad)
            .flatten()
            .fold(0.0, f64::max)
            .to_degrees();
        assert!(
            fine <= coarse.angle_deg && coarse.angle_deg < 1.3 * fine,
            "{coarse:?} {fine}"
        );
    }
}
