//! Checks of a campaign: whether the bench is what its files say, before its numbers become coefficients.
//!
//! An estimate always comes out. With two sensors exchanged, a jack that reads 2 % too much or the file of another base,
//! it comes out wrong and with a small uncertainty. So each part of the bench is compared with something that it did not
//! make itself:
//!
//! | file | what is checked | against |
//! |---|---|---|
//! | `jacks` | what each jack did | its own program |
//! | `home` | the base before and after each run | the zero run |
//! | `sensors` | answer, noise and zero of each sensor | the zero run and the data sheet |
//! | `sheet` | gain, direction and bias of each sensor | its data sheet |
//! | `shape` | the third harmonic of each sensor in the sine runs | that of the base |
//!
//! `movements` puts what the jacks did beside what they were told, `rests` finds the stretches at rest.
//!
//! A check has a statistic, a limit and the parts that it accuses, the likeliest first. `not observable` means that the
//! campaign holds nothing to judge by; it is no pass. What these checks cannot see: an error that jacks, programs and
//! sensors share, such as a geometry file that is wrong in scale, or a transducer that the servo reads too.

mod home;
mod jacks;
mod movements;
mod rests;
mod sensors;
mod shape;
mod sheet;

use crate::analysis::assumptions::Assumptions;
use movements::Movements;

use crate::analysis::check::Check;
use crate::analysis::results::Analysis;
use crate::analysis::{AnalysisError, RecordedRun};
use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// The checks that need no estimate: jacks against their programs, rests against the zero run.
///
/// # Errors
/// [`AnalysisError::Gap`] and [`AnalysisError::Short`] for a run that is not whole.
pub fn of_recordings(
    base: &GeometryFile,
    sheets: &SensorFile,
    runs: &[RecordedRun],
) -> Result<Vec<Check>, AnalysisError> {
    let assumptions = Assumptions::new(base, sheets);
    let movements = Movements::new(base, &assumptions, runs)?;
    let mut checks = jacks::checks(&movements);
    let zero = movements.runs.iter().find(|run| run.program.is_empty());
    let zero = zero.and_then(rests::zero_run);
    let rests: Vec<_> = movements.runs.iter().flat_map(rests::rests).collect();
    let limit_m = home::limit_m(&movements);
    checks.extend([
        home::check(zero.as_ref(), &rests, limit_m),
        sensors::answers(zero.as_ref(), &movements),
        sensors::noise(zero.as_ref(), sheets),
        sensors::zeros(zero.as_ref(), &rests, sheets, limit_m),
    ]);
    Ok(checks)
}

/// The checks of what the estimate found: each sensor against its data sheet, and the shape of its signal.
///
/// # Errors
/// [`AnalysisError::Pose`] and [`AnalysisError::Tolerance`].
pub fn of_analysis(
    base: &GeometryFile,
    sensors: &SensorFile,
    analysis: &Analysis,
) -> Result<Vec<Check>, AnalysisError> {
    let mut checks = sheet::checks(sensors, analysis);
    // After the directions, and before the gains: a signal that is cut has the wrong gain too.
    checks.insert(1, shape::check(&Assumptions::new(base, sensors), analysis)?);
    Ok(checks)
}
