//! The link at the pace of real time: a TCP socket or a pseudo-terminal that behaves like the serial port of the board's
//! ST-LINK.
//!
//! The machine runs in slices of virtual time, and waits after each until real time has caught up. A host that is not
//! there, or that does not read, loses what the board sends.

use std::ffi::CStr;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::net::TcpListener;
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};
use std::thread;
use std::time::{Duration, Instant};

use super::door::{Door, Host};
use super::link::LinkError;
use crate::machine::Machine;

/// Virtual time that runs between two looks at the host.
const SLICE_S: f64 = 1e-3;
/// Real time may be this far ahead before the board gives up catching up with it.
const MAX_LAG: Duration = Duration::from_millis(200);
/// Bytes on their way to the receiver; a faster host is held back, as the ST-LINK does.
const MAX_BACKLOG: usize = 512;

/// A cable with the host at its far end, or nobody.
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

    /// Runs the machine at the pace of real time, whoever is there.
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
    /// What the host has sent, as far as it fits; zero if there is nothing or nobody.
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
            // Reading a terminal that nobody has opened is an error, which means the same: nothing.
            Self::Pty(pty) => pty.master.read(buffer).unwrap_or(0),
        }
    }

    /// Sends what the host takes; the rest is lost.
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

/// The board's end of a pseudo-terminal.
#[derive(Debug)]
pub struct Pty {
    master: File,
    path: String,
}

impl Pty {
    /// Opens a new pseudo-terminal, raw and non-blocking.
    pub fn open() -> io::Result<Self> {
        // SAFETY: plain calls; the descriptor is checked, and owned from here on.
        let master = unsafe {
            let descriptor = libc::posix_openpt(libc::O_RDWR | libc::O_NOCTTY | libc::O_NONBLOCK);
            check(descriptor)?;
            OwnedFd::from_raw_fd(descriptor)
        };
        // SAFETY: the descriptor is that of a pseudo-terminal's master.
        unsafe {
            check(libc::grantpt(master.as_raw_fd()))?;
            check(libc::unlockpt(master.as_raw_fd()))?;
        }
        let mut name = [0; 128];
        // SAFETY: the buffer is as long as it is said to be.
        let result = unsafe { libc::ptsname_r(master.as_raw_fd(), name.as_mut_ptr(), name.len()) };
        if result != 0 {
            return Err(io::Error::from_raw_os_error(result));
        }
        // SAFETY: on success the buffer holds a string with its end.
        let path = unsafe { CStr::from_ptr(name.as_ptr()) }
            .to_string_lossy()
            .into_owned();
        make_raw(&path)?;
        Ok(Self {
            master: File::from(master),
            path,
        })
    }

    /// Path of the host's end.
    pub fn path(&self) -> &str {
        &self.path
    }
}

/// A serial port carries bytes: no echo, no line editing. The setting outlives the descriptor.
fn make_raw(path: &str) -> io::Result<()> {
    let slave = OpenOptions::new().read(true).write(true).open(path)?;
    // SAFETY: all fields of a termios may be zero, and the calls get a valid descriptor and structure.
    unsafe {
        let mut settings: libc::termios = std::mem::zeroed();
        check(libc::tcgetattr(slave.as_raw_fd(), &raw mut settings))?;
        libc::cfmakeraw(&raw mut settings);
        check(libc::tcsetattr(
            slave.as_raw_fd(),
            libc::TCSANOW,
            &raw const settings,
        ))?;
    }
    Ok(())
}

fn check(result: libc::c_int) -> io::Result<()> {
    if result < 0 {
        Err(io::Error::last_os_error())
    } else {
        Ok(())
    }
}
