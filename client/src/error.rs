//! Why the board cannot be talked to.

use hexsense_core::wire::{Refusal, VERSION};

use super::transport::TransportError;

/// Why the board cannot be talked to.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The line failed.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// The board understood and refused.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The line works, but nothing comes, or nothing that can be understood.
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
    /// No board answers a hello.
    #[error(
        "{port} opens, but no hexsense board answers on it within {waited_ms} ms; check that it is the board's port, \
         that the board has power, and that no other program uses the port{}",
        if port.starts_with("tcp:") { ". The control port of the twin is for --twin, not for --port" } else { "" }
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
    /// A number that no board can have.
    #[error(
        "the board's {message} cannot be right: {field} is {value}, and it must be {limit}; the board is defective, or \
         something else answers on this port: check which board is connected, and exchange it if it says this again"
    )]
    Impossible {
        /// The message that the number is in.
        message: &'static str,
        /// What the number is.
        field: &'static str,
        /// The number.
        value: String,
        /// What it must be.
        limit: String,
    },
    /// An answer that cannot be decoded, or that answers another request.
    #[error(
        "the board's answer to {request} cannot be understood; host and firmware are of different builds: \
         update one of them"
    )]
    Answer {
        /// What was asked.
        request: &'static str,
    },
}
