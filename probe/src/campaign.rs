//! A campaign: one folder with everything that was planned, recorded and found.
//!
//! ```text
//! plan.toml           the movements, see [`crate::plan`]
//! geometry.toml       copy of the geometry file
//! sensors.toml        copy of the sensor file
//! board.json          what was read from the board
//! programs/NAME.csv   jack programs
//! captures/NAME.csv   scans of a run, see [`crate::capture`]
//! captures/NAME.json  what is known of a run beside its scans
//! coefficients.toml   the coefficient set, see [`crate::coefficient_file`]
//! results.json        the results with their uncertainties, see [`crate::analysis`]
//! verification.json   how the held-out movement came out
//! ```
//!
//! A run counts as recorded when its `captures/NAME.json` is there, which is written last. A campaign that broke off
//! goes on with the first run that is not recorded.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use hexsense::channel::CHANNELS;
use hexsense::harmonics::ChannelSums;
use hexsense::wire::Drive;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::analysis::{self, held_out::ChannelVerdict, results::Results};
use crate::capture::Capture;
use crate::files::{self, FileError};
use crate::geometry_file::{GeometryFile, GeometryFileError};
use crate::plan::limits::{self, BeyondLimit};
use crate::plan::programs::jack_program;
use crate::plan::{Plan, Run};
use crate::sensor_file::SensorFile;

/// A campaign whose plan is checked and whose folder is there.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// The folder.
    pub folder: PathBuf,
    /// The movements.
    pub plan: Plan,
    /// The motion base.
    pub geometry: GeometryFile,
    /// The data sheets.
    pub sensors: SensorFile,
}

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
    /// Scan at which the program seems to have started, to a tenth of a second; `None` for a rest.
    pub onset_scan: Option<u64>,
    /// Scans in the capture.
    pub scans: u64,
    /// Scans that are missing between the first and the last.
    pub scans_lost: u64,
    /// Sums that the board kept at the drive frequency, for runs of a single sine.
    pub board_sums: Option<BoardSums>,
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

/// Why there is no campaign to work with.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A file cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// The copy of the geometry file cannot be used.
    #[error(transparent)]
    Geometry(#[from] GeometryFileError),
    /// The base cannot make a movement.
    #[error("{file}: {reason}")]
    Limits {
        /// The plan.
        file: String,
        /// The movement and its limit.
        reason: BeyondLimit,
    },
    /// The folder belongs to something else.
    #[error("{folder} holds a campaign with {what}; choose another folder for this one")]
    Other {
        /// The folder.
        folder: String,
        /// What differs.
        what: String,
    },
    /// A run is missing.
    #[error("{folder} holds no recording of run {run}; record it with `hexsense {command}`")]
    NotRecorded {
        /// The folder.
        folder: String,
        /// The run.
        run: String,
        /// The command that records it.
        command: &'static str,
    },
}

impl Campaign {
    /// The campaign that `folder` holds, or the one that it shall hold: a plan that is there already is used as it is,
    /// without one `fresh` makes it. Everything is checked and nothing is written; see [`Campaign::write`].
    ///
    /// # Errors
    /// [`CampaignError`]; also what `fresh` refuses.
    pub fn prepare<E: From<CampaignError>>(
        folder: &Path,
        geometry: GeometryFile,
        sensors: SensorFile,
        fresh: impl FnOnce(&GeometryFile) -> Result<Plan, E>,
    ) -> Result<Self, E> {
        let plan_path = folder.join("plan.toml");
        let plan = if plan_path.exists() {
            Plan::load(&plan_path).map_err(CampaignError::from)?
        } else {
            fresh(&geometry)?
        };
        let campaign = Self {
            folder: folder.to_owned(),
            plan,
            geometry,
            sensors,
        };
        campaign.check()?;
        Ok(campaign)
    }

