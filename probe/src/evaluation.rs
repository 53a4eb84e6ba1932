//! A recorded campaign evaluated: from the files of its folder to coefficients and characteristics, without a board.

use std::fmt;

use hexsense_core::records::{CoefficientSet, JackCoefficients, MotionBase};

use crate::analysis::assumptions::Assumptions;
use crate::analysis::check::Check;
use crate::analysis::results::{Analysis, analyse};
use crate::analysis::{AnalysisError, RecordedRun};
use crate::campaign::{Campaign, CampaignError};
use crate::characteristics::Characterisation;
use crate::checks;
use crate::coefficient_file::Sources;
use crate::plan::Purpose;
use crate::replay::{self, ReplayError, replay};

/// What the runs of a campaign give.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// The runs that coefficients are fitted to.
    pub runs: Vec<RecordedRun>,
    /// Their analysis.
    pub analysis: Analysis,
    /// How many harmonic sums of the board are the integers that the captures give: all that it sent.
    pub sums: usize,
    /// The motion system, in these runs and in the recorded ones that characterise.
    pub characterisation: Characterisation,
}

/// Why a campaign cannot be evaluated.
#[derive(Debug, thiserror::Error)]
pub enum EvaluationError {
    /// A run or its files cannot be used.
    #[error(transparent)]
    Campaign(#[from] CampaignError),
    /// The captures do not make a calibration.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// The recordings fail checks, and no numbers come out.
    #[error(transparent)]
    Unfit(#[from] Unfit),
    /// The board's sums are not those of the capture.
    #[error("run {run}, analyser {analyser}, {reason}")]
    Sums {
        /// The run.
        run: String,
        /// The analyser of the board, from 0.
        analyser: usize,
        /// What differs.
        reason: ReplayError,
    },
}

/// A campaign that fails checks: the bench is not what its files say.
#[derive(Debug, thiserror::Error)]
pub struct Unfit(pub Vec<Check>);

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "the bench is not what its files say, so there are no coefficients to upload"
        )?;
        let mut open = self.0.iter().filter(|check| check.is_open());
        open.try_for_each(|check| write!(f, "\n  {}: {}", check.name, check.means))
    }
}

impl Evaluation {
    /// Evaluates `campaign`.
    ///
    /// # Errors
    /// [`EvaluationError`]: a run that is not recorded, recordings that fail checks so far that no numbers come out, what
    /// the analysis refuses, and sums of the board that the captures do not give.
    pub fn new(campaign: &Campaign) -> Result<Self, EvaluationError> {
        let (base, sensors) = (&campaign.geometry, &campaign.sensors);
        let runs = campaign.plan.runs_to(Purpose::Calibrate);
        let runs = runs
            .map(|run| campaign.recorded(run))
            .collect::<Result<Vec<_>, _>>()?;
        let mut checks = checks::of_recordings(base, sensors, &runs)?;
        let mut analysis = match analyse(base, sensors, &runs) {
            Ok(analysis) => analysis,
            // What the recordings fail explains more than where the estimate stopped.
            Err(_) if checks.iter().any(Check::is_open) => return Err(Unfit(checks).into()),
            Err(error) => return Err(error.into()),
        };
        checks.extend(checks::of_analysis(base, sensors, &analysis)?);
        analysis.results.checks = checks;
        let mut sums = 0;
        for run in &runs {
            sums += check_sums(campaign, run)?;
        }
        let characterisation = characterise(campaign, &runs)?;
        Ok(Self {
            runs,
            analysis,
            sums,
            characterisation,
        })
    }

    /// The coefficient set that came out of these sources, for this board and date.
    ///
    /// # Errors
    /// [`EvaluationError::Campaign`].
    pub fn coefficient_set(
        &self,
        campaign: &Campaign,
        sources: &Sources,
        board: [u8; 12],
        unix_s: u64,
    ) -> Result<CoefficientSet, EvaluationError> {
        let geometry = &campaign.geometry;
        let mut geometry_hash = [0; 8];
        geometry_hash.copy_from_slice(&geometry.hash[..8]);
        let recorded_by = campaign.board().map_err(CampaignError::from)?;
        let (base, jacks) = base_and_jacks(campaign);
        Ok(CoefficientSet {
            board,
            // A geometry file whose name is too long has been refused.
            geometry: geometry.name.as_str().try_into().unwrap_or_default(),
            geometry_hash,
            unix_s,
            temperature_c: mean_temperature_c(&self.runs),
            provenance: sources.provenance(),
            ratiometric: campaign.sensors.ratiometric(),
            build: recorded_by.build_id(),
            triads: self.analysis.triads,
            base,
            jacks,
        })
    }
}

/// Motion base and transducers as a coefficient set carries them.
#[must_use]
pub fn base_and_jacks(campaign: &Campaign) -> (MotionBase, JackCoefficients) {
    let assumptions = Assumptions::new(&campaign.geometry, &campaign.sensors);
    let base = MotionBase::new(&campaign.geometry.geometry);
    (base, assumptions.jack_coefficients())
}

fn mean_temperature_c(runs: &[RecordedRun]) -> f32 {
    let degrees = runs.iter().flat_map(|run| &run.capture.temperature_c);
    let count = degrees.clone().count().max(1);
    (degrees.map(|degrees| f64::from(*degrees)).sum::<f64>() / count as f64) as f32
}

/// Measures the motion system in `runs` and in those of the campaign that characterise, as far as they are recorded.
///
/// # Errors
/// [`EvaluationError::Campaign`] and [`EvaluationError::Analysis`].
pub fn characterise(
    campaign: &Campaign,
    runs: &[RecordedRun],
) -> Result<Characterisation, EvaluationError> {
    let own = campaign.plan.runs_to(Purpose::Characterise);
    let own = own
        .filter(|run| campaign.is_recorded(&run.name))
        .map(|run| campaign.recorded(run))
        .collect::<Result<Vec<_>, _>>()?;
    let (base, sensors) = (&campaign.geometry, &campaign.sensors);
    Ok(Characterisation::new(
        base,
        sensors,
        runs.iter().chain(&own),
    )?)
}

/// Whether the board's sums of a run are, integer for integer, those that its capture gives; how many sums there are.
///
/// # Errors
/// [`EvaluationError::Campaign`], and [`EvaluationError::Sums`] for the first sum that differs or scans that are
/// missing.
pub fn check_sums(campaign: &Campaign, run: &RecordedRun) -> Result<usize, EvaluationError> {
    let sums = campaign.record(&run.name)?.board_sums;
    for (analyser, sums) in sums.iter().enumerate() {
        replay(sums, &run.capture).map_err(|reason| EvaluationError::Sums {
            run: run.name.clone(),
            analyser,
            reason,
        })?;
    }
    Ok(sums.len() * replay::INTEGERS)
}
