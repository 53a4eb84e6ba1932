//! Who drives the base: a person at the motion controller, or the twin.
//!
//! The motion controller is a machine of its own. It is given a program file, and at some later moment, by its own
//! clock, it starts. Nothing comes back; when the base moves is seen in the jacks.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::Path;
use std::time::Duration;

use serde::Deserialize;
use serde_json::json;

/// How long the twin may take to answer.
const ANSWER: Duration = Duration::from_secs(4);

/// Drives the base along jack programs.
pub trait Motion {
    /// Makes everything ready for a run at home: may wait for a person.
    ///
    /// # Errors
    /// [`MotionError`].
    fn prepare(&mut self, run: &str, program: Option<&Path>) -> Result<(), MotionError>;

    /// Has the program started, now or within the next seconds.
    ///
    /// # Errors
    /// [`MotionError`].
    fn start(&mut self, run: &str, program: &Path) -> Result<(), MotionError>;

    /// Has the base return home, as far as that can be done from here.
    fn stop(&mut self);
}

/// Why the base does not move as it should.
#[derive(Debug, thiserror::Error)]
pub enum MotionError {
    /// Nobody to ask.
    #[error(
        "run {run} needs a person who loads its program and presses Enter, but standard input is closed; \
         start hexsense in a terminal, or give --twin HOST:PORT"
    )]
    Nobody {
        /// The run.
        run: String,
    },
    /// The twin is not there.
    #[error(
        "cannot reach the twin at {address} ({reason}); is it running, and is that its control address?"
    )]
    Unreachable {
        /// As asked.
        address: String,
        /// What went wrong.
        reason: String,
    },
    /// The twin will not.
    #[error("the motion controller refuses run {run}: {reason}")]
    Refused {
        /// The run.
        run: String,
        /// In the controller's words.
        reason: String,
    },
}

/// A person at a real motion controller.
pub struct Operator<R, W> {
    keyboard: R,
    screen: W,
}

impl<R: BufRead, W: Write> Operator<R, W> {
    /// An operator who reads `screen` and answers on `keyboard`.
    pub fn new(keyboard: R, screen: W) -> Self {
        Self { keyboard, screen }
    }

    /// What cannot be shown is not worth failing for: the next question will find the terminal gone.
    fn say(&mut self, text: &str) {
        let _ = writeln!(self.screen, "{text}");
    }
}

impl<R: BufRead, W: Write> Motion for Operator<R, W> {
    fn prepare(&mut self, run: &str, program: Option<&Path>) -> Result<(), MotionError> {
        self.say(&match program {
            Some(program) => format!(
                "\nRun {run}: load {} into the motion controller.\nBase at home and at rest, people clear? \
                 Press Enter, then start the run when told to.",
                program.display()
            ),
            None => format!("\nRun {run}: leave the base at home and at rest. Press Enter when it is."),
        });
        let mut line = String::new();
        match self.keyboard.read_line(&mut line) {
            Ok(length) if length > 0 => Ok(()),
            _ => Err(MotionError::Nobody {
                run: run.to_owned(),
            }),
        }
    }

    fn start(&mut self, run: &str, _program: &Path) -> Result<(), MotionError> {
        self.say(&format!("Start run {run} NOW at the motion controller."));
        Ok(())
    }

    fn stop(&mut self) {
        self.say("Stop the motion controller and return the base home.");
    }
}

/// The twin's control socket; see docs/virtual-bench.md.
pub struct Twin {
    address: String,
    stream: BufReader<TcpStream>,
}

#[derive(Deserialize)]
struct Answer {
    ok: bool,
    error: Option<String>,
}

impl Twin {
    /// Connects to the control socket at `address`, HOST:PORT.
    ///
    /// # Errors
    /// [`MotionError::Unreachable`].
    pub fn connect(address: &str) -> Result<Self, MotionError> {
        let unreachable = |reason: String| MotionError::Unreachable {
            address: address.to_owned(),
            reason,
        };
        let place = address
            .to_socket_addrs()
            .ok()
            .and_then(|mut places| places.next())
            .ok_or_else(|| unreachable("not an address; write HOST:PORT".to_owned()))?;
        let connect = || {
            let stream = TcpStream::connect_timeout(&place, ANSWER)?;
            stream.set_nodelay(true)?;
            stream.set_read_timeout(Some(ANSWER))?;
            Ok::<_, std::io::Error>(stream)
        };
        let stream = connect().map_err(|error| unreachable(error.to_string()))?;
        Ok(Self {
            address: address.to_owned(),
            stream: BufReader::new(stream),
        })
    }

    fn request(&mut self, run: &str, request: &serde_json::Value) -> Result<(), MotionError> {
        let answer = self
            .exchange(request)
            .map_err(|error| MotionError::Unreachable {
                address: self.address.clone(),
                reason: error.to_string(),
            })?;
        if answer.ok {
            return Ok(());
        }
        let reason = answer.error.unwrap_or_else(|| "no reason given".to_owned());
        Err(MotionError::Refused {
            run: run.to_owned(),
            reason,
        })
    }

    fn exchange(&mut self, request: &serde_json::Value) -> std::io::Result<Answer> {
        let line = format!("{request}\n");
        self.stream.get_mut().write_all(line.as_bytes())?;
        let mut answer = String::new();
        if self.stream.read_line(&mut answer)? == 0 {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        Ok(serde_json::from_str(&answer)?)
    }
}

impl Motion for Twin {
    fn prepare(&mut self, _run: &str, _program: Option<&Path>) -> Result<(), MotionError> {
        Ok(())
    }

    fn start(&mut self, run: &str, program: &Path) -> Result<(), MotionError> {
        // The twin has a working folder of its own.
        let program = program
            .canonicalize()
            .unwrap_or_else(|_| program.to_owned());
        self.request(run, &json!({"run": {"name": run, "program": program}}))
    }

    fn stop(&mut self) {
        // Called when something else has failed already; there is nobody left to tell.
        let _ = self.request("stop", &json!({"stop": true}));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_operator_is_told_what_to_load_and_asked_once() {
        let mut screen = Vec::new();
        let mut operator = Operator::new(&b"\n"[..], &mut screen);
        operator
            .prepare("pitch", Some(Path::new("programs/pitch.csv")))
            .unwrap();
        let nobody = operator.prepare("roll", Some(Path::new("programs/roll.csv")));
        assert!(matches!(nobody, Err(MotionError::Nobody { run }) if run == "roll"));
        assert!(
            String::from_utf8(screen)
                .unwrap()
                .contains("load programs/pitch.csv")
        );
    }
}