    /// Writes plan, jack programs and the copies of both files into the folder.
    ///
    /// # Errors
    /// [`CampaignError`].
    pub fn write(&self) -> Result<(), CampaignError> {
        Self::write_plan(&self.folder, &self.plan, &self.geometry)?;
        let sensors_path = self.folder.join("sensors.toml");
        Ok(files::replace(&sensors_path, &self.sensors.text)?)
    }

    /// Opens the campaign in `folder`.
    ///
    /// # Errors
    /// Every variant of [`CampaignError`] but `NotRecorded`.
    pub fn open(folder: &Path) -> Result<Self, CampaignError> {
        let geometry_path = folder.join("geometry.toml");
        let geometry = GeometryFile::parse(
            &geometry_path.display().to_string(),
            &files::read(&geometry_path)?,
        )?;
        let sensors_path = folder.join("sensors.toml");
        let campaign = Self {
            folder: folder.to_owned(),
            plan: Plan::load(&folder.join("plan.toml"))?,
            geometry,
            sensors: SensorFile::load(&sensors_path)?,
        };
        campaign.check()?;
        Ok(campaign)
    }

    /// Writes the plan, the geometry and the jack programs of `plan` into `folder`, for an operator to look at.
    ///
    /// # Errors
    /// [`CampaignError`] when `folder` holds another campaign or cannot be written.
    pub fn write_plan(
        folder: &Path,
        plan: &Plan,
        geometry: &GeometryFile,
    ) -> Result<(), CampaignError> {
        same_or_absent(folder, "geometry.toml", "another geometry", &geometry.text)?;
        for subfolder in ["programs", "captures"] {
            make_folder(&folder.join(subfolder))?;
        }
        files::replace(&folder.join("geometry.toml"), &geometry.text)?;
        for run in plan.runs.iter().filter(|run| run.rest_s.is_none()) {
            let text = jack_program(run, geometry, plan.period_s);
            files::replace(&program_path(folder, run), &text)?;
        }
        Ok(files::replace(&folder.join("plan.toml"), &plan.to_toml())?)
    }

