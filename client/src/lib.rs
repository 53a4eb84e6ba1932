//! The client of the board's serial protocol.
//!
//! - [`transport`]: bytes through a serial port, a TCP socket, or a virtual board that runs in lockstep.
//! - [`lockstep`]: the last of these.
//! - [`client`]: what the board can be asked.
//! - `conversation`: how answers find their questions, and what happens when one is lost.
//! - [`change`]: what the board does only for whoever has its key.
//! - [`upload`]: a coefficient set on its way to the board and back.
//!
//! Three kinds of failure are three types: what the line did ([`transport::TransportError`]), what the board refused
//! ([`hexsense_core::wire::Refusal`]), and what the host could not make sense of ([`ProtocolError`]).

#![forbid(unsafe_code)]

pub mod change;
pub mod client;
mod conversation;
pub mod lockstep;
mod missing;
pub mod transport;
pub mod upload;

pub use change::ChangeError;
pub use client::Client;
pub use conversation::Contact;
pub use transport::{Transport, TransportError};
pub use upload::UploadError;

use hexsense_core::wire::{Refusal, VERSION};

/// Why the board could not be talked to.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The line failed.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// The board understood and refused.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The line works, but what comes makes no sense or nothing comes.
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
}

impl LinkError {
    /// Whether the board went away or fell silent: it may come back.
    #[must_use]
    pub fn is_loss(&self) -> bool {
        match self {
            Self::Transport(error) => matches!(
                error,
                TransportError::Closed { .. }
                    | TransportError::Failed { .. }
                    | TransportError::Stalled { .. }
            ),
            Self::Protocol(error) => matches!(
                error,
                ProtocolError::Silent { .. } | ProtocolError::NoSamples { .. }
            ),
            Self::Refused(_) => false,
        }
    }
}

/// The line works, but the conversation does not.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ProtocolError {
    /// Nobody answers a hello.
    #[error(
        "{port} opens, but no hexsense board answers on it within {waited_ms} ms; check that it is the board's port, \
         that the board has power, and that nothing else uses the port"
    )]
    NoGreeting {
        /// The port.
        port: String,
        /// How long was waited.
        waited_ms: u64,
    },
    /// Host and board are of different versions.
    #[error(
        "the board's firmware {}.{}.{} speaks wire version {board} and this hexsense speaks version {VERSION}; \
         update {}",
        firmware[0], firmware[1], firmware[2],
        if *board < VERSION { "the board: flash the firmware that belongs to this hexsense" }
        else { "hexsense: install the one that belongs to the firmware" }
    )]
    Version {
        /// Wire version of the board.
        board: u16,
        /// Version of its firmware.
        firmware: [u8; 3],
    },
    /// A request was not answered.
    #[error(
        "the board on {port} has stopped answering ({request}, asked {attempts} times, {waited_ms} ms in all); \
         check cable and power, then start again"
    )]
    Silent {
        /// The port.
        port: String,
        /// What was asked.
        request: &'static str,
        /// How often.
        attempts: u32,
        /// How long was waited in all.
        waited_ms: u64,
    },
    /// The stream of samples stopped.
    #[error(
        "no samples have come from {port} for {waited_ms} ms; check cable and power, then start again"
    )]
    NoSamples {
        /// The port.
        port: String,
        /// How long was waited.
        waited_ms: u64,
    },
    /// An answer that is none.
    #[error(
        "the board's answer to {request} cannot be understood; host and firmware are of different builds: \
         update one of them"
    )]
    Answer {
        /// What was asked.
        request: &'static str,
    },
}
