//! From the recordings of a campaign to its analysis, and from there to the coefficient set.
//!
//! ```text
//! captures ── analysis ── board's sums checked ── coefficient set
//! ```

use hexsense_core::records::{CoefficientSet, JackCoefficients, MotionBase};

use crate::analysis::{self, results::Analysis};
use crate::campaign::{Campaign, CampaignError};
use crate::files::FileError;
use crate::plan::Purpose;
use crate::replay::{self, ReplayError, replay};

/// The calibration runs of a campaign, and what is found in them.
pub struct Evaluation {
    /// The runs with their scans.
    pub runs: Vec<analysis::Run>,
    /// What the analysis finds.
    pub analysis: Analysis,
    /// Harmonic sums of the board, each of which is the integer that the capture gives.
    pub sums: usize,
}

/// Sums of the board that the capture of the run does not give.
#[derive(Debug, thiserror::Error)]
#[error("run {run}, analyser {analyser}, {reason}")]
pub struct WrongSums {
    /// The run.
    pub run: String,
    /// The analyser, from 0.
    pub analyser: usize,
    /// What differs.
    pub reason: ReplayError,
}

/// Why a campaign cannot be evaluated.
#[derive(Debug, thiserror::Error)]
pub enum EvaluationError {
    /// A run that is not recorded, or whose files cannot be used.
    #[error(transparent)]
    Campaign(#[from] CampaignError),
    /// The analysis refuses.
    #[error(transparent)]
    Analysis(#[from] analysis::AnalysisError),
    /// Sums of the board are not those of its scans.
    #[error(transparent)]
    Sums(#[from] WrongSums),
}

impl Evaluation {
    /// Evaluates the calibration runs of a campaign.
    ///
    /// # Errors
    /// [`EvaluationError`].
    pub fn of(campaign: &Campaign) -> Result<Self, EvaluationError> {
        let runs = campaign.plan.runs_to(Purpose::Calibrate);
        let runs = runs
            .map(|run| campaign.recorded(run))
            .collect::<Result<Vec<_>, _>>()?;
        let analysis = analysis::results::analyse(&campaign.geometry, &campaign.sensors, &runs)?;
        let mut sums = 0;
        for run in &runs {
            sums += check_sums(campaign, run)?;
        }
        Ok(Self {
            runs,
            analysis,
            sums,
        })
    }

    /// The coefficient set of this campaign for the board with this unique id.
    ///
    /// # Errors
    /// Captures that cannot be read.
    pub fn coefficient_set(
        &self,
        campaign: &Campaign,
        board: [u8; 12],
        unix_s: u64,
        (base, jacks): (MotionBase, JackCoefficients),
    ) -> Result<CoefficientSet, FileError> {
        let geometry = &campaign.geometry;
        let mut geometry_hash = [0; 8];
        geometry_hash.copy_from_slice(&geometry.hash[..8]);
        Ok(CoefficientSet {
            board,
            // A geometry file whose name is too long has been refused.
            geometry: geometry.name.as_str().try_into().unwrap_or_default(),
            geometry_hash,
            unix_s,
            temperature_c: mean_temperature_c(&self.runs),
            provenance: campaign.provenance(self.runs.iter().map(|run| run.name.as_str()))?,
            triads: self.analysis.triads,
            base,
            jacks,
        })
    }
}

/// Whether the board's sums of a run are, integer for integer, those that its capture gives; how many sums there are.
///
/// # Errors
/// The first sum that differs, and scans that are missing.
pub fn check_sums(campaign: &Campaign, run: &analysis::Run) -> Result<usize, EvaluationError> {
    let sums = campaign.record(&run.name)?.board_sums;
    for (analyser, sums) in sums.iter().enumerate() {
        replay(sums, &run.capture).map_err(|reason| WrongSums {
            run: run.name.clone(),
            analyser,
            reason,
        })?;
    }
    Ok(sums.len() * replay::INTEGERS)
}

fn mean_temperature_c(runs: &[analysis::Run]) -> f32 {
    let degrees = runs.iter().flat_map(|run| &run.capture.temperature_c);
    let count = degrees.clone().count().max(1);
    (degrees.map(|degrees| f64::from(*degrees)).sum::<f64>() / count as f64) as f32
}
