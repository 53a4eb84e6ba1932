//! Sockets to a virtual board or to a server of serial ports.
//!
//! Such a server has one line to one board, so it serves one host at a time. It closes a second connection at once, before
//! any byte: that is how the second host knows that the port is in use.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::Duration;

use super::stream::{Stream, Wait};
use super::transport::{STALL, TransportError, failure};
use super::users;

/// How long a connection may take to come about.
const CONNECT: Duration = Duration::from_secs(3);

/// A connection, and the address of its other end.
pub struct Socket {
    /// The connection.
    pub stream: TcpStream,
    peer: SocketAddr,
}

/// Opens a socket that carries the bytes of the serial line.
pub fn open(port: &str, address: &str) -> Result<Stream<Socket>, TransportError> {
    Ok(Stream::new(Socket::connect(port, address)?, port))
}

impl Socket {
    /// Connects to `address`, the part of `port` behind its scheme.
    pub fn connect(port: &str, address: &str) -> Result<Self, TransportError> {
        let addresses = address
            .to_socket_addrs()
            .map_err(|_| TransportError::Address {
                port: port.to_owned(),
            })?;
        let mut reason = io::Error::from(ErrorKind::AddrNotAvailable);
        for peer in addresses {
            match TcpStream::connect_timeout(&peer, CONNECT) {
                Ok(stream) => return Self::new(stream, peer).map_err(|e| failure(port, e)),
                Err(error) => reason = error,
            }
        }
        Err(TransportError::Connect {
            port: port.to_owned(),
            reason,
        })
    }

    fn new(stream: TcpStream, peer: SocketAddr) -> io::Result<Self> {
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(STALL))?;
        Ok(Self { stream, peer })
    }

    /// The error when the connection fails; `heard` tells whether the other end has ever sent a byte.
    pub fn failure(&self, port: &str, reason: io::Error, heard: bool) -> TransportError {
        match failure(port, reason) {
            TransportError::Closed { port } if !heard => TransportError::InUse {
                port,
                users: users::of_socket(self.peer),
            },
            error => error,
        }
    }
}

impl Read for Socket {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.stream.read(into)
    }
}

impl Write for Socket {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

impl Wait for Socket {
    fn set_wait(&mut self, timeout: Duration) -> io::Result<()> {
        self.stream.set_read_timeout(Some(timeout))
    }

    fn failure(&self, port: &str, reason: io::Error, heard: bool) -> TransportError {
        self.failure(port, reason, heard)
    }
}
