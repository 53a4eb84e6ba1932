//! What the motion system does, measured beside the calibration: `characteristics.json`.
//!
//! Every run in which one sine moves one degree of freedom is measured, whether coefficients are fitted to it or its
//! purpose is to characterise. Only the jacks are used: no coefficient enters here, and none comes out.
//!
//! - [`frequency_response`]: how the pose follows the command.

pub mod frequency_response;

use hexsense_core::excitation::Signal;
use serde::{Deserialize, Serialize};

use crate::analysis::assumptions::Assumptions;
use crate::analysis::condense::{Sweep, sweep};
use crate::analysis::{AnalysisError, RecordedRun};
use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;
use frequency_response::FrequencyResponse;

/// The characteristics of a motion system.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Characteristics {
    /// One entry for each sine run.
    pub frequency_response: Vec<FrequencyResponse>,
}

/// Characteristics with the runs that they come from.
#[derive(Debug, Clone, Default)]
pub struct Characterisation {
    /// The sine runs, reduced.
    pub sweeps: Vec<Sweep>,
    /// What they show.
    pub characteristics: Characteristics,
}

impl Characterisation {
    /// Measures the motion system in `runs`; runs of other movements are passed over.
    ///
    /// # Errors
    /// [`AnalysisError`] when a movement is not found, cut off, has gaps, or its jacks give no pose.
    pub fn new<'a>(
        base: &GeometryFile,
        sensors: &SensorFile,
        runs: impl IntoIterator<Item = &'a RecordedRun>,
    ) -> Result<Self, AnalysisError> {
        let assumptions = Assumptions::new(base, sensors);
        let mut found = Self::default();
        for run in runs {
            if let [(freedom, Signal::Sine(sine))] = run.program.signals.as_slice()
                && sine.amplitude > 0.0
            {
                let sweep = sweep(run, *freedom, *sine, &base.geometry)?;
                let response = FrequencyResponse::new(&sweep, &assumptions)?;
                found.characteristics.frequency_response.push(response);
                found.sweeps.push(sweep);
            }
        }
        Ok(found)
    }
}
