//! Why the machine stops, or cannot be built.

use thiserror::Error;
use unicorn_engine::uc_error;

use super::faults::Halt;
use crate::memory::flash::FlashFileError;
use crate::pins::PinsError;

/// Why the machine cannot go on.
#[derive(Debug, Error)]
pub enum Stop {
    /// The firmware has halted for ever.
    #[error(transparent)]
    Halted(#[from] Box<Halt>),
    /// The twin is gone.
    #[error(transparent)]
    Pins(#[from] PinsError),
    /// A fault of the timeline cut the power.
    #[error("the power was cut at {at_s:.6} s")]
    PowerCut {
        /// True time, s.
        at_s: f64,
    },
    /// The flash file cannot be written.
    #[error("the flash file cannot be written: {0}")]
    FlashFile(std::io::Error),
    /// The emulator reports an error that must not occur.
    #[error("the emulator stopped with {0:?} at PC {1:#010x}")]
    Emulator(uc_error, u32),
}

/// Why the machine cannot be built.
#[derive(Debug, Error)]
pub enum BuildError {
    /// The flash file is unusable.
    #[error(transparent)]
    FlashFile(#[from] FlashFileError),
    /// The emulator refuses.
    #[error("the emulator cannot be set up: {0:?}")]
    Emulator(uc_error),
}

impl From<uc_error> for BuildError {
    fn from(error: uc_error) -> Self {
        Self::Emulator(error)
    }
}
