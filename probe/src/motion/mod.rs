//! Who drives the base: a person at the motion controller, or the twin.
//!
//! The motion controller is a machine of its own. It is given a program file, and at some later moment, by its own
//! clock, it starts. Nothing comes back; when the base moves is seen in the jacks.

mod operator;
mod twin;

use std::path::Path;

use crate::interrupt::Interrupted;
pub use operator::Operator;
pub use twin::Twin;

/// Drives the base along jack programs.
pub trait Motion {
    /// Makes everything ready for a run at home: may wait for a person.
    ///
    /// # Errors
    /// [`MotionError`].
    fn prepare(&mut self, run: &str, program: Option<&Path>) -> Result<(), MotionError>;

    /// Has the program started, now or within the next seconds.
    ///
    /// # Errors
    /// [`MotionError`].
    fn start(&mut self, run: &str, program: &Path) -> Result<(), MotionError>;

    /// Has the base return home, as far as that can be done from here.
    fn stop(&mut self);
}

/// Why the base does not move as it should.
#[derive(Debug, thiserror::Error)]
pub enum MotionError {
    /// Nobody to ask.
    #[error(
        "run {run} needs a person who loads its program and presses Enter, but standard input is closed; \
         start hexsense in a terminal, or give --twin HOST:PORT"
    )]
    Nobody {
        /// The run.
        run: String,
    },
    /// The twin is not there.
    #[error(
        "cannot reach the twin at {address} ({reason}); is it running, and is that its control address?"
    )]
    Unreachable {
        /// As asked.
        address: String,
        /// What went wrong.
        reason: String,
    },
    /// The twin will not.
    #[error("the motion controller refuses run {run}: {reason}")]
    Refused {
        /// The run.
        run: String,
        /// In the controller's words.
        reason: String,
    },
    /// Somebody asked to stop before it began.
    #[error("{0}")]
    Interrupted(#[from] Interrupted),
}
