//! Uncertainty budgets of everything that a campaign finds.
//!
//! The estimate is repeated under each perturbation of the assumptions; the change of each result is that
//! perturbation's term (GUM 5.1.3, note 2). What is random, the sensors' noise and wandering, comes from the
//! covariances of the fits.

use hexsense_core::calibration::budget::{Budget, Cause, Distribution, uniform};
use hexsense_core::calibration::triad::MeasuredHold;
use hexsense_core::channel::{INERTIAL, JACKS, Triad};
use hexsense_core::excitation::DegreeOfFreedom;
use nalgebra::Vector3;

use super::AnalysisError;
use super::assumptions::Assumptions;
use super::condense::{RestMeans, Sweep};
use super::estimate::{Condensed, Estimate, triad_counts};
use super::poses::{pose_harmonics, rest_truth};
use super::settling::Settling;
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
    /// Delay of each triad as the mean of its three sensors, s.
    pub delay: [Budget; 3],
}

impl Budgets {
    /// Repeats the estimate under every perturbation and adds noise and bandwidth.
    ///
    /// # Errors
    /// [`AnalysisError`] when an estimate fails under a perturbation.
    pub fn new(
        condensed: &Condensed,
        assumptions: &Assumptions,
        estimate: &Estimate,
        base: &GeometryFile,
        sensors: &SensorFile,
    ) -> Result<Self, AnalysisError> {
        let mut budgets = Self::default();
        for perturbation in assumptions.perturbations(base, sensors) {
            let changed = condensed.estimate(&perturbation.assumptions)?;
            budgets.add_change(
                perturbation.cause,
                perturbation.shape,
                [1.0; 3],
                estimate,
                &changed,
            );
        }
        for (budget, noise_m) in budgets
            .lever_arm
            .iter_mut()
            .zip(&estimate.lever_arm_noise_m)
        {
            budget.add(Cause::SensorNoise, Distribution::Normal, *noise_m);
        }
        for sweep in std::iter::once(&condensed.heave).chain(&condensed.turns) {
            budgets.add_jack_noise(sweep, assumptions, estimate)?;
        }
        budgets.add_jack_noise_at_rest(condensed, assumptions, estimate)?;
        for triad in Triad::ALL {
            budgets.add_noise(triad, condensed, estimate, assumptions);
            budgets.add_bandwidth(triad, condensed, estimate, sensors);
            budgets.add_delay(triad, estimate, sensors);
        }
        Ok(budgets)
    }

    /// Adds what is left of transients.
    pub fn add_settling(&mut self, settling: &Settling, estimate: &Estimate) {
        let parts = settling.share.map(f64::sqrt);
        let later = &settling.later;
        self.add_change(
            Cause::Settling,
            Distribution::Normal,
            parts,
            estimate,
            later,
        );
    }

    /// Adds the change of every result, taken at the `parts` of the three triads.
    fn add_change(
        &mut self,
        cause: Cause,
        shape: Distribution,
        parts: [f64; 3],
        estimate: &Estimate,
        changed: &Estimate,
    ) {
        let felt = parts[Triad::LinearAcceleration.index()];
        let arm = (changed.lever_arm_m - estimate.lever_arm_m) * felt;
        // The value at rest at home is the specific force that was assumed there, whatever the gain.
        let home = (changed.home - estimate.home) * felt;
        for axis in 0..3 {
            self.lever_arm[axis].add(cause, shape, arm[axis]);
            self.rest[Triad::LinearAcceleration.index()][axis].add(cause, shape, home[axis]);
        }
        for (triad, part) in parts.into_iter().enumerate() {
            let later_s = changed.fits[triad].delay_s - estimate.fits[triad].delay_s;
            self.delay[triad].add(cause, shape, later_s * part);
            let matrix = (changed.fits[triad].matrix - estimate.fits[triad].matrix) * part;
            let offset = (changed.offsets[triad] - estimate.offsets[triad]) * part;
            for axis in 0..3 {
                self.offset[triad][axis].add(cause, shape, offset[axis]);
                for column in 0..3 {
                    self.matrix[triad][axis][column].add(cause, shape, matrix[(axis, column)]);
                }
            }
        }
    }

