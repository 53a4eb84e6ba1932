//! The evaluation of a campaign, with what is said of it.

use crate::campaign::Campaign;
use crate::evaluation::{Evaluation, EvaluationError};

/// Evaluates the calibration runs, and says that the board's sums were checked.
///
/// # Errors
/// [`EvaluationError`].
pub fn of(campaign: &Campaign) -> Result<Evaluation, EvaluationError> {
    let evaluation = Evaluation::of(campaign)?;
    eprintln!(
        "{} harmonic sums of the board: each is the integer that the capture gives",
        evaluation.sums
    );
    Ok(evaluation)
}
