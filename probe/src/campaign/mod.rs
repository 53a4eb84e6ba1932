//! A campaign: one folder with everything that was planned, recorded and found.
//!
//! ```text
//! plan.toml           the movements, see [`crate::plan`]
//! geometry.toml       copy of the geometry file
//! sensors.toml        copy of the sensor file
//! campaign.json       how it was begun, see [`begun`]
//! board.json          what was read from the board
//! programs/NAME.csv   jack programs
//! base.svg            the motion base with the numbers of its jacks (by `hexsense plan`)
//! margins.svg         how much of stroke, speed and acceleration they use (by `hexsense plan`)
//! captures/NAME.csv   scans of a run, see [`crate::capture`]
//! captures/NAME.json  what is known of a run beside its scans
//! coefficients.toml   the coefficient set, see [`crate::coefficient_file`]
//! results.json        the results with their uncertainties, see [`crate::analysis`]
//! characteristics.json
//!                     what the motion system does, see [`crate::characteristics`]
//! verification.json   how the held-out movement came out
//! report.html         all of it for people, see [`crate::report`]
//! ```
//!
//! A run counts as recorded when its `captures/NAME.json` is there, which is written last. A run under way, or one that
//! broke off, is `captures/NAME.csv.part`. A campaign that broke off resumes at the first run that is not recorded.
//!
//! - [`begun`]: how a campaign begins and resumes.
//! - [`records`]: what is noted of the board and of each run.
//! - [`results`]: what is found.
//! - [`sources`]: what the coefficients were found from.

pub mod begun;
mod error;
pub mod records;
pub mod results;
pub mod sources;

use std::fs;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::files::{self, FileError, SETTINGS};
use crate::geometry_file::GeometryFile;
use crate::plan::limits;
use crate::plan::programs::jack_program;
use crate::plan::{Plan, Purpose, Run};
use crate::sensor_file::SensorFile;

pub use begun::{Begun, Given};
pub use error::CampaignError;
pub use records::{BoardRecord, BoardSums, RunRecord};
pub use results::{BoardPoses, Verification};

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
            &files::read(&geometry_path, SETTINGS)?,
        )?;
        let sensors_path = folder.join("sensors.toml");
        let mut campaign = Self {
            folder: folder.to_owned(),
            plan: Plan::load(&folder.join("plan.toml"))?,
            geometry,
            sensors: SensorFile::load(&sensors_path)?,
        };
        if campaign.folder.join("board.json").exists() {
            campaign.sensors.board = campaign.board()?.facts;
        }
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

    /// The first run of this purpose in the plan.
    ///
    /// # Errors
    /// [`CampaignError::NotPlanned`].
    pub fn first_run_to(&self, purpose: Purpose) -> Result<&Run, CampaignError> {
        let mut runs = self.plan.runs_to(purpose);
        runs.next().ok_or_else(|| CampaignError::NotPlanned {
            file: self.folder.join("plan.toml").display().to_string(),
            purpose: purpose.name(),
        })
    }

    /// Where the jack programs of a run are.
    #[must_use]
    pub fn program_path(&self, run: &Run) -> PathBuf {
        program_path(&self.folder, run)
    }

    /// Where the scans of a run are.
    #[must_use]
    pub fn capture_path(&self, run: &str) -> PathBuf {
        capture_path(&self.folder, run)
    }

    /// SHA-256 of a run's jack program.
    #[must_use]
    pub fn program_hash(&self, run: &Run) -> String {
        let text = jack_program(run, &self.geometry, self.plan.period_s);
        files::hex(&Sha256::digest(text))
    }
}

fn capture_path(folder: &Path, run: &str) -> PathBuf {
    folder.join("captures").join(format!("{run}.csv"))
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

/// Whether the file `name` of the folder is absent or has exactly these lines.
fn same_or_absent(folder: &Path, name: &str, what: &str, text: &str) -> Result<(), CampaignError> {
    let path = folder.join(name);
    if path.exists() && !files::read(&path, SETTINGS)?.lines().eq(text.lines()) {
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
