//! Poses from the jacks of condensed runs, their harmonics, and the specific force at rest.

use hexsense_core::calibration::truth::{coordinates, specific_force_at_rest};
use hexsense_core::channel::{CHANNELS, INERTIAL, JACKS};
use hexsense_core::facts::BoardFacts;
use hexsense_core::harmonics::{Harmonic, Harmonics, Series};
use hexsense_core::kinematics::{Options, Pose, PoseTracker, ReportFailure, Solver};
use nalgebra::{Complex, Vector3};

use super::AnalysisError;
use super::assumptions::Assumptions;
use super::condense::{RestMeans, Sweep};

/// Poses of a base, one after another.
pub struct RunPoses<'a> {
    assumptions: &'a Assumptions,
    tracker: PoseTracker<f64, ReportFailure>,
    run: &'a str,
}

impl<'a> RunPoses<'a> {
    /// Starts at home; `run` is named in errors.
    ///
    /// # Errors
    /// [`AnalysisError::Tolerance`] when the assumed numbers are no motion base.
    pub fn new(assumptions: &'a Assumptions, run: &'a str) -> Result<Self, AnalysisError> {
        let geometry = assumptions
            .geometry()
            .map_err(|problem| AnalysisError::Tolerance {
                cause: "the hinges",
                problem: problem.to_string(),
            })?;
        let solver = Solver::new(&geometry, Options::measured());
        Ok(Self {
            assumptions,
            tracker: PoseTracker::new(solver, ReportFailure),
            run,
        })
    }

    /// Pose from the counts of the jacks at nominal supply, solved from the pose before.
    ///
    /// # Errors
    /// [`AnalysisError::Pose`].
    pub fn next(&mut self, counts: &[f64; JACKS]) -> Result<Pose<f64>, AnalysisError> {
        let lengths = self.assumptions.lengths_m(counts);
        let solution = self.tracker.next(&lengths);
        let solution = solution.map_err(|source| AnalysisError::Pose {
            run: self.run.to_owned(),
            source,
        })?;
        Ok(solution.pose)
    }
}

/// Specific force on a base at rest.
pub(super) fn rest_truth(
    assumptions: &Assumptions,
    rest: &RestMeans,
    run: &str,
) -> Result<Vector3<f64>, AnalysisError> {
    let counts = core::array::from_fn(|jack| rest.counts[INERTIAL + jack]);
    let pose = RunPoses::new(assumptions, run)?.next(&counts)?;
    Ok(specific_force_at_rest(&pose.rotation, &assumptions.site))
}

/// Harmonics of the six coordinates of the pose in a sine run, phase zero at the trigger of its first scan.
///
/// # Errors
/// [`AnalysisError::Pose`] and [`AnalysisError::NoSine`].
pub fn pose_harmonics(
    sweep: &Sweep,
    assumptions: &Assumptions,
) -> Result<[Harmonics; 6], AnalysisError> {
    let period_s = 1.0 / f64::from(sweep.rate_hz);
    let group = sweep.group as f64;
    let per_group = sweep.omega * period_s * group;
    let mut poses = RunPoses::new(assumptions, &sweep.name)?;
    let path: Vec<[f64; 6]> = sweep
        .jacks
        .iter()
        .map(|counts| Ok(coordinates(&poses.next(counts)?)))
        .collect::<Result<_, AnalysisError>>()?;
    let fits = Series::fit_all(per_group, path.into_iter());
    let mut fits: [Harmonics; 6] = fits.ok_or_else(|| AnalysisError::NoSine {
        run: sweep.name.clone(),
        channel: "jacks",
        frequency_hz: sweep.sine.frequency_hz,
    })?;
    // A group's mean stands for its middle, and is smaller than the signal there by sin(kωGT/2)/(G·sin(kωT/2)).
    let late_s = (group - 1.0) / 2.0 * period_s + mean_jack_instant_s(&assumptions.board);
    for fit in &mut fits {
        for (k, harmonic) in (1..).zip(&mut fit.harmonics) {
            let half = f64::from(k) * sweep.omega * period_s / 2.0;
            let gain = (half * group).sin() / (group * half.sin());
            *harmonic = of_complex(
                complex(harmonic) * Complex::cis(-f64::from(k) * sweep.omega * late_s) / gain,
            );
        }
    }
    Ok(fits)
}

/// Jacks are converted in six ranks; their pose belongs to the middle of them.
fn mean_jack_instant_s(board: &BoardFacts) -> f64 {
    let instants = (INERTIAL..CHANNELS).map(|channel| board.instant_s(channel));
    instants.sum::<f64>() / JACKS as f64
}

/// Complex amplitude a − i·b of a·cos θ + b·sin θ.
#[must_use]
pub fn complex(harmonic: &Harmonic) -> Complex<f64> {
    Complex::new(harmonic.cosine, -harmonic.sine)
}

fn of_complex(amplitude: Complex<f64>) -> Harmonic {
    Harmonic {
        cosine: amplitude.re,
        sine: -amplitude.im,
    }
}
