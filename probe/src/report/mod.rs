//! The report of a campaign: what a laboratory shows to those who must trust its coefficients.
//!
//! One HTML file that loads nothing: text, tables, figures as inline SVG. `hexsense calibrate` writes it,
//! `hexsense verify` writes it again with the held-out movement, and `hexsense report` renders it from the folder alone.
//!
//! | section | file |
//! |---|---|
//! | offsets, sensitivities, matrices, delays | [`channels`] |
//! | head, conditions, runs | [`conditions`], [`base`] |
//! | the verdict and the held-out movement | [`held_out`] |
//! | where the uncertainty comes from | [`budgets`] |
//! | jack displacement, calculated and registered | [`jacks`] |
//! | accelerometers on the holds | [`holds`] |
//! | the place of the sensor block, checked | [`lever_arm`] |
//! | sensor signals with the fitted harmonics | [`signals`] |
//! | the board's own harmonics beside the host's | [`board_sums`], [`board_gain`] |
//! | the motion system: command to pose | [`motion`] |
//!
//! Below them: [`page`] makes the file, [`crate::figure`] the figures and the digits.

pub mod base;
pub mod board_gain;
pub mod board_sums;
pub mod budgets;
pub mod channels;
pub mod conditions;
pub mod held_out;
pub mod holds;
pub mod jacks;
pub mod lever_arm;
pub mod motion;
pub mod page;
pub mod signals;

use hexsense_core::records::CoefficientSet;

use crate::analysis::condense::Sweep;
use crate::analysis::held_out::HeldOut;
use crate::analysis::results::Analysis;
use crate::analysis::{AnalysisError, RecordedRun};
use crate::campaign::{BoardRecord, Campaign, RunRecord, Verification};
use crate::characteristics::Characterisation;
use crate::figure::markup::text;
use page::Page;

/// What a report is made of.
#[derive(Debug, Clone, Copy)]
pub struct ReportInput<'a> {
    /// The folder with its plan, geometry and sensor file.
    pub campaign: &'a Campaign,
    /// The board as noted in the folder.
    pub board: &'a BoardRecord,
    /// The coefficient set that came out.
    pub set: &'a CoefficientSet,
    /// The runs that were analysed.
    pub runs: &'a [RecordedRun],
    /// What is known of all recorded runs beside their scans.
    pub records: &'a [RunRecord],
    /// The analysis of `runs`.
    pub analysis: &'a Analysis,
    /// What the motion system does.
    pub characterisation: &'a Characterisation,
    /// The held-out movement, once it is recorded.
    pub verified: Option<Verified<'a>>,
}

/// The held-out movement and how the channels did on it.
#[derive(Debug, Clone, Copy)]
pub struct Verified<'a> {
    /// The run.
    pub run: &'a RecordedRun,
    /// Its values and their reference.
    pub curves: &'a HeldOut,
    /// How channels and poses of the board came out.
    pub verification: &'a Verification,
}

impl ReportInput<'_> {
    /// All sine runs of the analysis.
    fn sweeps(&self) -> impl Iterator<Item = &Sweep> {
        let condensed = &self.analysis.condensed;
        std::iter::once(&condensed.heave).chain(&condensed.turns)
    }

    /// The analysed run of this name.
    fn run(&self, name: &str) -> Option<&RecordedRun> {
        self.runs.iter().find(|run| run.name == name)
    }
}

/// The report as the text of an HTML file.
///
/// # Errors
/// [`AnalysisError`] when a run of `input` has gaps, its jacks give no pose, or the set cannot be encoded; an
/// analysed campaign gives no such error.
pub fn render(input: &ReportInput) -> Result<String, AnalysisError> {
    let mut page = Page::default();
    channels::results(&mut page, input);
    conditions::section(&mut page, input)?;
    held_out::section(&mut page, input)?;
    channels::matrices(&mut page, input);
    budgets::section(&mut page, input);
    jacks::section(&mut page, input)?;
    holds::section(&mut page, input)?;
    lever_arm::section(&mut page, input);
    signals::section(&mut page, input)?;
    board_sums::section(&mut page, input)?;
    motion::section(&mut page, input)?;
    let title = format!("Calibration report, {}", input.campaign.geometry.name);
    Ok(page.finish(&title, &conditions::head(input)?))
}

/// Digits that are read one by one.
fn code(content: &str) -> String {
    format!("<code>{}</code>", text(content))
}
