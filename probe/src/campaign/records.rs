//! What a campaign notes of the board and of each run.
//!
//! Everything is JSON, written whole or not at all. A run's note is written last, and with it the run is recorded.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use hexsense_client::bounds::{self, MAX_COUNT, MAX_RATE_HZ};
use hexsense_core::channel::CHANNELS;
use hexsense_core::facts::BoardFacts;
use hexsense_core::harmonics::ChannelSums;
use hexsense_core::records::BuildId;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::Drive;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{Campaign, CampaignError, other};
use crate::analysis;
use crate::capture::Capture;
use crate::files::{self, FileError, NOTES};
use crate::known_board;
use crate::plan::{Purpose, Run};

/// What was read from the board before the first run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoardRecord {
    /// Unique id of the microcontroller, in hexadecimal digits.
    pub board: String,
    /// Name of the board and chip.
    pub hardware: String,
    /// Version of the firmware.
    pub firmware: String,
    /// Version of the wire.
    pub wire: u16,
    /// The numbers of this kind of board.
    #[serde(default = "known_board::facts")]
    pub facts: BoardFacts,
    /// Identity of the firmware by its code, in hexadecimal digits; `None` in campaigns of older versions.
    #[serde(default)]
    pub build: Option<String>,
}

impl BoardRecord {
    /// Identity of the firmware.
    #[must_use]
    pub fn build_id(&self) -> Option<BuildId> {
        files::from_hex(self.build.as_deref()?).map(BuildId)
    }
}

/// What is known of a run beside its scans.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Name of the run.
    pub run: String,
    /// SHA-256 of the jack program that was run.
    pub program_sha256: String,
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Scans that the board took at a time.
    pub block: BlockSize,
    /// Identity of the set that was active on the board, in hexadecimal digits.
    pub set: Option<String>,
    /// Scan at which the program seems to have started, to a tenth of a second; `None` for a rest.
    pub onset_scan: Option<u64>,
    /// Scans in the capture.
    pub scans: u64,
    /// Scans that are missing between the first and the last.
    pub scans_lost: u64,
    /// Sums that the board kept, one for each frequency that it was asked for.
    pub board_sums: Vec<BoardSums>,
}

/// Harmonic sums as the board kept them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoardSums {
    /// Frequency and window.
    pub drive: Drive,
    /// Counter of the first scan in the sums.
    pub first_scan: u64,
    /// Sums of each channel, in the order of a scan.
    pub channels: [ChannelSums; CHANNELS],
}

impl RunRecord {
    /// Refuses numbers that no board and no recording have.
    fn check(&self, file: &str) -> Result<(), FileError> {
        let within = |key, value: u64, limit: u64| match value <= limit {
            true => Ok(()),
            false => Err(FileError::value(
                file,
                key,
                value,
                format!("it must be at most {limit}"),
            )),
        };
        if !(1..=MAX_RATE_HZ).contains(&self.rate_hz) {
            let limit = format!("it must be 1 to {MAX_RATE_HZ}");
            return Err(FileError::value(file, "rate_hz", self.rate_hz, limit));
        }
        within("scans", self.scans, MAX_COUNT)?;
        within("scans_lost", self.scans_lost, MAX_COUNT)?;
        within("onset_scan", self.onset_scan.unwrap_or(0), MAX_COUNT)?;
        for sums in &self.board_sums {
            within("board_sums.first_scan", sums.first_scan, MAX_COUNT)?;
            sums.drive.check().map_err(|error| {
                FileError::value(
                    file,
                    "board_sums.drive",
                    format!("{:?}", sums.drive),
                    error.to_string(),
                )
            })?;
        }
        Ok(())
    }
}

impl Campaign {
    /// Whether the campaign was begun with this board, or with none yet.
    ///
    /// # Errors
    /// [`CampaignError::Other`] for another board, [`CampaignError::File`].
    pub fn check_board(&self, board: &BoardRecord) -> Result<(), CampaignError> {
        if !self.folder.join("board.json").exists() {
            return Ok(());
        }
        let noted = self.board()?.board;
        if noted == board.board {
            Ok(())
        } else {
            let what = format!("board {noted}, not with board {}", board.board);
            Err(other(&self.folder, &what))
        }
    }

    /// Whether the runs so far, if there are any, were recorded by this firmware.
    ///
    /// # Errors
    /// [`CampaignError::Other`] for another build, [`CampaignError::File`].
    pub fn check_build(&self, board: &BoardRecord) -> Result<(), CampaignError> {
        let is_recorded = |run: &Run| self.is_recorded(&run.name);
        if !self.plan.runs.iter().any(is_recorded) {
            return Ok(());
        }
        match (self.board()?.build, &board.build) {
            (Some(noted), Some(found)) if noted != *found => {
                let what = format!("the firmware of build {noted}, not with build {found}");
                Err(other(&self.folder, &what))
            }
            _ => Ok(()),
        }
    }

