//! `hexsense report`: the report of a campaign, from the files in its folder.

use std::path::PathBuf;

use clap::Args;
use hexsense_core::records::CoefficientSet;

use crate::analysis::held_out;
use crate::campaign::{Campaign, CampaignError, Given, sources};
use crate::coefficient_file::{self, Sources};
use crate::evaluation::{Evaluation, EvaluationError};
use crate::files;
use crate::plan::Purpose;
use crate::report::{ReportInput, Verified, render};
use crate::terminal::{say, tell};

/// Render the report of a finished campaign again, without a board.
///
/// Evaluates the recordings in FOLDER again and writes report.html there, the same page that `calibrate` or `verify`
/// wrote if nothing has changed since. No other file is written. Fails when a recording or a result is missing, and when
/// the recordings are not those that coefficients.toml was found from.
#[derive(Args)]
pub struct Report {
    /// Folder of the campaign
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

impl Report {
    /// Runs the command.
    ///
    /// # Errors
    /// Files that are missing or cannot be used, and what the evaluation refuses.
    pub fn run(self) -> anyhow::Result<()> {
        let (campaign, _) = Given::default().resume(&self.folder)?;
        let (set, found_from) = coefficient_file::load(&campaign.coefficients_path()?)?;
        let noted = campaign.results()?;
        check_sources(&campaign, &found_from)?;
        let evaluation = evaluate(&campaign)?;
        if evaluation.analysis.results == noted {
            tell!("the recordings give the numbers of results.json again");
        } else {
            tell!(
                "warning: the recordings give other numbers than results.json holds, which another version of hexsense \
                 wrote; the report has the new ones"
            );
        }
        write_verified(&campaign, &set, &evaluation)
    }
}

/// Whether recordings, plan, geometry and sensors are those that the set was found from.
fn check_sources(campaign: &Campaign, found_from: &Sources) -> Result<(), CampaignError> {
    for run in campaign.plan.runs_to(Purpose::Calibrate) {
        campaign.record(&run.name)?;
    }
    // A campaign that opens and has every record has every file.
    sources::check(&campaign.folder, found_from).map(drop)
}

/// Writes the report with the held-out movement, if the campaign is verified.
fn write_verified(
    campaign: &Campaign,
    set: &CoefficientSet,
    evaluation: &Evaluation,
) -> anyhow::Result<()> {
    let Some(verification) = campaign.verification()? else {
        return write(campaign, set, evaluation, None);
    };
    let run = campaign.recorded(campaign.first_run_to(Purpose::Verify)?)?;
    let results = &evaluation.analysis.results;
    let curves = held_out::held_out(&campaign.geometry, &campaign.sensors, &run, results)?;
    let verified = Verified {
        run: &run,
        curves: &curves,
        verification: &verification,
    };
    write(campaign, set, evaluation, Some(verified))
}

/// Evaluates a campaign and says that its recordings are the board's own.
///
/// # Errors
/// [`EvaluationError`].
pub fn evaluate(campaign: &Campaign) -> Result<Evaluation, EvaluationError> {
    let evaluation = Evaluation::new(campaign)?;
    tell!(
        "{} harmonic sums of the board: each is the integer that the capture gives",
        evaluation.sums
    );
    Ok(evaluation)
}

/// Writes `report.html` into the campaign's folder.
///
/// # Errors
/// Notes that cannot be read, and a page that cannot be made or written.
pub fn write(
    campaign: &Campaign,
    set: &CoefficientSet,
    evaluation: &Evaluation,
    verified: Option<Verified>,
) -> anyhow::Result<()> {
    let recorded = campaign
        .plan
        .runs
        .iter()
        .filter(|run| campaign.is_recorded(&run.name));
    let records = recorded
        .map(|run| campaign.record(&run.name))
        .collect::<Result<Vec<_>, _>>()?;
    let page = render(&ReportInput {
        campaign,
        board: &campaign.board()?,
        set,
        runs: &evaluation.runs,
        records: &records,
        analysis: &evaluation.analysis,
        characterisation: &evaluation.characterisation,
        verified,
    })?;
    let path = campaign.folder.join("report.html");
    files::replace(&path, &page)?;
    say!("written: {}", path.display())?;
    Ok(())
}
