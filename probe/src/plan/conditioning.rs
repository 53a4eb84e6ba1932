//! How well the jacks hold the platform along a movement.
//!
//! Where the Jacobian J loses rank, the jacks no longer hold the platform, and near such a pose small errors of length
//! are large errors of pose. The condition number says how near such a pose is. Metres are counted in radii, so that it
//! has no unit: with r the mean distance of the upper hinges from O,
//!
//! ```text
//! row k of J = [e_k, (c_k × e_k)/r]        cond(J) = σ₁/σ₆
//! ```
//!
//! The rows' first halves are unit vectors, so that σ₁ ≥ 1 and an error δl of the six lengths moves the platform by at
//! most cond(J)·|δl| (radians times r).
//!
//! Between samples no singular value moves by more than ‖ΔJ‖ (Weyl). Let s be how far an upper hinge moves from one
//! sample to the next, rotation and position counted on their own. A point between them is nearer to one of the two,
//! which leaves a factor of two for a path that is not straight. With l the shortest jack and ρ the largest |b_k|
//!
//! ```text
//! |Δe| ≤ s/l    |Δ(c × e)|/r ≤ s/r + (ρ/r)·s/l    ‖ΔJ‖ ≤ Δ = √6·√(|Δe|² + |Δ(c × e)|²/r²)
//! cond(J) ≤ (σ₁ + Δ)/(σ₆ − Δ)
//! ```

use hexsense_core::kinematics::{Geometry, Pose, inverse, jacobian};

use nalgebra::SVD;

use super::Run;

/// Largest condition number of a movement: ten times what a usual base has at home. Jacks that are 0.5 mm off may
/// then move the platform by 0.5 mm·√6·25 = 31 mm, which is no reference for any sensor.
pub const MAX_CONDITION: f64 = 25.0;
/// Time between the examined poses, s, and way of a hinge after which the Jacobian is decomposed again, m.
const STEP_S: f64 = 0.01;
const STEP_M: f64 = 0.005;

/// A condition number that is far better, of the one that it would replace.
const FAR_BETTER: f64 = 0.6;

/// A 6×6 decomposition takes about ten; the limit only makes sure that it ends.
const SVD_ITERATIONS: usize = 1000;

/// The worst place of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditioning {
    /// Time of the sample, s from the start of the program.
    pub time_s: f64,
    /// Condition number there, without unit.
    pub condition: f64,
    /// What it stays below around that sample and everywhere else.
    pub bound: f64,
}

/// The worst condition number of a run.
#[must_use]
pub fn conditioning(run: &Run, geometry: &Geometry<f64>) -> Conditioning {
    let program = run.program();
    let last = (program.duration_s() / STEP_S).ceil() as usize;
    let scale = Scale::of(geometry);
    let mut worst = Conditioning {
        time_s: 0.0,
        condition: 0.0,
        bound: 0.0,
    };
    let mut before: Option<Pose<f64>> = None;
    let mut furthest_m = 0.0_f64;
    for row in 0..=last {
        let time_s = row as f64 * STEP_S;
        let pose = program.pose(geometry, time_s);
        let moved_m = before.map_or(0.0, |before| scale.moved_m(geometry, &before, &pose));
        furthest_m = furthest_m.max(moved_m);
        if before.is_some() && moved_m < STEP_M && row < last {
            continue;
        }
        let (largest, least) = scale.singular_values(geometry, &pose);
        let change = scale.change(geometry, &pose, furthest_m);
        let bound = if least > change {
            (largest + change) / (least - change)
        } else {
            f64::INFINITY
        };
        if bound > worst.bound {
            let condition = largest / least;
            worst = Conditioning {
                time_s,
                condition,
                bound,
            };
        }
        (before, furthest_m) = (Some(pose), 0.0);
    }
    worst
}

/// The condition number at a pose; infinite where the jacks do not hold the platform.
#[must_use]
pub fn condition_at(geometry: &Geometry<f64>, pose: &Pose<f64>) -> f64 {
    let (largest, least) = Scale::of(geometry).singular_values(geometry, pose);
    largest / least
}

/// A list of upper hinges that begins at another hinge, by which the jacks would hold the platform far better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BetterOrder {
    /// Which hinge of the file would be the first, 2 to 6.
    pub first: usize,
    /// Condition number at home with it.
    pub condition: f64,
    /// Condition number at home as the file is.
    pub now: f64,
}

