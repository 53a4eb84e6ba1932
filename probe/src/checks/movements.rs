//! What the jacks did in each run, and what they were told to do, in rows of 10 ms.

use core::ops::Range;

use hexsense_core::channel::{CHANNELS, INERTIAL, JACKS};

use crate::analysis::assumptions::Assumptions;
use crate::analysis::condense::Counts;
use crate::analysis::{AnalysisError, RecordedRun};
use crate::geometry_file::GeometryFile;

/// Time between rows, s.
pub(super) const STEP_S: f64 = 0.01;

/// What the jacks did in all runs, and what they were told to do.
pub(super) struct Movements<'a> {
    pub(super) runs: Vec<Movement<'a>>,
    /// Length of the stroke, m.
    pub(super) stroke_m: f64,
}

/// What the jacks did in one run, in rows of [`STEP_S`].
pub(super) struct Movement<'a> {
    pub(super) run: &'a RecordedRun,
    pub(super) counts: Counts<'a>,
    /// Displacement of each jack from mid-stroke as its transducer shows it, m.
    pub(super) shown: Vec<[f64; JACKS]>,
    /// The program's displacements, m; empty at rest.
    pub(super) program: Vec<[f64; JACKS]>,
    /// The rows of `shown` in which the program runs; `None` when no jack follows it.
    pub(super) during: Option<Range<usize>>,
}

impl<'a> Movements<'a> {
    /// Reads the movements of `runs`.
    ///
    /// # Errors
    /// [`AnalysisError::Gap`] and [`AnalysisError::Short`].
    pub(super) fn new(
        base: &GeometryFile,
        assumptions: &Assumptions,
        runs: &'a [RecordedRun],
    ) -> Result<Self, AnalysisError> {
        let geometry = &base.geometry;
        let movement = |run: &'a RecordedRun| -> Result<Movement<'a>, AnalysisError> {
            let counts = Counts::new(run)?;
            let shown = shown(&counts, assumptions, geometry.mid_length_m());
            let mut program = Vec::new();
            let mut during = None;
            if !run.program.signals.is_empty() {
                program = run.program.jack_rows(geometry, STEP_S).collect();
                during = match counts.onset_s(geometry) {
                    Ok(onset_s) => {
                        let first = (onset_s / STEP_S).round() as usize;
                        Some(first..(first + program.len()).min(shown.len()))
                    }
                    Err(AnalysisError::NotFound { .. }) => None,
                    Err(error) => return Err(error),
                };
            }
            Ok(Movement {
                run,
                counts,
                shown,
                program,
                during,
            })
        };
        Ok(Self {
            runs: runs.iter().map(movement).collect::<Result<_, _>>()?,
            stroke_m: geometry.length_max_m() - geometry.length_min_m(),
        })
    }
}

/// Displacements from mid-stroke, m: means over rows of [`STEP_S`].
fn shown(counts: &Counts, assumptions: &Assumptions, mid_length_m: f64) -> Vec<[f64; JACKS]> {
    let stride = ((f64::from(counts.run().rate_hz) * STEP_S).round() as usize).max(1);
    let mean = |scans: &[[f64; CHANNELS]]| {
        let means = core::array::from_fn(|jack| {
            let sum: f64 = scans.iter().map(|scan| scan[INERTIAL + jack]).sum();
            sum / scans.len() as f64
        });
        assumptions
            .lengths_m(&means)
            .map(|length_m| length_m - mid_length_m)
    };
    counts.scans().chunks_exact(stride).map(mean).collect()
}
