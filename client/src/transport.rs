//! What a way to the board can do, and what goes wrong on it.

use std::io::{self, ErrorKind};
use std::time::Duration;

use super::users::{PortUser, sentence};

/// How long the other end of a socket may take to answer or to take bytes.
pub(super) const STALL: Duration = Duration::from_secs(4);

/// A way to the board.
///
/// Timeouts count by its clock: the host's, or with lockstep the board's, so that what happens does not depend on how fast
/// the virtual board runs.
pub trait Transport {
    /// Sends bytes. With lockstep they leave with the next read.
    ///
    /// # Errors
    /// [`TransportError`].
    fn write(&mut self, bytes: &[u8]) -> Result<(), TransportError>;

    /// Waits until bytes come, at most for `timeout` by this transport's clock, and appends them to `into`.
    ///
    /// # Errors
    /// [`TransportError`]. That nothing comes in time is no error.
    fn read(&mut self, into: &mut Vec<u8>, timeout: Duration) -> Result<(), TransportError>;

    /// Time by this transport's clock.
    fn now(&self) -> Duration;

    /// The port as it was asked for.
    fn port(&self) -> &str;

    /// Whether this transport's clock goes on while no host reads.
    fn is_real_time(&self) -> bool {
        true
    }
}

/// A connection that has ended.
pub(super) struct Ended {
    /// The port that it was to.
    pub port: String,
}

impl Ended {
    fn error(&self) -> TransportError {
        TransportError::Closed {
            port: self.port.clone(),
        }
    }
}

impl Transport for Ended {
    fn write(&mut self, _bytes: &[u8]) -> Result<(), TransportError> {
        Err(self.error())
    }

    fn read(&mut self, _into: &mut Vec<u8>, _timeout: Duration) -> Result<(), TransportError> {
        Err(self.error())
    }

    fn now(&self) -> Duration {
        Duration::ZERO
    }

    fn port(&self) -> &str {
        &self.port
    }
}

/// What went wrong on the line.
#[derive(Debug, thiserror::Error)]
pub enum TransportError {
    /// No such serial device.
    #[error(
        "there is no serial port {port} ({reason}); {}",
        elsewhere(port, ports)
    )]
    Unknown {
        /// As asked.
        port: String,
        /// The system's reason.
        reason: String,
        /// The ports that there are.
        ports: String,
    },
    /// A serial device that is there and does not open.
    #[error(
        "{port} is there but cannot be opened ({reason}); end other programs that use it, and see that this user may use \
         serial ports (on Linux: group dialout)"
    )]
    Unopened {
        /// As asked.
        port: String,
        /// The system's reason.
        reason: String,
    },
    /// Another process uses the port.
    #[error(
        "{port} is in use{}; a board serves one program at a time. Nothing was sent to it: wait until that program \
         ends, or end it",
        sentence(users)
    )]
    InUse {
        /// As asked.
        port: String,
        /// The processes, where the system tells.
        users: Vec<PortUser>,
    },
    /// A socket address that cannot be resolved.
    #[error(
        "{port} is no address; write tcp:HOST:PORT or lockstep:HOST:PORT, for example tcp:localhost:4000"
    )]
    Address {
        /// As asked.
        port: String,
    },
    /// No server listens.
    #[error(
        "cannot connect to {port} ({reason}); is the virtual board running and listening there?"
    )]
    Connect {
        /// As asked.
        port: String,
        /// The system's reason.
        reason: io::Error,
    },
    /// The other end went away.
    #[error(
        "the connection to the board on {port} ended; it lost power, was unplugged or its process stopped"
    )]
    Closed {
        /// The port.
        port: String,
    },
    /// Something else than a virtual board answers.
    #[error(
        "what answers on {port} is no virtual board in lockstep ({reason}). --port takes the port on which the virtual \
         board serves its host; the control port of the twin is for --twin, and its pins are for the virtual board"
    )]
    NoBoard {
        /// The port.
        port: String,
        /// What came.
        reason: String,
    },
    /// Reading or writing failed.
    #[error(
        "the line {port} failed ({reason}); check {}",
        if is_socket(port) { "that the program at its other end still runs" } else { "the cable" }
    )]
    Failed {
        /// The port.
        port: String,
        /// The system's reason.
        reason: io::Error,
    },
    /// A virtual board that does not come to the end of its slice.
    #[error("the virtual board on {port} has not answered for {} s; it hangs or was suspended", STALL.as_secs())]
    Stalled {
        /// The port.
        port: String,
    },
}

/// Whether a port is a socket and no serial device.
pub(super) fn is_socket(port: &str) -> bool {
    port.starts_with("tcp:") || port.starts_with("lockstep:")
}

/// Where to look when there is no such serial port, as the end of a sentence.
fn elsewhere(port: &str, ports: &str) -> String {
    match port.rsplit_once(':') {
        Some((host, number)) if !host.contains('/') && number.parse::<u16>().is_ok() => {
            format!("an address is written tcp:{port} or lockstep:{port}")
        }
        _ => ports.to_owned(),
    }
}

/// Whether an error only says that nothing came in time.
pub(super) fn is_wait(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}

/// The error of a line that worked before.
pub(super) fn failure(port: &str, reason: io::Error) -> TransportError {
    let port = port.to_owned();
    match reason.kind() {
        ErrorKind::UnexpectedEof
        | ErrorKind::BrokenPipe
        | ErrorKind::ConnectionReset
        | ErrorKind::ConnectionAborted => TransportError::Closed { port },
        _ => TransportError::Failed { port, reason },
    }
}
