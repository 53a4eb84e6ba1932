//! Serial devices, each for one process at a time.
//!
//! The system's exclusive mode (`TIOCEXCL`) does not hold for root, so the port is locked (`flock`) as well. Whether
//! another process has the lock is seen before the port is opened for use: a failed opening would end the exclusive mode of
//! the process that has the port.

use std::fs::File;
#[cfg(unix)]
use std::fs::{OpenOptions, TryLockError};
use std::io;
#[cfg(unix)]
use std::io::ErrorKind;
#[cfg(unix)]
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::time::Duration;

use hexsense_core::wire::hello::BAUD;
use serialport::SerialPort;

use super::stream::{Stream, Wait};
use super::transport::TransportError;
use super::users::{self, PortUser};

/// How long a write may take.
const WRITE: Duration = Duration::from_secs(3);

/// Opens a device.
pub fn open(port: &str) -> Result<Stream<Box<dyn SerialPort>>, TransportError> {
    // It stays open until the port is, so that the modem lines do not change twice.
    let _device = free(port)?;
    let opened = serialport::new(port, BAUD).timeout(WRITE).open();
    let line = opened.map_err(|error| match users::of_device(Path::new(port)) {
        // Another process was faster.
        users if !users.is_empty() => in_use(port, users),
        _ => not_opened(port, error.to_string()),
    })?;
    Ok(Stream::new(line, port))
}

/// The error of a port that does not open, by whether it is there at all.
fn not_opened(port: &str, reason: String) -> TransportError {
    let is_listed = || {
        let ports = serialport::available_ports().unwrap_or_default();
        ports.iter().any(|info| info.port_name == port)
    };
    let is_there = Path::new(port).exists() || is_listed();
    let port = port.to_owned();
    if is_there {
        return TransportError::Unopened { port, reason };
    }
    let ports = ports_here();
    TransportError::Unknown {
        port,
        reason,
        ports,
    }
}

/// Makes sure that no other process has the device, and returns it; `None` where only the opening itself can tell.
#[cfg(unix)]
fn free(port: &str) -> Result<Option<File>, TransportError> {
    let opened = OpenOptions::new()
        .read(true)
        .write(true)
        .custom_flags(libc::O_NOCTTY | libc::O_NONBLOCK)
        .open(port);
    let is_in_use = match &opened {
        Ok(device) => matches!(device.try_lock(), Err(TryLockError::WouldBlock)),
        Err(error) => error.kind() == ErrorKind::ResourceBusy,
    };
    if is_in_use {
        return Err(in_use(port, users::of_device(Path::new(port))));
    }
    // The opening for use takes a lock of its own.
    Ok(opened.ok().filter(|device| device.unlock().is_ok()))
}

/// Other systems give a serial port to one process only.
#[cfg(not(unix))]
fn free(_port: &str) -> Result<Option<File>, TransportError> {
    Ok(None)
}

fn in_use(port: &str, users: Vec<PortUser>) -> TransportError {
    TransportError::InUse {
        port: port.to_owned(),
        users,
    }
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

impl Wait for Box<dyn SerialPort> {
    fn set_wait(&mut self, timeout: Duration) -> io::Result<()> {
        self.set_timeout(timeout).map_err(io::Error::from)
    }
}
