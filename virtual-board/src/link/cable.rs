//! The link at the pace of real time: a TCP socket or a pseudo-terminal that behaves like the serial port of the board's
//! ST-LINK.
//!
//! The machine runs in slices of virtual time, and waits after each until real time has caught up. What the board sends
//! is lost if no host is connected, or if the host does not read.

use std::io::{self, Read, Write};
use std::net::TcpListener;
use std::thread;
use std::time::{Duration, Instant};

use super::door::{Door, Host};
use super::error::LinkError;
use super::pty::Pty;
use crate::machine::Machine;

/// Virtual time between two exchanges with the host.
const SLICE_S: f64 = 1e-3;
/// Greatest lag behind real time; beyond it the board gives up catching up.
const MAX_LAG: Duration = Duration::from_millis(200);
/// Bytes on their way to the receiver; a faster host is held back, as the ST-LINK does.
const MAX_BACKLOG: usize = 512;

/// A cable, with or without a host at its far end.
#[derive(Debug)]
pub struct Cable {
    end: End,
}

#[derive(Debug)]
enum End {
    Tcp { door: Door, host: Option<Host> },
    Pty(Pty),
}

impl Cable {
    /// Hosts connect to this listener.
    pub fn over_tcp(listener: TcpListener) -> io::Result<Self> {
        Ok(Self {
            end: End::Tcp {
                door: Door::new(listener)?,
                host: None,
            },
        })
    }

    /// Hosts open this terminal.
    pub fn over_pty(pty: Pty) -> Self {
        Self { end: End::Pty(pty) }
    }

    /// Runs the machine at the pace of real time, with or without a host.
    pub fn serve(mut self, machine: &mut Machine) -> Result<std::convert::Infallible, LinkError> {
        let mut started = Instant::now();
        let mut run_s = 0.0;
        loop {
            let mut buffer = [0; MAX_BACKLOG];
            let room = MAX_BACKLOG.saturating_sub(machine.bus().lpuart.line_backlog());
            let received = self.end.receive(&mut buffer[..room]);
            machine.bus_mut().line_in(&buffer[..received]);
            machine.run(machine.bus().now_s() + SLICE_S)?;
            let sent = machine.bus_mut().lpuart.take_sent();
            self.end.send(&sent);
            run_s += SLICE_S;
            let due = started + Duration::from_secs_f64(run_s);
            let now = Instant::now();
            if due > now {
                thread::sleep(due - now);
            } else if now - due > MAX_LAG {
                (started, run_s) = (now, 0.0);
            }
        }
    }
}

impl End {
    /// Reads the bytes of the host into the buffer; zero if there are none, or no host.
    fn receive(&mut self, buffer: &mut [u8]) -> usize {
        match self {
            Self::Tcp { door, host } => {
                if host.is_none() {
                    *host = door.look().filter(|host| {
                        host.set_nonblocking(true).is_ok() && host.set_nodelay(true).is_ok()
                    });
                }
                let Some(stream) = host.as_mut().filter(|_| !buffer.is_empty()) else {
                    return 0;
                };
                match stream.read(buffer) {
                    Ok(0) => {
                        *host = None;
                        0
                    }
                    Ok(count) => count,
                    Err(error) if error.kind() == io::ErrorKind::WouldBlock => 0,
                    Err(_) => {
                        *host = None;
                        0
                    }
                }
            }
            // Reading a terminal that is not open is an error, which means the same: no bytes.
            Self::Pty(pty) => pty.master.read(buffer).unwrap_or(0),
        }
    }

    /// Sends as many bytes as the host takes; the rest is lost.
    fn send(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            let written = match self {
                Self::Tcp {
                    host: Some(stream), ..
                } => stream.write(bytes),
                Self::Tcp { host: None, .. } => return,
                Self::Pty(pty) => pty.master.write(bytes),
            };
            match written {
                Ok(count) if count > 0 => bytes = &bytes[count..],
                _ => return,
            }
        }
    }
}