    /// Notes what was read from the board.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn note_board(&self, board: &BoardRecord) -> Result<(), FileError> {
        write_json(&self.folder.join("board.json"), board)
    }

    /// What was noted of the board.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn board(&self) -> Result<BoardRecord, FileError> {
        let path = self.folder.join("board.json");
        let record: BoardRecord = read_json(&path)?;
        bounds::facts(&record.facts).map_err(|error| FileError::Syntax {
            file: path.display().to_string(),
            problem: error.to_string(),
        })?;
        Ok(record)
    }

    /// Length of everything that is recorded to calibrate and to verify, s: what passes at least between the first run
    /// and the last.
    ///
    /// # Errors
    /// Those of [`Campaign::record`].
    pub fn recorded_s(&self) -> Result<f64, CampaignError> {
        let mut seconds = 0.0;
        for run in &self.plan.runs {
            if run.purpose == Purpose::Characterise || !self.is_recorded(&run.name) {
                continue;
            }
            let record = self.record(&run.name)?;
            seconds += (record.scans + record.scans_lost) as f64 / f64::from(record.rate_hz);
        }
        Ok(seconds)
    }

    /// Whether a run is completely recorded.
    #[must_use]
    pub fn is_recorded(&self, run: &str) -> bool {
        self.record_path(run).exists() && self.capture_path(run).exists()
    }

    /// Scans of a run.
    ///
    /// # Errors
    /// [`CampaignError::NotRecorded`] and [`CampaignError::File`].
    pub fn capture(&self, run: &str) -> Result<Capture, CampaignError> {
        self.require(run)?;
        Ok(Capture::load(&self.capture_path(run))?)
    }

    /// A run with its scans, for the analysis.
    ///
    /// # Errors
    /// Those of [`Campaign::capture`] and [`Campaign::record`].
    pub fn recorded(&self, run: &Run) -> Result<analysis::RecordedRun, CampaignError> {
        Ok(analysis::RecordedRun {
            name: run.name.clone(),
            program: run.program(),
            capture: self.capture(&run.name)?,
            rate_hz: self.record(&run.name)?.rate_hz,
            ratiometric: self.sensors.ratiometric(),
        })
    }

    /// What is known of a run beside its scans.
    ///
    /// # Errors
    /// [`CampaignError::NotRecorded`], [`CampaignError::File`], and [`CampaignError::Other`] for a run recorded with
    /// another program than the plan has now.
    pub fn record(&self, run: &str) -> Result<RunRecord, CampaignError> {
        self.require(run)?;
        let path = self.record_path(run);
        let record: RunRecord = read_json(&path)?;
        record.check(&path.display().to_string())?;
        let planned = self.plan.run(run).map(|run| self.program_hash(run));
        if planned.as_ref() != Some(&record.program_sha256) {
            return Err(other(
                &self.folder,
                &format!("run {run} recorded before its plan was changed"),
            ));
        }
        Ok(record)
    }

    /// Completes a run: from now on it counts as recorded.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn note_run(&self, record: &RunRecord) -> Result<(), FileError> {
        write_json(&self.record_path(&record.run), record)
    }

    pub(super) fn record_path(&self, run: &str) -> PathBuf {
        self.folder.join("captures").join(format!("{run}.json"))
    }

    fn require(&self, run: &str) -> Result<(), CampaignError> {
        if self.is_recorded(run) {
            return Ok(());
        }
        let purpose = self.plan.run(run).map(|run| run.purpose);
        Err(CampaignError::NotRecorded {
            folder: self.folder.display().to_string(),
            run: run.to_owned(),
            command: purpose.unwrap_or(Purpose::Calibrate).name(),
        })
    }
}

pub(super) fn remove(path: &Path) -> Result<(), FileError> {
    match fs::remove_file(path) {
        Err(reason) if reason.kind() != ErrorKind::NotFound => Err(FileError::Write {
            file: path.display().to_string(),
            reason,
        }),
        _ => {
            files::sync_folder_of(path);
            Ok(())
        }
    }
}

pub(super) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, FileError> {
    serde_json::from_str(&files::read(path, NOTES)?).map_err(|error| FileError::Syntax {
        file: path.display().to_string(),
        problem: error.to_string(),
    })
}

pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), FileError> {
    let text = serde_json::to_string_pretty(value).map_err(|error| FileError::Write {
        file: path.display().to_string(),
        reason: error.into(),
    })?;
    files::replace(path, &(text + "\n"))
}
