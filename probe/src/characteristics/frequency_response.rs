//! How the base follows a sine: the first harmonic of the pose against the command.

use core::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Complex;
use serde::{Deserialize, Serialize};

use crate::analysis::AnalysisError;
use crate::analysis::assumptions::Assumptions;
use crate::analysis::condense::Sweep;
use crate::analysis::poses::{complex, pose_harmonics};

/// How the base followed one sine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrequencyResponse {
    /// Name of the run.
    pub run: String,
    /// Degree of freedom.
    pub freedom: String,
    /// Drive frequency by the board's clock, Hz.
    pub frequency_hz: f64,
    /// Amplitude of the command, m or rad.
    pub command: f64,
    /// Amplitude of the measured pose, m or rad.
    pub measured: f64,
    /// Measured over command.
    pub ratio: f64,
    /// Phase of the pose against the command, degrees. The start of the command is itself found from the jacks, so a
    /// pure delay of the base does not show.
    pub phase_deg: f64,
    /// Total harmonic distortion of the pose.
    pub distortion: f64,
}

impl FrequencyResponse {
    /// The response in a sine run: first harmonic of the driven coordinate against the command.
    ///
    /// # Errors
    /// [`AnalysisError::Pose`], [`AnalysisError::NoSine`] and [`AnalysisError::Tolerance`].
    pub fn new(sweep: &Sweep, assumptions: &Assumptions) -> Result<Self, AnalysisError> {
        let fit = &pose_harmonics(sweep, assumptions)?[sweep.freedom as usize];
        let first = complex(&fit.first());
        // The command A·sin(2πf(t − onset)) at the first scan of the estimate, as a complex amplitude.
        let into_s = sweep.first as f64 / f64::from(sweep.rate_hz) - sweep.onset_s;
        let phase = TAU * sweep.sine.frequency_hz * into_s - FRAC_PI_2;
        let lead = first * Complex::cis(-phase);
        Ok(Self {
            run: sweep.name.clone(),
            freedom: sweep.freedom.name().to_owned(),
            frequency_hz: sweep.omega / TAU,
            command: sweep.sine.amplitude,
            measured: first.norm(),
            ratio: first.norm() / sweep.sine.amplitude,
            phase_deg: lead.arg().to_degrees(),
            distortion: fit.distortion(),
        })
    }
}
