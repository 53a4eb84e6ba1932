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
/// Most bytes that are accepted at a time: the line carries 20,000 in the longest slice, and a virtual board stops at
/// 4,096.
const MAX_ANSWER: u32 = 1 << 16;
/// Most bytes in a microsecond beyond that, five times what the line carries.
const MAX_PER_US: u64 = 1;

/// A virtual board whose time goes on only inside [`Transport::read`].
pub struct Lockstep {
    socket: Socket,
    port: String,
    outgoing: Vec<u8>,
    now: Duration,
    /// Bytes that came faster than [`MAX_PER_US`].
    ahead: u64,
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
            ahead: 0,
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
        self.socket.read_exact(&mut length)?;
        let length = u32::from_le_bytes(length);
        if length > MAX_ANSWER {
            let most = format!("at most {MAX_ANSWER} are allowed");
            return Err(invalid(format!("an answer of {length} bytes, {most}")));
        }
        let now = Duration::from_micros(u64::from_le_bytes(now_us));
        self.set_time(now, slice, length)?;
        let start = into.len();
        into.resize(start + length as usize, 0);
        self.socket.read_exact(&mut into[start..])?;
        Ok(length as usize)
    }

    /// Takes the board's time after a slice. It must go on, because timeouts count by it: without a byte the board has run
    /// the whole slice, and bytes come no faster than a line carries them.
    fn set_time(&mut self, now: Duration, slice: Duration, bytes: u32) -> io::Result<()> {
        let least = if bytes == 0 {
            slice / 2
        } else {
            Duration::ZERO
        };
        let went = now.checked_sub(self.now).filter(|went| *went >= least);
        let Some(went) = went else {
            let before = self.now;
            return Err(invalid(format!(
                "its time goes from {before:?} to {now:?} in {slice:?}"
            )));
        };
        let carried = u64::try_from(went.as_micros()).unwrap_or(u64::MAX);
        let carried = carried.saturating_mul(MAX_PER_US);
        self.ahead = self.ahead.saturating_sub(carried) + u64::from(bytes);
        if self.ahead > MAX_ANSWER.into() {
            let ahead = self.ahead;
            return Err(invalid(format!(
                "{ahead} bytes more than the line carries in its time"
            )));
        }
        (self.now, self.heard) = (now, true);
        Ok(())
    }
}

fn invalid(problem: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, problem)
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

#[cfg(test)]
mod tests {
    use std::net::TcpListener;
    use std::thread;

    use super::*;

    /// What the host makes of a board that answers so for ever: time, and bytes.
    fn read(answer: impl Fn(u64) -> (u64, u32) + Send + 'static) -> TransportError {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            let mut request = [0; 8];
            for number in 0.. {
                if stream.read_exact(&mut request).is_err() {
                    break;
                }
                let (now_us, length) = answer(number);
                let bytes = vec![1; length as usize];
                let head = [&now_us.to_le_bytes()[..], &length.to_le_bytes()];
                if stream
                    .write_all(&[&head.concat()[..], &bytes].concat())
                    .is_err()
                {
                    break;
                }
            }
        });
        let mut line = Lockstep::open("lockstep:board", &address).unwrap();
        let mut into = Vec::new();
        loop {
            if let Err(error) = line.read(&mut into, Duration::from_secs(1)) {
                return error;
            }
            assert!(into.len() < 1 << 20, "{} bytes", into.len());
        }
    }

    #[test]
    fn a_board_whose_time_does_not_go_on_is_none() {
        for (answer, told) in [
            (
                (|_| (0, 0)) as fn(u64) -> (u64, u32),
                "time goes from 0ns to 0ns",
            ),
            (|number| (1_000_000 - 100_000 * number, 0), "to 900ms"),
            (|number| (number, 0), "in 100ms"),
            (|_| (0, 4_096), "bytes more than the line carries"),
            (|number| (number, 64), "bytes more than the line carries"),
            (|_| (100_000, 65_537), "an answer of 65537 bytes"),
        ] {
            let error = read(answer).to_string();
            assert!(error.contains(told), "{told}: {error}");
        }
    }
}
