//! Where in a capture the movement starts.
//!
//! A motion controller shares no clock with the board. The program of the jack that moves most is slid along what that
//! jack did; the start is where the two correlate best.

use hexsense_core::channel::{INERTIAL, JACKS};
use hexsense_core::excitation::Program;
use hexsense_core::kinematics::{Geometry, displacements};

use super::AnalysisError;
use super::condense::Counts;

/// Step of the search for the start of a movement, s.
const SEARCH_STEP_S: f64 = 0.01;

impl Counts<'_> {
    /// Start of the program in the capture, s: where the jack that moves most fits its program best.
    ///
    /// # Errors
    /// [`AnalysisError::NotFound`] when no place fits.
    pub fn onset_s(&self, geometry: &Geometry<f64>) -> Result<f64, AnalysisError> {
        let (jack, program) = most_moved(&self.run.program, geometry);
        let stride = (f64::from(self.run.rate_hz) * SEARCH_STEP_S).round() as usize;
        let measured: Vec<f64> = self
            .channels
            .iter()
            .step_by(stride)
            .map(|scan| scan[INERTIAL + jack])
            .collect();
        let places = measured.len().saturating_sub(program.len());
        let best = (0..=places)
            .filter_map(|place| Some((place, correlation(measured.get(place..)?, &program)?)));
        let (place, fit) = best.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
        if fit < 0.9 {
            return Err(AnalysisError::NotFound {
                run: self.run.name.clone(),
                fit: fit.max(0.0) * 100.0,
            });
        }
        Ok(place as f64 * SEARCH_STEP_S)
    }
}

/// The jack that a program moves most, and its displacement every [`SEARCH_STEP_S`].
pub(super) fn most_moved(program: &Program, geometry: &Geometry<f64>) -> (usize, Vec<f64>) {
    let steps = (program.duration_s() / SEARCH_STEP_S).ceil() as usize;
    let rows: Vec<[f64; JACKS]> = (0..=steps)
        .map(|step| {
            displacements(
                geometry,
                &program.pose(geometry, step as f64 * SEARCH_STEP_S),
            )
        })
        .collect();
    let range = |jack: usize| {
        let (low, high) = rows.iter().fold((f64::MAX, f64::MIN), |(low, high), row| {
            (low.min(row[jack]), high.max(row[jack]))
        });
        high - low
    };
    let jack = (0..JACKS)
        .max_by(|a, b| range(*a).total_cmp(&range(*b)))
        .unwrap_or(0);
    (jack, rows.iter().map(|row| row[jack]).collect())
}

/// Correlation of the start of `measured` with `program`, −1 to 1; `None` when it is too short or does not move.
fn correlation(measured: &[f64], program: &[f64]) -> Option<f64> {
    let measured = measured.get(..program.len())?;
    let count = program.len() as f64;
    let (m, p) = (
        measured.iter().sum::<f64>() / count,
        program.iter().sum::<f64>() / count,
    );
    let (mut cross, mut mm, mut pp) = (0.0, 0.0, 0.0);
    for (measured, program) in measured.iter().zip(program) {
        cross += (measured - m) * (program - p);
        mm += (measured - m) * (measured - m);
        pp += (program - p) * (program - p);
    }
    (mm > 0.0 && pp > 0.0).then(|| cross / (mm * pp).sqrt())
}
