//! The pseudo-terminal at the host's end of the cable.

use std::ffi::CStr;
use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};

/// The board's end of a pseudo-terminal.
#[derive(Debug)]
pub struct Pty {
    pub(super) master: File,
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
