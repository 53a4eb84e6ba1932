//! A check of the lever arm by the second harmonic in the angular sine runs, which the arm is not estimated from.
//!
//! Turning at ω₀ sin Ωt, a sensor block at r from O feels ω×(ω×r), which swings by ω₀²r/2 at 2Ω. The arm is estimated
//! from the first harmonic, ω̇×r; so the second is predicted from the pose, gravity and that arm, and compared with what
//! the calibrated accelerometers show.
//!
//! The two disagree when they differ by more than four standard uncertainties of the noise and by more than
//! [`MAX_OFFSET_M`] of arm would make: the tape measure behind the sensor file is no better, and a smaller error does no harm.

use hexsense_core::channel::{NAMES, Triad};
use nalgebra::Complex;
use serde::{Deserialize, Serialize};

use super::AnalysisError;
use super::assumptions::Assumptions;
use super::estimate::{Condensed, Estimate, felt};

/// Largest error of the arm that passes, m.
pub const MAX_OFFSET_M: f64 = 0.05;
/// Number of standard uncertainties that pass.
const SIGMAS: f64 = 4.0;

/// Second harmonic of one axis in one angular sine run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SecondHarmonic {
    /// Degree of freedom that is driven.
    pub freedom: String,
    /// Channel of the accelerometer.
    pub channel: String,
    /// Amplitude predicted with the estimated arm, m/s².
    pub predicted: f64,
    /// Amplitude measured, m/s².
    pub measured: f64,
    /// Size of the complex difference of the two, m/s².
    pub difference: f64,
    /// Its standard uncertainty by the sensors' noise, both parts together, m/s².
    pub uncertainty: f64,
    /// Largest difference that passes, m/s².
    pub limit: f64,
}

impl SecondHarmonic {
    /// Whether prediction and measurement agree.
    #[must_use]
    pub fn agrees(&self) -> bool {
        self.difference <= self.limit
    }
}

/// Compares the second harmonics of all angular sine runs, three axes each.
///
/// # Errors
/// [`AnalysisError::Pose`] and [`AnalysisError::Tolerance`].
pub fn second_harmonics(
    condensed: &Condensed,
    estimate: &Estimate,
    assumptions: &Assumptions,
) -> Result<Vec<SecondHarmonic>, AnalysisError> {
    let fit = &estimate.fits[Triad::LinearAcceleration.index()];
    let mut all = Vec::new();
    for sweep in &condensed.turns {
        let truth = condensed.truth(sweep, assumptions)?;
        let [_, predicted] = truth.specific_force(&estimate.lever_arm_m);
        let measured = felt(sweep, fit, assumptions, 2);
        let per_metre = truth.arm_force.iter().flat_map(|force| force[1]);
        let per_metre = per_metre.map(Complex::norm).fold(0.0, f64::max);
        for axis in 0..3 {
            let variance = condensed.force_variance(fit, axis, sweep.length_s);
            let uncertainty = (2.0 * variance).sqrt();
            all.push(SecondHarmonic {
                freedom: sweep.freedom.name().to_owned(),
                channel: NAMES[axis].to_owned(),
                predicted: predicted[axis].norm(),
                measured: measured[axis].norm(),
                difference: Complex::norm(measured[axis] - predicted[axis]),
                uncertainty,
                limit: (SIGMAS * uncertainty).max(MAX_OFFSET_M * per_metre),
            });
        }
    }
    Ok(all)
}

/// What the results say about the lever arm, in plain words; empty when all is well.
///
/// `stated_m` and `tolerance_m` are those of the sensor file, `found` the estimate with its standard uncertainty.
#[must_use]
pub fn warnings(
    harmonics: &[SecondHarmonic],
    stated_m: &[f64; 3],
    tolerance_m: f64,
    found: &[(f64, f64); 3],
) -> Vec<String> {
    let mut warnings = Vec::new();
    for harmonic in harmonics.iter().filter(|harmonic| !harmonic.agrees()) {
        warnings.push(format!(
            "{} sine, {}: the second harmonic is {:.4} m/s², by the estimated lever arm it should be {:.4} m/s² (they \
             differ by {:.4} m/s², limit {:.4} m/s²); is the sensor block fixed to the platform, and do geometry file \
             and base belong together?",
            harmonic.freedom,
            harmonic.channel,
            harmonic.measured,
            harmonic.predicted,
            harmonic.difference,
            harmonic.limit
        ));
    }
    for (axis, (stated, (found, standard))) in
        ["X", "Y", "Z"].iter().zip(stated_m.iter().zip(found))
    {
        let limit_m = tolerance_m + SIGMAS * standard;
        if (found - stated).abs() > limit_m {
            warnings.push(format!(
                "the accelerometers feel the sensor block at {axis} = {found:.3} m, the sensor file has {stated:.3} m (limit \
                 ± {limit_m:.3} m); measure the place of the block again and correct lever_arm_m"
            ));
        }
    }
    warnings
}
