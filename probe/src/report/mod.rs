//! The report of a campaign: what a laboratory shows to those who must trust its coefficients.
//!
//! One HTML file that loads nothing: text, tables, figures as inline SVG. `hexsense calibrate` writes it,
//! `hexsense verify` writes it again with the held-out movement, and `hexsense report` renders it from the folder alone.
//!
//! | section | file |
//! |---|---|
//! | offsets, sensitivities, matrices, delays | [`channels`] |
//! | head, conditions, runs | [`conditions`], [`crate::base_figure`] |
//! | whether the bench was what its files say | [`checks`] |
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

pub mod board_gain;
pub mod board_sums;
pub mod budgets;
pub mod channels;
pub mod checks;
pub mod conditions;
pub mod held_out;
pub mod holds;
pub mod input;
pub mod jacks;
pub mod lever_arm;
pub mod motion;
pub mod page;
pub mod signals;

use crate::analysis::AnalysisError;
pub use input::{ReportInput, Verified};
use page::Page;

/// The report as the text of an HTML file.
///
/// # Errors
/// [`AnalysisError`] when a run of `input` has gaps, its jacks give no pose, or the set cannot be encoded; an
/// analysed campaign gives no such error.
pub fn render(input: &ReportInput) -> Result<String, AnalysisError> {
    let mut page = Page::default();
    channels::results(&mut page, input);
    conditions::section(&mut page, input)?;
    checks::section(&mut page, input);
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
