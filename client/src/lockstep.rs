//! A virtual board in lockstep: its time goes on only while the host waits for it.
//!
//! The messages on the socket (see docs/virtual-bench.md):
//!
//! ```text
//! host  → board:  run_us u32 | length u32 | bytes for the board's receiver
//! board → host:   now_us u64 | length u32 | bytes from the board's transmitter
//! ```

use std::io::{self, ErrorKind, Read, Write};
use std::time::Duration;

use super::tcp::Socket;
use super::transport::{STALL, Transport, TransportError, is_wait};

/// Longest slice of virtual time that is asked for at once.
const SLICE: Duration = Duration::from_millis(100);
/// Most bytes that are accepted in one answer.
const MAX_ANSWER: u32 = 1 << 20;

/// A virtual board whose time goes on only inside [`Transport::read`].
pub struct Lockstep {
    socket: Socket,
    port: String,
    outgoing: Vec<u8>,
    now: Duration,
    heard: bool,
}

impl Lockstep {
    /// Connects to the virtual board that listens at `address`, the part of `port` behind its scheme.
    pub fn open(port: &str, address: &str) -> Result<Self, TransportError> {
        Ok(Self {
            socket: Socket::connect(port, address)?,
            port: port.to_owned(),
            outgoing: Vec::new(),
            now: Duration::ZERO,
            heard: false,
        })
    }

    /// Lets the board run for `slice` and returns how many bytes it sent.
    fn run(&mut self, slice: Duration, into: &mut Vec<u8>) -> io::Result<usize> {
        let mut request = Vec::with_capacity(8 + self.outgoing.len());
        // A slice is at most 100 ms and a request at most a few frames. The last part of a microsecond is a whole one:
        // in no time nothing would ever happen.
        request.extend_from_slice(&(slice.as_micros() as u32).max(1).to_le_bytes());
        request.extend_from_slice(&(self.outgoing.len() as u32).to_le_bytes());
        request.append(&mut self.outgoing);
        self.socket.write_all(&request)?;
        self.socket.stream.set_read_timeout(Some(STALL))?;
        let (mut now_us, mut length) = ([0; 8], [0; 4]);
        self.socket.read_exact(&mut now_us)?;
        self.heard = true;
        self.socket.read_exact(&mut length)?;
        let length = u32::from_le_bytes(length);
        if length > MAX_ANSWER {
            let problem = format!("an answer of {length} bytes, at most {MAX_ANSWER} are allowed");
            return Err(io::Error::new(ErrorKind::InvalidData, problem));
        }
        self.now = Duration::from_micros(u64::from_le_bytes(now_us));
        let start = into.len();
        into.resize(start + length as usize, 0);
        self.socket.read_exact(&mut into[start..])?;
        Ok(length as usize)
    }
}

impl Transport for Lockstep {
    fn write(&mut self, bytes: &[u8]) -> Result<(), TransportError> {
        self.outgoing.extend_from_slice(bytes);
        Ok(())
    }

    fn read(&mut self, into: &mut Vec<u8>, timeout: Duration) -> Result<(), TransportError> {
        let deadline = self.now + timeout.max(Duration::from_micros(1));
        while self.now < deadline {
            let slice = (deadline - self.now).min(SLICE);
            match self.run(slice, into) {
                Ok(0) => {}
                Ok(_) => return Ok(()),
                Err(error) if is_wait(&error) => {
                    return Err(TransportError::Stalled {
                        port: self.port.clone(),
                    });
                }
                Err(error) if error.kind() == ErrorKind::InvalidData => {
                    return Err(TransportError::NoBoard {
                        port: self.port.clone(),
                        reason: error.to_string(),
                    });
                }
                Err(error) => return Err(self.socket.failure(&self.port, error, self.heard)),
            }
        }
        Ok(())
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn port(&self) -> &str {
        &self.port
    }

    fn is_real_time(&self) -> bool {
        false
    }
}
