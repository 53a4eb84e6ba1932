//! The truth of one run as a CSV file, for a later comparison.
//!
//! From the moment the run is commanded until the board is switched off or another run is commanded, every fourth step
//! (500 Hz) becomes a line:
//!
//! | column | meaning |
//! |---|---|
//! | `time_s` | true time since the board was connected |
//! | `fx fy fz` | specific force at the sensor block, body axes, m/s² |
//! | `ex ey ez` | angular acceleration, rad/s² |
//! | `wx wy wz` | angular rate, rad/s |
//! | `jack1_m … jack6_m` | displacement from mid-stroke, m |
//!
//! A number has as many digits as are needed to read the same number back. Each line is one write, so that a killed
//! process leaves whole lines. A run that is commanded again starts the file afresh.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Seek, Write};
use std::path::Path;

use crate::motion::Motion;

/// The header of the file.
pub const HEADER: &str = "time_s,fx,fy,fz,ex,ey,ez,wx,wy,wz,\
                          jack1_m,jack2_m,jack3_m,jack4_m,jack5_m,jack6_m";
/// Steps from line to line.
const STEPS_PER_LINE: u32 = 4;

/// The file and whether it is being written.
#[derive(Debug)]
pub struct TruthLog {
    file: File,
    run: String,
    recording: bool,
    /// Steps since the last line.
    steps: u32,
}

impl TruthLog {
    /// Creates the file for the run of this name, with its header.
    ///
    /// # Errors
    /// The system's, when the file cannot be written.
    pub fn create(path: &Path, run: &str) -> io::Result<Self> {
        let mut log = Self {
            file: File::create(path)?,
            run: run.to_owned(),
            recording: false,
            steps: 0,
        };
        log.begin()?;
        Ok(log)
    }

    /// A run has been commanded.
    ///
    /// # Errors
    /// The system's, when the file cannot be written.
    pub fn run_commanded(&mut self, name: &str) -> io::Result<()> {
        self.recording = name == self.run;
        if self.recording { self.begin() } else { Ok(()) }
    }

    /// The board has been switched off.
    pub fn pins_closed(&mut self) {
        self.recording = false;
    }

    /// Takes the truth of the next step.
    ///
    /// # Errors
    /// The system's, when the file cannot be written.
    pub fn step(&mut self, motion: &Motion) -> io::Result<()> {
        if !self.recording {
            return Ok(());
        }
        self.steps += 1;
        if self.steps < STEPS_PER_LINE {
            return Ok(());
        }
        self.steps = 0;
        self.file.write_all(line(motion).as_bytes())
    }

    fn begin(&mut self) -> io::Result<()> {
        self.steps = 0;
        self.file.set_len(0)?;
        self.file.rewind()?;
        self.file.write_all(format!("{HEADER}\n").as_bytes())
    }
}

fn line(motion: &Motion) -> String {
    let mut text = format!("{:.4}", motion.time_s);
    let felt = motion.felt.triads();
    let values = felt
        .iter()
        .flat_map(|vector| vector.0)
        .chain(motion.jacks.displacement_m);
    for value in values {
        // Writing to a string cannot fail.
        let _ = write!(text, ",{value}");
    }
    text.push('\n');
    text
}
