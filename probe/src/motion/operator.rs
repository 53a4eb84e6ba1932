//! A person, who is told what to load and when to start, and answers with Enter.

use std::io::{BufRead, Write};
use std::path::Path;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use super::{Motion, MotionError};
use crate::interrupt::Interrupt;

/// How often the interrupt is looked at while a person is waited for.
const LOOK: Duration = Duration::from_millis(50);

/// A person at a real motion controller.
pub struct Operator<W> {
    /// One message for each line from the keyboard. They are read beside, because a read cannot be interrupted.
    lines: Receiver<()>,
    screen: W,
    interrupt: Interrupt,
}

impl<W: Write> Operator<W> {
    /// An operator who reads `screen` and answers on `keyboard`, or asks to stop.
    pub fn new(keyboard: impl BufRead + Send + 'static, screen: W, interrupt: Interrupt) -> Self {
        let (answer, lines) = mpsc::channel();
        thread::spawn(move || {
            let mut lines = keyboard.lines();
            while let Some(Ok(_)) = lines.next()
                && answer.send(()).is_ok()
            {}
        });
        Self {
            lines,
            screen,
            interrupt,
        }
    }

    /// What cannot be shown is not worth failing for: the next question will find the terminal gone.
    fn say(&mut self, text: &str) {
        let _ = writeln!(self.screen, "{text}");
    }
}

impl<W: Write> Motion for Operator<W> {
    fn prepare(&mut self, run: &str, program: Option<&Path>) -> Result<(), MotionError> {
        self.say(&match program {
            Some(program) => format!(
                "\nRun {run}: load {} into the motion controller.\nBase at home and at rest, people clear? \
                 Press Enter, then start the run when told to.",
                program.display()
            ),
            None => format!("\nRun {run}: leave the base at home and at rest. Press Enter when it is."),
        });
        loop {
            self.interrupt.check()?;
            match self.lines.recv_timeout(LOOK) {
                Ok(()) => return Ok(()),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    let run = run.to_owned();
                    return Err(MotionError::Nobody { run });
                }
            }
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

#[cfg(test)]
mod tests {
    use std::io::{BufReader, Read};

    use super::*;
    use crate::interrupt::Interrupted;

    #[test]
    fn the_operator_is_told_what_to_load_and_asked_once() {
        let mut screen = Vec::new();
        let mut operator = Operator::new(&b"\n"[..], &mut screen, Interrupt::default());
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

    /// A keyboard that nobody touches.
    struct Silent;

    impl Read for Silent {
        fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
            loop {
                thread::park();
            }
        }
    }

    #[test]
    fn a_request_to_stop_is_heard_while_the_operator_is_asked() {
        let interrupt = Interrupt::default();
        let mut operator = Operator::new(BufReader::new(Silent), Vec::new(), interrupt.clone());
        let later = thread::spawn(move || {
            thread::sleep(2 * LOOK);
            interrupt.raise();
        });
        let stopped = operator.prepare("pitch", None);
        assert!(matches!(
            stopped,
            Err(MotionError::Interrupted(Interrupted))
        ));
        later.join().unwrap();
    }
}
