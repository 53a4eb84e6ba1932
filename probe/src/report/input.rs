//! What a report is made of.

use hexsense_core::records::CoefficientSet;

use crate::analysis::RecordedRun;
use crate::analysis::condense::Sweep;
use crate::analysis::held_out::HeldOut;
use crate::analysis::results::Analysis;
use crate::campaign::{BoardRecord, Campaign, RunRecord, Verification};
use crate::characteristics::Characterisation;

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
    pub(super) fn sweeps(&self) -> impl Iterator<Item = &Sweep> {
        let condensed = &self.analysis.condensed;
        std::iter::once(&condensed.heave).chain(&condensed.turns)
    }

    /// The analysed run of this name.
    pub(super) fn run(&self, name: &str) -> Option<&RecordedRun> {
        self.runs.iter().find(|run| run.name == name)
    }
}