    /// Whether plan, base and sensors belong together and to what the folder holds.
    fn check(&self) -> Result<(), CampaignError> {
        let file = self.folder.join("plan.toml").display().to_string();
        if !self.plan.is_for(&self.geometry) {
            return Err(other(&self.folder, "a plan for another geometry file"));
        }
        limits::check(&self.plan, &self.geometry)
            .map_err(|reason| CampaignError::Limits { file, reason })?;
        same_or_absent(
            &self.folder,
            "geometry.toml",
            "another geometry",
            &self.geometry.text,
        )?;
        same_or_absent(
            &self.folder,
            "sensors.toml",
            "another sensor file",
            &self.sensors.text,
        )
    }

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
        read_json(&self.folder.join("board.json"))
    }

    /// Writes the results of the calibration.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn note_results(&self, results: &Results) -> Result<(), FileError> {
        write_json(&self.folder.join("results.json"), results)
    }

    /// The results of the calibration.
    ///
    /// # Errors
    /// [`FileError`], also when there are none yet.
    pub fn results(&self) -> Result<Results, FileError> {
        read_json(&self.folder.join("results.json"))
    }

    /// Writes how the held-out movement came out.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn note_verdicts(&self, verdicts: &[ChannelVerdict]) -> Result<(), FileError> {
        write_json(&self.folder.join("verification.json"), &verdicts)
    }

    /// Length of everything that is recorded, s: what passes at least between the first run and the last.
    ///
    /// # Errors
    /// Those of [`Campaign::record`].
    pub fn recorded_s(&self) -> Result<f64, CampaignError> {
        let mut seconds = 0.0;
        for run in self
            .plan
            .runs
            .iter()
            .filter(|run| self.is_recorded(&run.name))
        {
            let record = self.record(&run.name)?;
            seconds += (record.scans + record.scans_lost) as f64 / f64::from(record.rate_hz);
        }
        Ok(seconds)
    }

    /// Where the jack programs of a run are.
    #[must_use]
    pub fn program_path(&self, run: &Run) -> PathBuf {
        program_path(&self.folder, run)
    }

    /// Where the scans of a run are.
    #[must_use]
    pub fn capture_path(&self, run: &str) -> PathBuf {
        self.folder.join("captures").join(format!("{run}.csv"))
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
    pub fn recorded(&self, run: &Run) -> Result<analysis::Run, CampaignError> {
        Ok(analysis::Run {
            name: run.name.clone(),
            program: run.program(),
            capture: self.capture(&run.name)?,
            rate_hz: self.record(&run.name)?.rate_hz,
        })
    }

    /// What is known of a run beside its scans.
    ///
    /// # Errors
    /// [`CampaignError::NotRecorded`], [`CampaignError::File`], and [`CampaignError::Other`] for a run recorded with
    /// another program than the plan has now.
    pub fn record(&self, run: &str) -> Result<RunRecord, CampaignError> {
        self.require(run)?;
        let record: RunRecord = read_json(&self.record_path(run))?;
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

    /// Makes a run count as not recorded.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn forget(&self, run: &str) -> Result<(), FileError> {
        let path = self.record_path(run);
        match fs::remove_file(&path) {
            Err(reason) if reason.kind() != ErrorKind::NotFound => Err(FileError::Write {
                file: path.display().to_string(),
                reason,
            }),
            _ => Ok(()),
        }
    }

    /// SHA-256 of a run's jack program.
    #[must_use]
    pub fn program_hash(&self, run: &Run) -> String {
        let text = jack_program(run, &self.geometry, self.plan.period_s);
        files::hex(&Sha256::digest(text))
    }

    /// SHA-256 over the capture files of the given runs, in that order.
    ///
    /// # Errors
    /// [`FileError::Read`].
    pub fn provenance<'a>(
        &self,
        runs: impl IntoIterator<Item = &'a str>,
    ) -> Result<[u8; 32], FileError> {
        let mut digest = Sha256::new();
        for run in runs {
            digest.update(files::read(&self.capture_path(run))?);
        }
        Ok(digest.finalize().into())
    }

    fn record_path(&self, run: &str) -> PathBuf {
        self.folder.join("captures").join(format!("{run}.json"))
    }

    fn require(&self, run: &str) -> Result<(), CampaignError> {
        if self.is_recorded(run) {
            return Ok(());
        }
        let verify = self
            .plan
            .run(run)
            .is_some_and(|run| run.purpose == crate::plan::Purpose::Verify);
        Err(CampaignError::NotRecorded {
            folder: self.folder.display().to_string(),
            run: run.to_owned(),
            command: if verify { "verify" } else { "calibrate" },
        })
    }
}

fn program_path(folder: &Path, run: &Run) -> PathBuf {
    folder.join("programs").join(format!("{}.csv", run.name))
}

fn other(folder: &Path, what: &str) -> CampaignError {
    CampaignError::Other {
        folder: folder.display().to_string(),
        what: what.to_owned(),
    }
}

/// Whether the file `name` of the folder is absent or has exactly this text.
fn same_or_absent(folder: &Path, name: &str, what: &str, text: &str) -> Result<(), CampaignError> {
    let path = folder.join(name);
    if path.exists() && files::read(&path)? != text {
        return Err(other(folder, what));
    }
    Ok(())
}

fn make_folder(path: &Path) -> Result<(), FileError> {
    fs::create_dir_all(path).map_err(|reason| FileError::Write {
        file: path.display().to_string(),
        reason,
    })
}

fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, FileError> {
    serde_json::from_str(&files::read(path)?).map_err(|error| FileError::Syntax {
        file: path.display().to_string(),
        problem: error.to_string(),
    })
}

fn write_json(path: &Path, value: &impl Serialize) -> Result<(), FileError> {
    let text = serde_json::to_string_pretty(value).map_err(|error| FileError::Write {
        file: path.display().to_string(),
        reason: error.into(),
    })?;
    files::replace(path, &(text + "\n"))
}