    fn add_noise(
        &mut self,
        triad: Triad,
        condensed: &Condensed,
        estimate: &Estimate,
        assumptions: &Assumptions,
    ) {
        let (index, fit) = (triad.index(), &estimate.fits[triad.index()]);
        let (noise, zero) = (&condensed.noise[index], &condensed.zero);
        let deviations = fit.matrix_noise();
        let gravity = if triad == Triad::LinearAcceleration {
            assumptions.site.gravity_m_s2
        } else {
            0.0
        };
        for axis in 0..3 {
            let white = noise.density[axis] / (2.0 * zero.length_s).sqrt();
            let walk = noise.walk[axis] * zero.length_s.sqrt();
            let gain = gravity * fit.row_covariance[axis][(1, 1)].sqrt();
            self.offset[index][axis].add(
                Cause::SensorNoise,
                Distribution::Normal,
                white.hypot(gain),
            );
            self.offset[index][axis].add(Cause::BiasWalk, Distribution::Normal, walk);
            self.rest[index][axis].add(
                Cause::SensorNoise,
                Distribution::Normal,
                white * fit.matrix[(axis, axis)],
            );
            for column in 0..3 {
                self.matrix[index][axis][column].add(
                    Cause::SensorNoise,
                    Distribution::Normal,
                    deviations[(axis, column)],
                );
            }
        }
    }

    /// Noise of the jacks in the means at rest: each is changed by its standard uncertainty, which their scatter gives.
    fn add_jack_noise_at_rest(
        &mut self,
        condensed: &Condensed,
        assumptions: &Assumptions,
        estimate: &Estimate,
    ) -> Result<(), AnalysisError> {
        let (linear, holds) = (Triad::LinearAcceleration, condensed.holds(assumptions)?);
        let heave = condensed.truth(&condensed.heave, assumptions)?;
        let [lifted, ..] = condensed.sine_runs(&heave, &[], assumptions);
        let at_rest = triad_counts(&condensed.zero.counts, linear, assumptions);
        let mut add = |holds: &[MeasuredHold], home: Vector3<f64>| -> Result<(), AnalysisError> {
            let fit = condensed.fit(linear, holds, &lifted)?;
            let mut changed = estimate.clone();
            changed.home = home;
            changed.offsets[linear.index()] = fit.offset(&at_rest, &home);
            changed.fits[linear.index()] = fit;
            self.add_change(
                Cause::JackNoise,
                Distribution::Normal,
                [1.0; 3],
                estimate,
                &changed,
            );
            Ok(())
        };
        for jack in 0..JACKS {
            let noisy = |rest: &RestMeans, run: &str| {
                let mut rest = rest.clone();
                rest.counts[INERTIAL + jack] += rest.jack_noise[jack];
                rest_truth(assumptions, &rest, run)
            };
            add(&holds, noisy(&condensed.zero, "zero")?)?;
            let runs = condensed.hold_runs.iter();
            let rests = runs.flat_map(|run| run.holds.iter().map(|rest| (rest, &run.name)));
            for (place, (rest, run)) in rests.enumerate() {
                let mut holds = holds.clone();
                holds[place].truth = noisy(rest, run)?;
                add(&holds, estimate.home)?;
            }
        }
        Ok(())
    }

    /// Noise of the jacks in amplitude and phase of the pose, from what the fit of the pose leaves.
    fn add_jack_noise(
        &mut self,
        sweep: &Sweep,
        assumptions: &Assumptions,
        estimate: &Estimate,
    ) -> Result<(), AnalysisError> {
        let driven = sweep.freedom as usize;
        let fit = &pose_harmonics(sweep, assumptions)?[driven];
        let amplitude = fit.first().amplitude();
        let triads: &[Triad] = match sweep.freedom.is_rotation() {
            true => &[Triad::AngularAcceleration, Triad::AngularRate],
            false => &[Triad::LinearAcceleration],
        };
        for triad in triads.iter().filter(|_| amplitude > 0.0) {
            let (index, axis) = (triad.index(), driven % 3);
            let gain = estimate.fits[index].matrix[(axis, axis)];
            let standard = gain * fit.uncertainty.amplitude[0] / amplitude;
            self.matrix[index][axis][axis].add(Cause::JackNoise, Distribution::Normal, standard);
            let phase =
                estimate.fits[index].delay_shares[axis] * fit.uncertainty.amplitude[0] / amplitude;
            self.delay[index].add(Cause::JackNoise, Distribution::Normal, phase / sweep.omega);
        }
        Ok(())
    }

    /// The sine runs do not move the three sensors alike, so the delay found is not quite the mean of theirs; how far
    /// it may be off follows from the range of delays that the data sheet allows. Damping over bandwidth, each uniform, is not
    /// uniform itself: its fourth cumulant is almost that of a normal distribution (−0.02 at 0.6 to 1 and 50 to 120 Hz).
    fn add_delay(&mut self, triad: Triad, estimate: &Estimate, sensors: &SensorFile) {
        let (index, fit) = (triad.index(), &estimate.fits[triad.index()]);
        self.delay[index].add(Cause::SensorNoise, Distribution::Normal, fit.delay_noise_s);
        let deviation_s = sensors.triad(triad).delay_deviation_s();
        for share in fit.delay_shares {
            let excess = share - 1.0 / 3.0;
            self.delay[index].add(Cause::Bandwidth, Distribution::Normal, excess * deviation_s);
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
                    Distribution::Uniform,
                    gain * relative,
                );
            }
        }
    }
}
