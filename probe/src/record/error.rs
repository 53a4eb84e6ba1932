//! Why a recording broke off.

use hexsense_core::wire::AnalyserState;
use hexsense_core::wire::status::ResetCause;

use super::reconnect::NotBack;
use crate::files::FileError;
use crate::interrupt::Interrupted;
use crate::motion::MotionError;
use hexsense_client::LinkError;

/// Why a recording broke off.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The board or the way to it.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The motion controller.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The capture cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The base does not come to rest.
    #[error(
        "jack {jack} still moves ({moved_mm:.1} mm in a second) after {waited_s} s, so run {run} cannot start; bring \
         the base home, let it come to rest, and check that this transducer is connected"
    )]
    NotAtRest {
        /// The run.
        run: String,
        /// The jack, 1 to 6.
        jack: usize,
        /// How far it moved within a second, mm.
        moved_mm: f64,
        /// How long rest was waited for, s.
        waited_s: f64,
    },
    /// The base rests somewhere else.
    #[error(
        "jack {jack} stands {off_mm:+.1} mm from home before run {run}; bring the base home, and check that geometry \
         file, sensor file and wiring belong to this base"
    )]
    NotAtHome {
        /// The run.
        run: String,
        /// The jack, 1 to 6.
        jack: usize,
        /// How far it is off, mm; positive is longer.
        off_mm: f64,
    },
    /// The base did not move.
    #[error(
        "no jack has moved within {waited_s} s of the start of run {run}; check that the motion controller is \
         enabled and has the right program, and that the jack transducers are wired to the board"
    )]
    NoOnset {
        /// The run.
        run: String,
        /// How long movement was waited for, s.
        waited_s: f64,
    },
    /// The scan counter went back.
    #[error(
        "the board counts scan {scan} after scan {expected}: it has restarted during the run; look at its power, and \
         at `hexsense status` for what it reports"
    )]
    Restarted {
        /// Counter of the scan that came.
        scan: u64,
        /// Counter that was due.
        expected: u64,
    },
    /// The board went away and restarted, and this recording cannot go on across a restart.
    #[error(
        "the board has restarted ({cause:?}) and counts its scans from zero, so this recording cannot go on"
    )]
    RestartedAway {
        /// Why it started.
        cause: ResetCause,
    },
    /// The board went away and is not back.
    #[error(transparent)]
    NotBack(#[from] NotBack),
    /// A number that no recording may hold.
    #[error(
        "{what} of scan {scan} is {value}, which is not a finite number and is not recorded; look at the board's supply and \
         at `hexsense status`, then record again"
    )]
    NotFinite {
        /// What the number is.
        what: &'static str,
        /// Counter of the scan.
        scan: u64,
        /// The number.
        value: f32,
    },
    /// Blocks that do not hold what was asked for.
    #[error(
        "{blocks} blocks in a row do not hold the counts or values that were asked for; the board streams something \
         else: see that no other program has started a stream, then record again"
    )]
    OtherContent {
        /// How many, up to the limit.
        blocks: u32,
    },
    /// A stream that is more gap than recording.
    #[error(
        "{limit} gaps are in the recording, and more are not kept; find out with `hexsense status` why scans are lost, \
         then record again"
    )]
    Gaps {
        /// Most gaps of a recording.
        limit: usize,
    },
    /// The scan counter does not keep up with time.
    #[error(
        "the board counted {scans} scans in {seconds:.0} s, and {rate_hz} were due in each; its clock or its converters \
         fail: look at `hexsense status`, and start the board anew"
    )]
    Slow {
        /// Scans that passed.
        scans: u64,
        /// Time in which they passed, s.
        seconds: f64,
        /// Scans that were due in a second.
        rate_hz: u32,
    },
    /// The board uses other coefficients than at the start.
    #[error("the board's active set changed at scan {scan}; record again")]
    OtherSet {
        /// Counter of the first scan with the other set.
        scan: u64,
    },
    /// The board's sums are not complete.
    #[error(
        "the board's harmonic sums of run {run} at {frequency_hz} Hz are {state:?} at its end, not complete; repeat \
         the run"
    )]
    Sums {
        /// The run.
        run: String,
        /// Drive frequency, Hz.
        frequency_hz: f64,
        /// State of the analyser.
        state: AnalyserState,
    },
    /// A request to stop.
    #[error("{0}")]
    Interrupted(#[from] Interrupted),
}

impl RecordError {
    /// Whether the board went away, fell silent or restarted: it can be waited for.
    #[must_use]
    pub fn is_loss(&self) -> bool {
        match self {
            Self::Link(error) => error.is_loss(),
            Self::Restarted { .. } => true,
            _ => false,
        }
    }
}
