//! Arguments that several commands share.

use std::path::PathBuf;
use std::time::UNIX_EPOCH;

use clap::Args;
use hexsense::wire::change;

use crate::date;
use crate::key_file::{self, KeyFileError};
use crate::link::{Client, LinkError};
use crate::motion::{Motion, MotionError, Operator, Twin};

/// Where the board is.
#[derive(Args)]
pub struct Port {
    /// Where the board is: a serial device (such as /dev/ttyACM0 or COM3), tcp:HOST:PORT, or lockstep:HOST:PORT for
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

/// What a change of the board needs.
#[derive(Args)]
pub struct Key {
    /// File with the board's key, made by `hexsense provision`
    #[arg(long = "key", value_name = "FILE", default_value = key_file::DEFAULT)]
    pub file: PathBuf,
}

impl Key {
    /// The key.
    ///
    /// # Errors
    /// [`KeyFileError`].
    pub fn load(&self) -> Result<change::Key, KeyFileError> {
        key_file::load(&self.file)
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

/// How fast the board scans.
#[derive(Args)]
pub struct Scanning {
    /// Scans in a second: 1000, 2000 or 4000
    #[arg(long, value_name = "HZ", default_value_t = 1_000)]
    pub rate: u32,
}

/// What a campaign needs beside board and base.
#[derive(Args)]
pub struct Bench {
    #[command(flatten)]
    pub scanning: Scanning,
    /// What the data sheets say of the sensors, the jack transducers and the converter (TOML)
    #[arg(long, value_name = "FILE")]
    pub sensors: PathBuf,
    /// Folder of the campaign: plan, recordings, results. A campaign that broke off goes on in its folder
    #[arg(long, value_name = "FOLDER")]
    pub out: PathBuf,
    /// Control address of the twin, which then starts each run by itself; without it a person at the motion controller
    /// is asked to
    #[arg(long, value_name = "HOST:PORT")]
    pub twin: Option<String>,
    /// Date of the campaign: seconds since 1970-01-01 UTC, or such as 2026-01-31T12:00:00Z [default: now]
    #[arg(long, value_name = "DATE", value_parser = seconds)]
    pub date: Option<u64>,
}

impl Bench {
    /// Who drives the base.
    ///
    /// # Errors
    /// [`MotionError::Unreachable`].
    pub fn motion(&self) -> Result<Box<dyn Motion>, MotionError> {
        Ok(match &self.twin {
            Some(address) => Box::new(Twin::connect(address)?),
            None => Box::new(Operator::new(std::io::stdin().lock(), std::io::stderr())),
        })
    }

    /// Date of the campaign, seconds since 1970-01-01 UTC.
    #[must_use]
    pub fn unix_s(&self) -> u64 {
        self.date.unwrap_or_else(date::now)
    }
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
