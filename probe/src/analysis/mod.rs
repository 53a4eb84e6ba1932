//! From captures to coefficients: what `hexsense calibrate` and `hexsense verify` compute.
//!
//! ```text
//! captures ──condense──▶ means of holds, harmonics, jack series
//!                            │            ▲ repeated with each assumption changed by its uncertainty
//!                            ▼            │
//!        assumptions ──▶ estimate ──▶ budget ──▶ results
//! ```
//!
//! - [`assumptions`]: what the files say of base, jacks and site, and how far each number may be off.
//! - [`check`]: a check of a campaign, and its verdict.
//! - [`condense`]: a capture reduced to what the estimate needs, without any assumption.
//! - [`onset`]: where in a capture the movement starts.
//! - [`sines`]: how a sine run is reduced.
//! - [`campaign`]: all captures condensed, sorted by what they are for.
//! - [`poses`]: poses from the jacks under assumptions.
//! - [`estimate`]: offsets, matrices and delays from condensed runs under assumptions.
//! - [`noise`]: the noise of the sensors, from rests.
//! - [`settling`]: what is left of transients.
//! - [`lever_arm`]: the lever arm checked by the second harmonic.
//! - [`budgets`]: how sensitive each result is to each assumption.
//! - [`results`]: the campaign's results with uncertainties, as written to `results.json`, and the coefficient set.
//! - [`filter`]: the zero-phase low-pass filter in front of the comparison on held-out movements.
//! - [`mod@reference`]: what the sensors should feel on a held-out movement, by the pose.
//! - [`held_out`]: calibrated values against the pose of the base on a movement that nothing was fitted to.

pub mod assumptions;
pub mod budgets;
pub mod campaign;
pub mod check;
pub mod condense;
pub mod estimate;
pub mod filter;
pub mod held_out;
pub mod lever_arm;
pub mod noise;
pub mod onset;
pub mod poses;
pub mod reference;
pub mod results;
pub mod settling;
pub mod sines;

use hexsense_core::calibration::triad::TriadError;
use hexsense_core::calibration::zero::ZeroError;
use hexsense_core::channel::Ratiometric;
use hexsense_core::channel::Triad;
use hexsense_core::excitation::Program;
use hexsense_core::kinematics::forward::ForwardError;

use crate::capture::Capture;

/// One recorded run.
#[derive(Debug, Clone)]
pub struct RecordedRun {
    /// Name of the run, as in the plan.
    pub name: String,
    /// What the base was told to do.
    pub program: Program,
    /// What the board sent.
    pub capture: Capture,
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// The channels on which the supply factor does not act.
    pub ratiometric: Ratiometric,
}

/// Why captures do not make a calibration. Nothing has been written.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// A run that the method needs is not there.
    #[error("the campaign has no {run} run; record it, then analyse again")]
    MissingRun {
        /// What is missing.
        run: &'static str,
    },
    /// Scans were lost.
    #[error("run {run}: {missing} scans are missing from scan {scan} on; repeat the run")]
    Gap {
        /// The run.
        run: String,
        /// Counter of the first missing scan.
        scan: u64,
        /// How many are missing.
        missing: u64,
    },
    /// The movement was not found in the jacks.
    #[error(
        "run {run}: the jacks do not follow the program (they fit it to {fit:.0} % at best, at least 90 % is needed); was the right program loaded?"
    )]
    NotFound {
        /// The run.
        run: String,
        /// Share of the program's movement that the jacks show, %.
        fit: f64,
    },
    /// The capture ends before the program.
    #[error("run {run}: the capture ends {missing_s:.1} s before the program does; repeat the run")]
    Short {
        /// The run.
        run: String,
        /// What is missing, s.
        missing_s: f64,
    },
    /// A channel moved during the zero run.
    #[error("zero run, channel {channel}: {source}")]
    Zero {
        /// The channel.
        channel: &'static str,
        /// What is wrong.
        source: ZeroError,
    },
    /// A signal that is not fit to be fitted.
    #[error(
        "run {run}, channel {channel}: no sine of {frequency_hz} Hz could be fitted; is the sensor connected?"
    )]
    NoSine {
        /// The run.
        run: String,
        /// The channel.
        channel: &'static str,
        /// Drive frequency, Hz.
        frequency_hz: f64,
    },
    /// Jack lengths without a pose.
    #[error(
        "run {run}: the jack lengths give no pose: {source}; do geometry file and base belong together?"
    )]
    Pose {
        /// The run.
        run: String,
        /// What is wrong.
        source: ForwardError<f64>,
    },
    /// The geometry changed by its tolerance is no motion base any more.
    #[error(
        "{cause} changed by its tolerance leave no working base: {problem}; check hinge_tolerance in the geometry file"
    )]
    Tolerance {
        /// What was changed.
        cause: &'static str,
        /// What went wrong.
        problem: String,
    },
    /// A triad that does not come out.
    #[error("{triad:?}: {source}")]
    Triad {
        /// The triad.
        triad: Triad,
        /// What is wrong.
        source: TriadError,
    },
    /// The result is not fit to be a coefficient set.
    #[error("the result is not a usable coefficient set: {0}")]
    Record(#[from] hexsense_core::records::RecordError),
}
