//! Uncertainty budgets of everything that a campaign finds.
//!
//! The estimate is repeated under each doubt; the change of each result is that doubt's term (GUM 5.1.3, note 2).
//! What is random, the sensors' noise and wandering, comes from the fits' covariances.

use hexsense::calibration::budget::{Budget, Cause, Shape, uniform};
use hexsense::channel::Triad;
use hexsense::excitation::DegreeOfFreedom;

use super::AnalysisError;
use super::belief::{Belief, Doubt};
use super::estimate::{Condensed, Estimate};
use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// Budgets of all matrix elements and offsets, of the values at rest, and of the lever arm.
#[derive(Default)]
pub struct Budgets {
    /// Matrix elements of each triad, unit per count.
    pub matrix: [[[Budget; 3]; 3]; 3],
    /// Offsets of each triad, counts.
    pub offset: [[Budget; 3]; 3],
    /// Values at rest at home, unit.
    pub rest: [[Budget; 3]; 3],
    /// Lever arm, m.
    pub lever_arm: [Budget; 3],
}

impl Budgets {
    /// Repeats the estimate under every doubt and adds noise and bandwidth.
    ///
    /// # Errors
    /// [`AnalysisError`] when an estimate fails under a doubt.
    pub fn new(
        condensed: &Condensed,
        belief: &Belief,
        estimate: &Estimate,
        base: &GeometryFile,
        sensors: &SensorFile,
    ) -> Result<Self, AnalysisError> {
        let mut budgets = Self::default();
        for doubt in belief.doubts(base, sensors) {
            let changed = condensed.estimate(&doubt.belief)?;
            budgets.add_change(&doubt, estimate, &changed);
            budgets.add_rest_change(&doubt, condensed, belief)?;
        }
        for triad in Triad::ALL {
            budgets.add_noise(triad, condensed, estimate, belief);
            budgets.add_bandwidth(triad, condensed, estimate, sensors);
        }
        Ok(budgets)
    }

    fn add_change(&mut self, doubt: &Doubt, estimate: &Estimate, changed: &Estimate) {
        let moved = changed.lever_arm_m - estimate.lever_arm_m;
        self.lever_arm
            .iter_mut()
            .zip(moved.iter())
            .for_each(|(budget, change)| budget.add(doubt.cause, doubt.shape, *change));
        for triad in 0..3 {
            let matrix = changed.fits[triad].matrix - estimate.fits[triad].matrix;
            let offset = changed.offsets[triad] - estimate.offsets[triad];
            for axis in 0..3 {
                self.offset[triad][axis].add(doubt.cause, doubt.shape, offset[axis]);
                for column in 0..3 {
                    self.matrix[triad][axis][column].add(
                        doubt.cause,
                        doubt.shape,
                        matrix[(axis, column)],
                    );
                }
            }
        }
    }

    /// The value at rest at home is the specific force that was believed there, whatever the gain.
    fn add_rest_change(
        &mut self,
        doubt: &Doubt,
        condensed: &Condensed,
        belief: &Belief,
    ) -> Result<(), AnalysisError> {
        let change = condensed.home_force(&doubt.belief)? - condensed.home_force(belief)?;
        for axis in 0..3 {
            self.rest[Triad::LinearAcceleration.index()][axis].add(
                doubt.cause,
                doubt.shape,
                change[axis],
            );
        }
        Ok(())
    }

    fn add_noise(
        &mut self,
        triad: Triad,
        condensed: &Condensed,
        estimate: &Estimate,
        belief: &Belief,
    ) {
        let (index, fit) = (triad.index(), &estimate.fits[triad.index()]);
        let (noise, zero) = (&condensed.noise[index], &condensed.zero);
        let deviations = fit.matrix_noise();
        let gravity = if triad == Triad::LinearAcceleration {
            belief.site.gravity_m_s2
        } else {
            0.0
        };
        for axis in 0..3 {
            let white = noise.density[axis] / (2.0 * zero.length_s).sqrt();
            let walk = noise.walk[axis] * zero.length_s.sqrt();
            let gain = gravity * fit.row_covariance[axis][(1, 1)].sqrt();
            self.offset[index][axis].add(Cause::SensorNoise, Shape::Normal, white.hypot(gain));
            self.offset[index][axis].add(Cause::BiasWalk, Shape::Normal, walk);
            self.rest[index][axis].add(
                Cause::SensorNoise,
                Shape::Normal,
                white * fit.matrix[(axis, axis)],
            );
            for column in 0..3 {
                self.matrix[index][axis][column].add(
                    Cause::SensorNoise,
                    Shape::Normal,
                    deviations[(axis, column)],
                );
            }
        }
    }

    /// At the drive frequency f a sensor of bandwidth B and damping ζ reads 1 + (1 − 2ζ²)(f/B)² of its gain at rest.
    fn add_bandwidth(
        &mut self,
        triad: Triad,
        condensed: &Condensed,
        estimate: &Estimate,
        sensors: &SensorFile,
    ) {
        let (index, sheet) = (triad.index(), sensors.triad(triad));
        let driven = if triad == Triad::LinearAcceleration {
            &condensed.heave
        } else {
            &condensed.turns[0]
        };
        let ratio = driven.sine.frequency_hz / sheet.bandwidth_hz[0];
        let excess = sheet
            .damping
            .map(|damping| ((1.0 - 2.0 * damping * damping) * ratio * ratio).abs());
        let relative = uniform(excess[0].max(excess[1]));
        for axis in 0..3 {
            // Of the accelerometers only the vertical one is calibrated by a sine.
            if triad != Triad::LinearAcceleration || axis == DegreeOfFreedom::Heave as usize {
                let gain = estimate.fits[index].matrix[(axis, axis)];
                self.matrix[index][axis][axis].add(
                    Cause::Bandwidth,
                    Shape::Uniform,
                    gain * relative,
                );
            }
        }
    }
}
