//! Plain bytes at the pace of real time.

use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use super::transport::{Transport, TransportError, failure, is_wait};

/// Something that carries bytes and can wait for them for a given time.
pub trait Wait: Read + Write {
    /// Sets how long the next read waits at most.
    fn set_wait(&mut self, timeout: Duration) -> io::Result<()>;

    /// The error when the stream fails; `heard` tells whether a byte has ever come.
    fn failure(&self, port: &str, reason: io::Error, _heard: bool) -> TransportError {
        failure(port, reason)
    }
}

/// A transport over such a stream.
pub struct Stream<S> {
    bytes: S,
    port: String,
    start: Instant,
    heard: bool,
}

impl<S: Wait> Stream<S> {
    /// A transport over `bytes`, which was opened as `port`.
    pub fn new(bytes: S, port: &str) -> Self {
        Self {
            bytes,
            port: port.to_owned(),
            start: Instant::now(),
            heard: false,
        }
    }

    fn failure(&self, reason: io::Error) -> TransportError {
        self.bytes.failure(&self.port, reason, self.heard)
    }
}

impl<S: Wait> Transport for Stream<S> {
    fn write(&mut self, bytes: &[u8]) -> Result<(), TransportError> {
        let sent = self.bytes.write_all(bytes);
        sent.and_then(|()| self.bytes.flush())
            .map_err(|reason| self.failure(reason))
    }

    fn read(&mut self, into: &mut Vec<u8>, timeout: Duration) -> Result<(), TransportError> {
        let mut bytes = [0; 4096];
        let wait = timeout.max(Duration::from_millis(1));
        let received = self.bytes.set_wait(wait);
        match received.and_then(|()| self.bytes.read(&mut bytes)) {
            Ok(0) => Err(self.failure(ErrorKind::UnexpectedEof.into())),
            Ok(count) => {
                self.heard = true;
                into.extend_from_slice(&bytes[..count]);
                Ok(())
            }
            Err(error) if is_wait(&error) => Ok(()),
            Err(error) => Err(self.failure(error)),
        }
    }

    fn now(&self) -> Duration {
        self.start.elapsed()
    }

    fn port(&self) -> &str {
        &self.port
    }
}
