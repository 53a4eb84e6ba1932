//! Bytes to the board and back, by three ways.
//!
//! | port | way | its clock |
//! |---|---|---|
//! | a device, `/dev/ttyACM0` or `COM3` | serial line at 2 Mbit/s | the host's |
//! | `tcp:HOST:PORT` | the same bytes through a socket | the host's |
//! | `lockstep:HOST:PORT` | a virtual board that runs only while the host waits for it | the board's |
//!
//! With lockstep the clock that timeouts count by is the board's, so what happens does not depend on how fast the
//! virtual board runs.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use hexsense_core::wire::hello::BAUD;
use serialport::SerialPort;

use super::lockstep::Lockstep;

/// How long a connection may take to come about.
const CONNECT: Duration = Duration::from_secs(3);
/// How long the other end of a socket may take to answer or to take bytes.
pub(super) const STALL: Duration = Duration::from_secs(4);

/// A way to the board.
pub trait Transport {
    /// Sends bytes. With lockstep they leave with the next read.
    ///
    /// # Errors
    /// [`TransportError`].
    fn write(&mut self, bytes: &[u8]) -> Result<(), TransportError>;

    /// Waits until bytes come, at most for `timeout` by this transport's clock, and appends them to `into`.
    ///
    /// # Errors
    /// [`TransportError`]; that nothing came in time is none.
    fn read(&mut self, into: &mut Vec<u8>, timeout: Duration) -> Result<(), TransportError>;

    /// Time by this transport's clock.
    fn now(&self) -> Duration;

    /// The port as it was asked for.
    fn port(&self) -> &str;

    /// Whether this transport's clock goes on while nobody reads.
    fn is_real_time(&self) -> bool {
        true
    }
}

/// What went wrong on the line.
#[derive(Debug, thiserror::Error)]
pub enum TransportError {
    /// No such serial device.
    #[error("there is no serial port {port} ({reason}); {ports}")]
    Unknown {
        /// As asked.
        port: String,
        /// The system's reason.
        reason: String,
        /// The ports that there are.
        ports: String,
    },
    /// A socket address that is none.
    #[error(
        "{port} is no address; write tcp:HOST:PORT or lockstep:HOST:PORT, for example tcp:localhost:4000"
    )]
    Address {
        /// As asked.
        port: String,
    },
    /// Nobody listens.
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
    /// Reading or writing failed.
    #[error("the line {port} failed ({reason}); check the cable")]
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

/// Opens a port: a serial device, `tcp:HOST:PORT` or `lockstep:HOST:PORT`.
///
/// # Errors
/// [`TransportError::Unknown`], [`TransportError::Address`] and [`TransportError::Connect`].
pub fn open(port: &str) -> Result<Box<dyn Transport>, TransportError> {
    if let Some(address) = port.strip_prefix("tcp:") {
        let stream = connect(port, address)?;
        return Ok(Box::new(Bytes {
            line: stream,
            port: port.to_owned(),
            start: Instant::now(),
        }));
    }
    if let Some(address) = port.strip_prefix("lockstep:") {
        let stream = connect(port, address)?;
        return Ok(Box::new(Lockstep::new(stream, port)));
    }
    let line = serialport::new(port, BAUD)
        .timeout(CONNECT)
        .open()
        .map_err(|error| TransportError::Unknown {
            port: port.to_owned(),
            reason: error.to_string(),
            ports: ports_here(),
        })?;
    Ok(Box::new(Bytes {
        line,
        port: port.to_owned(),
        start: Instant::now(),
    }))
}

/// The serial ports of this computer, as the end of a sentence.
fn ports_here() -> String {
    let names: Vec<String> = serialport::available_ports()
        .unwrap_or_default()
        .into_iter()
        .map(|info| info.port_name)
        .collect();
    if names.is_empty() {
        "this computer has none at the moment: is the board plugged in?".to_owned()
    } else {
        format!("there are {}", names.join(", "))
    }
}

fn connect(port: &str, address: &str) -> Result<TcpStream, TransportError> {
    let addresses = address
        .to_socket_addrs()
        .map_err(|_| TransportError::Address {
            port: port.to_owned(),
        })?;
    let mut reason = io::Error::from(ErrorKind::AddrNotAvailable);
    for address in addresses {
        match TcpStream::connect_timeout(&address, CONNECT) {
            Ok(stream) => {
                let options = stream
                    .set_nodelay(true)
                    .and_then(|()| stream.set_write_timeout(Some(STALL)));
                return match options {
                    Ok(()) => Ok(stream),
                    Err(reason) => Err(TransportError::Failed {
                        port: port.to_owned(),
                        reason,
                    }),
                };
            }
            Err(error) => reason = error,
        }
    }
    Err(TransportError::Connect {
        port: port.to_owned(),
        reason,
    })
}

/// A line of plain bytes that can wait for a given time.
trait Line: Read + Write {
    fn set_wait(&mut self, timeout: Duration) -> io::Result<()>;
}

impl Line for TcpStream {
    fn set_wait(&mut self, timeout: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(timeout))
    }
}

impl Line for Box<dyn SerialPort> {
    fn set_wait(&mut self, timeout: Duration) -> io::Result<()> {
        self.set_timeout(timeout).map_err(io::Error::from)
    }
}

/// Plain bytes at the pace of real time.
struct Bytes<L> {
    line: L,
    port: String,
    start: Instant,
}

impl<L: Line> Transport for Bytes<L> {
    fn write(&mut self, bytes: &[u8]) -> Result<(), TransportError> {
        let sent = self.line.write_all(bytes).and_then(|()| self.line.flush());
        sent.map_err(|reason| failure(&self.port, reason))
    }

    fn read(&mut self, into: &mut Vec<u8>, timeout: Duration) -> Result<(), TransportError> {
        let mut bytes = [0; 4096];
        let wait = timeout.max(Duration::from_millis(1));
        let received = self
            .line
            .set_wait(wait)
            .and_then(|()| self.line.read(&mut bytes));
        match received {
            Ok(0) => Err(TransportError::Closed {
                port: self.port.clone(),
            }),
            Ok(count) => {
                into.extend_from_slice(&bytes[..count]);
                Ok(())
            }
            Err(error) if is_wait(&error) => Ok(()),
            Err(error) => Err(failure(&self.port, error)),
        }
    }

    fn now(&self) -> Duration {
        self.start.elapsed()
    }

    fn port(&self) -> &str {
        &self.port
    }
}

/// Whether an error only says that nothing came in time.
pub(super) fn is_wait(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}

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
