//! Ctrl-C, and the system's request to end: a recording stops in order instead of being killed.
//!
//! The signal only raises a flag. The recording reads the flag between two blocks, tells the motion controller to bring the
//! base home, stops the stream and leaves the capture readable. A second signal ends hexsense at once. The first one does
//! so too when nothing is recorded; that is safe, because files are replaced whole or not at all.

use std::error::Error;
use std::io;
use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Exit status after a request to stop: the one that a shell reports of Ctrl-C.
pub const STATUS: u8 = 130;

/// A flag that a request to stop raises.
#[derive(Debug, Clone, Default)]
pub struct Interrupt(Arc<AtomicBool>);

/// A request to stop came.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("stopped on request")]
pub struct Interrupted;

impl Interrupt {
    /// An interrupt that Ctrl-C and the system's request to end raise, as long as the returned value lives.
    ///
    /// # Errors
    /// When the system does not let signals be handled.
    pub fn on_signals() -> io::Result<Watched> {
        let interrupt = Self::default();
        let at_once = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order: a signal that finds the second flag down raises it for the next one.
            flag::register_conditional_shutdown(signal, STATUS.into(), Arc::clone(&at_once))?;
            flag::register(signal, Arc::clone(&at_once))?;
            flag::register(signal, Arc::clone(&interrupt.0))?;
        }
        Ok(Watched { interrupt, at_once })
    }

    /// Asks to stop.
    pub fn raise(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    /// Returns an error after a request to stop.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn check(&self) -> Result<(), Interrupted> {
        if self.0.load(Ordering::SeqCst) {
            Err(Interrupted)
        } else {
            Ok(())
        }
    }
}

/// An interrupt that signals raise; when it is dropped, signals end hexsense at once again.
pub struct Watched {
    interrupt: Interrupt,
    at_once: Arc<AtomicBool>,
}

impl Deref for Watched {
    type Target = Interrupt;

    fn deref(&self) -> &Interrupt {
        &self.interrupt
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        self.at_once.store(true, Ordering::SeqCst);
    }
}

/// Turns a file that grows beyond the system's limit into an error that names it. Without this the system ends hexsense
/// without a message.
///
/// # Errors
/// When the system does not let signals be handled.
pub fn hear_of_file_size_limits() -> io::Result<()> {
    #[cfg(unix)]
    flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
    Ok(())
}

/// Whether an error comes from [`Interrupted`].
#[must_use]
pub fn is_behind(error: &(dyn Error + 'static)) -> bool {
    let mut cause = Some(error);
    while let Some(error) = cause {
        if error.is::<Interrupted>() {
            return true;
        }
        cause = error.source();
    }
    false
}
