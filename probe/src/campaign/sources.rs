//! What the coefficients of a campaign were found from, and whether that is still what lies beside them.

use std::path::Path;

use sha2::{Digest, Sha256};

use super::{Campaign, CampaignError, capture_path};
use crate::capture::Capture;
use crate::coefficient_file::{Sources, text_digest};
use crate::files::{self, CAPTURE, FileError, SETTINGS};
use crate::geometry_file::GeometryFile;
use crate::plan::programs::jack_program;
use crate::plan::{Plan, Purpose};

impl Campaign {
    /// What the coefficients that are fitted to the recorded runs come from.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn sources(&self) -> Result<Sources, FileError> {
        Ok(Sources {
            captures_sha256: captures_digest(&self.folder, &self.plan)?,
            programs_sha256: programs_digest(&self.plan, &self.geometry),
            geometry_sha256: text_digest(&self.geometry.text),
            sensors_sha256: text_digest(&self.sensors.text),
        })
    }
}

/// Whether the files in `folder` are those that a set was found from; returns in words what could not be looked at because
/// it is not there.
///
/// # Errors
/// [`CampaignError::OtherSource`] for the first that differs, and files that cannot be read.
pub fn check(folder: &Path, sources: &Sources) -> Result<Vec<String>, CampaignError> {
    let mut unseen = Vec::new();
    let sensors = text_beside(folder, "sensors.toml", &mut unseen)?;
    if let Some(sensors) = sensors {
        same(
            folder,
            "sensors.toml",
            &text_digest(&sensors),
            &sources.sensors_sha256,
        )?;
    }
    let geometry = text_beside(folder, "geometry.toml", &mut unseen)?;
    if let Some(geometry) = &geometry {
        same(
            folder,
            "geometry.toml",
            &text_digest(geometry),
            &sources.geometry_sha256,
        )?;
    }
    let plan = text_beside(folder, "plan.toml", &mut unseen)?;
    let Some(plan) = plan else {
        unseen.push("the captures, which the plan names".to_owned());
        return Ok(unseen);
    };
    let plan = Plan::parse(&folder.join("plan.toml").display().to_string(), &plan)?;
    match geometry {
        Some(text) => {
            let geometry =
                GeometryFile::parse(&folder.join("geometry.toml").display().to_string(), &text)?;
            let programs = programs_digest(&plan, &geometry);
            same(folder, "plan.toml", &programs, &sources.programs_sha256)?;
        }
        None => unseen.push(
            "the movements of plan.toml, which the geometry turns into jack programs".to_owned(),
        ),
    }
    let absent = plan
        .runs_to(Purpose::Calibrate)
        .find(|run| !capture_path(folder, &run.name).exists());
    match absent {
        Some(run) => unseen.push(format!(
            "the captures: captures/{}.csv is not there",
            run.name
        )),
        None => {
            let captures = captures_digest(folder, &plan)?;
            same(folder, "captures", &captures, &sources.captures_sha256)?;
        }
    }
    Ok(unseen)
}

/// The text of a file, if it is there.
fn text_beside(
    folder: &Path,
    name: &str,
    unseen: &mut Vec<String>,
) -> Result<Option<String>, FileError> {
    let path = folder.join(name);
    if path.exists() {
        return files::read(&path, SETTINGS).map(Some);
    }
    unseen.push(format!("{name}, which is not there"));
    Ok(None)
}

fn same(folder: &Path, name: &str, found: &str, expected: &str) -> Result<(), CampaignError> {
    if found == expected {
        return Ok(());
    }
    Err(CampaignError::OtherSource {
        file: folder.join(name).display().to_string(),
    })
}

/// Digest of the captures that coefficients are fitted to, as they were recorded: a spreadsheet or git that wrote the
/// same numbers in another way does not change it.
fn captures_digest(folder: &Path, plan: &Plan) -> Result<String, FileError> {
    let mut digest = Sha256::new();
    for run in plan.runs_to(Purpose::Calibrate) {
        let path = capture_path(folder, &run.name);
        let text = files::read(&path, CAPTURE)?;
        let recorded = Capture::as_recorded(&path.display().to_string(), &text)?;
        digest.update(&*recorded);
    }
    Ok(files::hex(&digest.finalize()))
}

/// Digest of the jack programs of the same runs. Runs of the plan that are for something else may change.
fn programs_digest(plan: &Plan, geometry: &GeometryFile) -> String {
    let mut digest = Sha256::new();
    for run in plan.runs_to(Purpose::Calibrate) {
        digest.update(&run.name);
        digest.update(jack_program(run, geometry, plan.period_s));
    }
    files::hex(&digest.finalize())
}