/// Whether the upper hinges of a base seem to be listed from another jack on than the lower ones.
#[must_use]
pub fn better_order(geometry: &Geometry<f64>) -> Option<BetterOrder> {
    let now = condition_at(geometry, &geometry.home());
    let shifted = (1..6).filter_map(|places| {
        let mut upper = *geometry.upper();
        upper.rotate_left(places);
        let shifted = Geometry::new(
            *geometry.lower(),
            upper,
            geometry.length_min_m(),
            geometry.length_max_m(),
            Some(geometry.home_height_m()),
        );
        let shifted = shifted.ok()?;
        Some(BetterOrder {
            first: places + 1,
            condition: condition_at(&shifted, &shifted.home()),
            now,
        })
    });
    shifted
        .filter(|order| order.condition < FAR_BETTER * now)
        .min_by(|a, b| a.condition.total_cmp(&b.condition))
}

/// Sizes of the upper hinges, m.
struct Scale {
    mean_m: f64,
    largest_m: f64,
}

impl Scale {
    fn of(geometry: &Geometry<f64>) -> Self {
        let radii = geometry.upper().each_ref().map(|hinge| hinge.norm());
        Self {
            mean_m: radii.iter().sum::<f64>() / radii.len() as f64,
            largest_m: radii.iter().copied().fold(0.0, f64::max),
        }
    }

    /// How far the hinges move at most, rotation and position on their own, m.
    fn moved_m(&self, geometry: &Geometry<f64>, from: &Pose<f64>, to: &Pose<f64>) -> f64 {
        let turned = geometry
            .upper()
            .iter()
            .map(|hinge| (to.rotation * hinge - from.rotation * hinge).norm());
        turned.fold(0.0, f64::max) + (to.position - from.position).norm()
    }

    /// Largest and least singular value of the Jacobian; ∞ and 0 where it has none.
    fn singular_values(&self, geometry: &Geometry<f64>, pose: &Pose<f64>) -> (f64, f64) {
        let mut matrix = jacobian(geometry, pose);
        matrix
            .columns_mut(3, 3)
            .iter_mut()
            .for_each(|element| *element /= self.mean_m);
        // A jack without length has no direction.
        let finite = matrix.iter().all(|element| element.is_finite());
        let accuracy = 5.0 * f64::EPSILON;
        let decomposed = finite
            .then(|| SVD::try_new(matrix, false, false, accuracy, SVD_ITERATIONS))
            .flatten();
        decomposed.map_or((f64::INFINITY, 0.0), |svd| {
            (svd.singular_values.max(), svd.singular_values.min())
        })
    }

    /// Δ of the module's head.
    fn change(&self, geometry: &Geometry<f64>, pose: &Pose<f64>, moved_m: f64) -> f64 {
        let lengths = inverse(geometry, pose);
        let shortest_m = lengths.into_iter().fold(f64::INFINITY, f64::min) - moved_m;
        let direction = moved_m / shortest_m.max(f64::MIN_POSITIVE);
        let moment = (moved_m + self.largest_m * direction) / self.mean_m;
        6f64.sqrt() * direction.hypot(moment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry_file::GeometryFile;
    use crate::plan::campaign;

    #[test]
    fn a_base_twice_as_large_has_the_same_condition_number() {
        let (_, text) = geometries::PRESETS[2];
        let file = GeometryFile::parse("an.toml", text).unwrap();
        let run = campaign::plan(&file).unwrap().runs[0].clone();
        let geometry = &file.geometry;
        let double = |hinges: &[nalgebra::Vector3<f64>; 6]| hinges.map(|hinge| hinge * 2.0);
        let large = Geometry::new(
            double(geometry.lower()),
            double(geometry.upper()),
            2.0 * geometry.length_min_m(),
            2.0 * geometry.length_max_m(),
            Some(2.0 * geometry.home_height_m()),
        );
        let (one, two) = (
            conditioning(&run, geometry),
            conditioning(&run, &large.unwrap()),
        );
        assert!((one.condition / two.condition - 1.0).abs() < 1e-9);
        assert!(one.condition > 1.0 && one.bound == one.condition);
    }

    #[test]
    fn no_condition_number_between_samples_is_above_the_bound() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let run = campaign::plan(&geometry).unwrap();
        let run = run.run("held-out").unwrap();
        let geometry = &geometry.geometry;
        let worst = conditioning(run, geometry);
        let (scale, program) = (Scale::of(geometry), run.program());
        let fine = (0..(program.duration_s() * 1e3) as usize).map(|row| {
            let (largest, least) =
                scale.singular_values(geometry, &program.pose(geometry, row as f64 * 1e-3));
            largest / least
        });
        let highest = fine.fold(0.0, f64::max);
        assert!(worst.condition <= highest && highest <= worst.bound);
        assert!(worst.bound < 1.2 * highest, "{worst:?} {highest}");
    }
}
