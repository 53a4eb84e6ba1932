//! Arguments that several commands share.

use std::io::{self, BufReader};
use std::path::PathBuf;
use std::time::{Duration, UNIX_EPOCH};

use clap::Args;
use hexsense_core::wire::change;

use crate::interrupt::Interrupt;
use crate::key_file::{self, KeyFileError};
use crate::motion::{Motion, MotionError, Operator, Twin};
use crate::sensor_file::SensorFile;
use crate::terminal::{OutputError, Screen, say, tell};
use hexsense_client::{Client, LinkError};

/// The board's port.
#[derive(Args)]
pub struct Port {
    /// The board's port: a serial device (such as /dev/ttyACM0 or COM3), tcp:HOST:PORT, or lockstep:HOST:PORT for
    /// a virtual board that runs only while hexsense waits for it
    #[arg(long, value_name = "PORT")]
    pub port: String,
}

impl Port {
    /// Connects to the board.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn open(&self) -> Result<Client, LinkError> {
        Client::open(&self.port)
    }
}

/// What a change of the board and its proof need.
#[derive(Args)]
pub struct Key {
    /// File with the board's key, made by `hexsense provision` [default: hexsense-UNIQUEID.key in the present folder]
    #[arg(long = "key", value_name = "FILE")]
    pub named: Option<PathBuf>,
}

impl Key {
    /// The file with the key of this board.
    #[must_use]
    pub fn file(&self, board: &[u8; 12]) -> PathBuf {
        let named = self.named.clone();
        named.unwrap_or_else(|| key_file::default_of(board))
    }

    /// The key of this board.
    ///
    /// # Errors
    /// [`KeyFileError`].
    pub fn load(&self, board: &[u8; 12]) -> Result<change::Key, KeyFileError> {
        key_file::load(&self.file(board))
    }
}

/// The motion base.
#[derive(Args)]
pub struct Base {
    /// The motion base: a geometry file (TOML) or one of il-96-300, tu-204, an-74tk-200, rexroth_emotion8000,
    /// rexroth_emotion1500
    #[arg(long, value_name = "NAME|FILE")]
    pub geometry: String,
}

/// The scan rate.
#[derive(Args)]
pub struct Scanning {
    /// Scans in a second: 1000, 2000 or 4000
    #[arg(long, value_name = "HZ", default_value_t = 1_000)]
    pub rate: u32,
}

/// How long a board that went away is waited for.
#[derive(Args)]
pub struct Waiting {
    /// How long to wait for a board that was unplugged or fell silent, s; 0 does not wait
    #[arg(long, value_name = "S", default_value_t = 60, value_parser = clap::value_parser!(u64).range(..=86_400))]
    pub board_wait: u64,
}

impl Waiting {
    /// As a length of time.
    #[must_use]
    pub fn time(&self) -> Duration {
        Duration::from_secs(self.board_wait)
    }

    /// The argument as it is typed; empty for the default.
    #[must_use]
    pub fn again(&self) -> String {
        match self.board_wait {
            60 => String::new(),
            seconds => format!(" --board-wait {seconds}"),
        }
    }
}

/// The drive of the base.
#[derive(Args)]
pub struct Controller {
    /// Control address of the twin, which then starts each run; without it hexsense asks a person at the motion controller
    /// to do so
    #[arg(long, value_name = "HOST:PORT")]
    pub twin: Option<String>,
}

impl Controller {
    /// The drive of the base; a question to a person ends with the interrupt.
    ///
    /// # Errors
    /// [`MotionError::Unreachable`].
    pub fn motion(&self, interrupt: &Interrupt) -> Result<Box<dyn Motion>, MotionError> {
        Ok(match &self.twin {
            Some(address) => Box::new(Twin::connect(address)?),
            None => Box::new(Operator::new(
                BufReader::new(io::stdin()),
                Screen,
                interrupt.clone(),
            )),
        })
    }

    /// The argument as it is typed.
    #[must_use]
    pub fn again(&self) -> String {
        let twin = self.twin.as_ref();
        twin.map_or(String::new(), |twin| format!(" --twin {twin}"))
    }
}

/// The date of the campaign.
#[derive(Args)]
pub struct Date {
    /// Date of the campaign: seconds since 1970-01-01 UTC, or a date like 2026-01-31T12:00:00Z [default: now]
    #[arg(long, value_name = "DATE", value_parser = seconds)]
    pub date: Option<u64>,
}

fn seconds(text: &str) -> Result<u64, String> {
    if let Ok(seconds) = text.parse() {
        return Ok(seconds);
    }
    let date = humantime::parse_rfc3339_weak(text).map_err(|error| error.to_string())?;
    date.duration_since(UNIX_EPOCH)
        .map(|since| since.as_secs())
        .map_err(|_| "dates before 1970 are not possible".to_owned())
}

/// Prints the gravity that gains are computed with, and a warning when it may be of another place.
///
/// # Errors
/// [`OutputError`].
pub fn print_gravity(sensors: &SensorFile) -> Result<(), OutputError> {
    say!("gravity: {}", sensors.gravity)?;
    if let Some(warning) = sensors.gravity.warning() {
        tell!("warning: {warning}");
    }
    Ok(())
}
