//! How a campaign begins and resumes: the arguments of the command line must not change until it is finished.
//!
//! Once a campaign has begun, its folder holds everything that it needs, so it resumes from the folder alone. An argument
//! that is given again must agree with the folder.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::records::{read_json, write_json};
use super::{Campaign, CampaignError};
use crate::files::FileError;
use crate::geometry_file::GeometryFile;
use crate::plan::{campaign, needs};
use crate::sensor_file::SensorFile;

/// Scan rate unless another is given, Hz.
pub const DEFAULT_RATE_HZ: u32 = 1_000;

/// How a campaign was begun, beside what its other files hold.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Begun {
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Date of the campaign, seconds since 1970-01-01 UTC; `None` where none was given.
    pub date_unix_s: Option<u64>,
}

/// What the command line says of a campaign.
#[derive(Debug, Clone, Default)]
pub struct Given {
    /// Preset or file of the geometry.
    pub geometry: Option<String>,
    /// The sensor file.
    pub sensors: Option<PathBuf>,
    /// Scan rate, Hz.
    pub rate_hz: Option<u32>,
    /// Date, seconds since 1970-01-01 UTC.
    pub date_unix_s: Option<u64>,
}

impl Given {
    /// The campaign that was begun in `folder`, or the one that shall begin there. Nothing is written.
    ///
    /// # Errors
    /// As [`Given::resume`]; for a new one also files that were not given, and a base that has no room to move.
    pub fn begin_or_resume(&self, folder: &Path) -> anyhow::Result<(Campaign, Begun)> {
        if begun_path(folder).exists() {
            return Ok(self.resume(folder)?);
        }
        let (Some(geometry), Some(sensors)) = (&self.geometry, &self.sensors) else {
            return Err(not_begun(folder).into());
        };
        let campaign = Campaign::prepare(
            folder,
            GeometryFile::load(geometry)?,
            SensorFile::load(sensors)?,
            |geometry| Ok::<_, anyhow::Error>(campaign::plan(geometry)?),
        )?;
        let begun = Begun {
            rate_hz: self.rate_hz.unwrap_or(DEFAULT_RATE_HZ),
            date_unix_s: self.date_unix_s,
        };
        Ok((campaign, begun))
    }

    /// The campaign that was begun in `folder`, with everything from there.
    ///
    /// # Errors
    /// [`CampaignError::NotBegun`], [`CampaignError::Contradiction`] for what was given and is not what the folder
    /// holds, and a folder that cannot be used.
    pub fn resume(&self, folder: &Path) -> Result<(Campaign, Begun), CampaignError> {
        let path = begun_path(folder);
        if !path.exists() {
            return Err(not_begun(folder));
        }
        let begun: Begun = read_json(&path)?;
        let campaign = Campaign::open(folder)?;
        self.check(&campaign, &begun)?;
        Ok((campaign, begun))
    }

    /// Refuses arguments that do not agree with the folder.
    fn check(&self, campaign: &Campaign, begun: &Begun) -> Result<(), CampaignError> {
        let contradiction = |given: String, held: String| {
            Err(CampaignError::Contradiction {
                given,
                folder: campaign.folder.display().to_string(),
                held,
            })
        };
        if let Some(name) = &self.geometry
            && GeometryFile::load(name)?.text != campaign.geometry.text
        {
            let held = format!("{} (geometry.toml)", campaign.geometry.name);
            return contradiction(format!("--geometry {name}"), held);
        }
        if let Some(path) = &self.sensors
            && SensorFile::load(path)?.text != campaign.sensors.text
        {
            let held = "another sensor file (sensors.toml)".to_owned();
            return contradiction(format!("--sensors {}", path.display()), held);
        }
        if let Some(rate) = self.rate_hz.filter(|rate| *rate != begun.rate_hz) {
            let held = format!("--rate {}", begun.rate_hz);
            return contradiction(format!("--rate {rate}"), held);
        }
        match self.date_unix_s {
            Some(date) if begun.date_unix_s != Some(date) => {
                let held = begun
                    .date_unix_s
                    .map_or("no --date".to_owned(), |held| format!("--date {held}"));
                contradiction(format!("--date {date}"), held)
            }
            _ => Ok(()),
        }
    }
}

impl Campaign {
    /// Whether the plan has every run that coefficients are fitted to.
    ///
    /// # Errors
    /// [`CampaignError::Incomplete`].
    pub fn check_complete(&self) -> Result<(), CampaignError> {
        let missing = needs::missing_to_calibrate(&self.plan);
        if missing.is_empty() {
            return Ok(());
        }
        Err(CampaignError::Incomplete {
            file: self.folder.join("plan.toml").display().to_string(),
            what: missing.join("; "),
        })
    }

    /// Notes how the campaign was begun: from now on it can resume.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn note_begun(&self, begun: &Begun) -> Result<(), FileError> {
        write_json(&begun_path(&self.folder), begun)
    }
}

fn begun_path(folder: &Path) -> PathBuf {
    folder.join("campaign.json")
}

fn not_begun(folder: &Path) -> CampaignError {
    CampaignError::NotBegun {
        folder: folder.display().to_string(),
    }
}
