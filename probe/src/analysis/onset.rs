//! Where in a capture the movement starts.
//!
//! A motion controller shares no clock with the board. The program of the jack that moves most is slid along what that
//! jack did; the start is where the two correlate best. If that jack does not fit well, the others are tried, so that one bad
//! jack hides no start.

use hexsense_core::channel::{INERTIAL, JACKS};
use hexsense_core::kinematics::Geometry;

use super::AnalysisError;
use super::condense::Counts;

/// Fit of a jack that certainly followed. An inverted jack fits a sine worse, half a period late.
const CERTAIN: f64 = 0.998;
/// Step of the search for the start of a movement, s.
const SEARCH_STEP_S: f64 = 0.01;

impl Counts<'_> {
    /// Start of the program in the capture, s: where a jack that moves much fits its program best.
    ///
    /// # Errors
    /// [`AnalysisError::NotFound`] when no place fits.
    pub fn onset_s(&self, geometry: &Geometry<f64>) -> Result<f64, AnalysisError> {
        let stride = (f64::from(self.run.rate_hz) * SEARCH_STEP_S).round() as usize;
        let (mut best, mut best_fit) = (0, 0.0);
        let rows = self.program_rows(geometry);
        for jack in most_moved(&rows) {
            let program: Vec<f64> = rows.iter().map(|row| row[jack]).collect();
            let scans = self.channels.iter().step_by(stride);
            let measured: Vec<f64> = scans.map(|scan| scan[INERTIAL + jack]).collect();
            let (place, fit) = best_place(&measured, &program);
            if fit > best_fit {
                (best, best_fit) = (place, fit);
            }
            if best_fit >= CERTAIN {
                break;
            }
        }
        if !is_found(best_fit) {
            return Err(AnalysisError::NotFound {
                run: self.run.name.clone(),
                fit: best_fit * 100.0,
            });
        }
        Ok(best as f64 * SEARCH_STEP_S)
    }

    /// What the jacks are told to do, m: rows every [`SEARCH_STEP_S`].
    pub(super) fn program_rows(&self, geometry: &Geometry<f64>) -> Vec<[f64; JACKS]> {
        let rows = self.run.program.jack_rows(geometry, SEARCH_STEP_S);
        rows.collect()
    }
}

/// The place of `program` in `measured` where the two correlate best, and their correlation there.
fn best_place(measured: &[f64], program: &[f64]) -> (usize, f64) {
    let places = 0..=measured.len().saturating_sub(program.len());
    places
        .filter_map(|place| Some((place, correlation(measured.get(place..)?, program)?)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, 0.0))
}

/// Whether a jack that fits its program so well followed it.
fn is_found(fit: f64) -> bool {
    fit >= 0.9
}

/// The jacks that a program with these rows moves at least half as far as the one that it moves most, this one first.
pub(crate) fn most_moved(rows: &[[f64; JACKS]]) -> Vec<usize> {
    let ranges: [f64; JACKS] = core::array::from_fn(|jack| {
        let (low, high) = rows.iter().fold((f64::MAX, f64::MIN), |(low, high), row| {
            (low.min(row[jack]), high.max(row[jack]))
        });
        high - low
    });
    let mut jacks: Vec<usize> = (0..JACKS).collect();
    jacks.sort_by(|a, b| ranges[*b].total_cmp(&ranges[*a]));
    let least = ranges[jacks[0]] / 2.0;
    jacks.retain(|jack| ranges[*jack] >= least);
    jacks
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_movement_is_found_from_a_fit_of_nine_tenths_on() {
        assert!(is_found(0.9) && is_found(1.0));
        assert!(!is_found(0.9_f64.next_down()) && !is_found(-1.0) && !is_found(f64::NAN));
    }

    /// With r times a signal that is orthogonal to the program the correlation is 1/√(1 + r²).
    #[test]
    fn what_is_added_to_a_program_lowers_its_fit() {
        let program = [1.0, -1.0, 1.0, -1.0];
        for r in [0.0, 0.5, 2.0] {
            let measured = [1.0 + r, -1.0 + r, 1.0 - r, -1.0 - r].map(|value| 7.0 * value + 40.0);
            let fit = correlation(&measured, &program).unwrap();
            assert!((fit - 1.0 / (1.0_f64 + r * r).sqrt()).abs() < 1e-12);
            let opposite = correlation(&measured.map(|value| -value), &program).unwrap();
            assert!((opposite + fit).abs() < 1e-12);
        }
        assert_eq!(correlation(&[40.0; 4], &program), None, "it does not move");
        assert_eq!(
            correlation(&program[1..], &program),
            None,
            "it is too short"
        );
    }
}
