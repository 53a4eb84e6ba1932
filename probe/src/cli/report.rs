//! The report of a campaign, written by `calibrate` and again by `verify`.

use hexsense_core::records::CoefficientSet;

use crate::analysis::{self, results::Analysis};
use crate::campaign::Campaign;
use crate::files;
use crate::report::{ReportInput, Verified, render};

/// Writes `report.html` into the campaign's folder.
///
/// # Errors
/// Notes that cannot be read, and a page that cannot be made or written.
pub fn write(
    campaign: &Campaign,
    set: &CoefficientSet,
    runs: &[analysis::Run],
    analysis: &Analysis,
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
        runs,
        records: &records,
        analysis,
        verified,
    })?;
    let path = campaign.folder.join("report.html");
    files::replace(&path, &page)?;
    println!("written: {}", path.display());
    Ok(())
}
