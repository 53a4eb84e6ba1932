//! What a campaign finds: results, characteristics and verification.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::records::{read_json, remove, write_json};
use super::{Campaign, CampaignError};
use crate::analysis::{held_out::ChannelVerdict, results::Results};
use crate::board_pose::{self, Difference};
use crate::characteristics::Characteristics;
use crate::files::FileError;

/// How the board came out on the held-out movement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verification {
    /// Its own poses against double precision.
    pub board_pose: BoardPoses,
    /// One verdict for each channel.
    pub channels: Vec<ChannelVerdict>,
}

/// What single precision costs the board's own poses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BoardPoses {
    /// Poses compared.
    pub poses: usize,
    /// Largest distance of O, m.
    pub largest_m: f64,
    /// Largest angle, rad.
    pub largest_rad: f64,
    /// Limit of both.
    pub limit: f64,
}

impl From<Difference> for BoardPoses {
    fn from(difference: Difference) -> Self {
        Self {
            poses: difference.poses,
            largest_m: difference.largest_m,
            largest_rad: difference.largest_rad,
            limit: board_pose::MAX_DIFFERENCE,
        }
    }
}

impl Campaign {
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
    /// [`CampaignError::Unfinished`] and [`CampaignError::File`].
    pub fn results(&self) -> Result<Results, CampaignError> {
        Ok(read_json(&self.finished("results.json")?)?)
    }

    /// Where the coefficient set of a finished campaign is.
    ///
    /// # Errors
    /// [`CampaignError::Unfinished`].
    pub fn coefficients_path(&self) -> Result<PathBuf, CampaignError> {
        self.finished("coefficients.toml")
    }

    fn finished(&self, name: &str) -> Result<PathBuf, CampaignError> {
        let path = self.folder.join(name);
        if path.exists() {
            return Ok(path);
        }
        Err(CampaignError::Unfinished {
            file: path.display().to_string(),
            command: format!("calibrate --resume {}", self.folder.display()),
        })
    }

    /// Writes what the motion system does.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn note_characteristics(&self, found: &Characteristics) -> Result<(), FileError> {
        write_json(&self.folder.join("characteristics.json"), found)
    }

    /// Writes how channels and poses of the board came out on the held-out movement.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn note_verification(&self, verification: &Verification) -> Result<(), FileError> {
        write_json(&self.verification_path(), verification)
    }

    /// How they came out; `None` before the campaign is verified.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn verification(&self) -> Result<Option<Verification>, FileError> {
        let path = self.verification_path();
        path.exists().then(|| read_json(&path)).transpose()
    }

    fn verification_path(&self) -> PathBuf {
        self.folder.join("verification.json")
    }

    /// Makes a run of the plan count as not recorded.
    ///
    /// # Errors
    /// [`CampaignError::NoRun`] and [`FileError::Write`].
    pub fn forget_run(&self, run: &str) -> Result<(), CampaignError> {
        if self.plan.run(run).is_none() {
            let names = self.plan.runs.iter().map(|run| run.name.as_str());
            return Err(CampaignError::NoRun {
                run: run.to_owned(),
                runs: names.collect::<Vec<_>>().join(", "),
            });
        }
        Ok(remove(&self.record_path(run))?)
    }

    /// Makes the campaign count as not verified and its run to verify with as not recorded.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn forget_verification(&self, run: &str) -> Result<(), FileError> {
        remove(&self.verification_path())?;
        remove(&self.record_path(run))
    }
}
