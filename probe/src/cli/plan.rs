//! `hexsense plan`: the movements, before anything moves.

use std::path::{Path, PathBuf};

use clap::Args;
use hexsense_core::excitation::{DegreeOfFreedom, Multisine, Signal};

use super::arguments::{Base, print_gravity};
use crate::base_figure;
use crate::campaign::{Campaign, CampaignError};
use crate::files;
use crate::geometry_file::GeometryFile;
use crate::plan::conditioning::MAX_CONDITION;
use crate::plan::forecast::{Forecast, TILT_ERROR_DEG, forecast};
use crate::plan::limits::{self, Checked};
use crate::plan::margins::margins;
use crate::plan::uses::Use;
use crate::plan::{Plan as Movements, Run, campaign};
use crate::sensor_file::SensorFile;
use crate::terminal::{self, one_line, say};

/// Print the movements of a campaign and how much of stroke, speed, acceleration and hinge angles they use; refuse
/// unsafe ones.
///
/// Every movement is as large as its default or as nine tenths of the base's limits allow. To change a movement, write
/// the plan with --out, edit plan.toml, and check it with --plan; `calibrate` uses the plan that its folder holds.
#[derive(Args)]
pub struct Plan {
    #[command(flatten)]
    base: Base,
    /// Check this plan instead of making one
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// What the data sheets say of the sensors, the jack transducers and the converter (TOML); with it the uncertainty
    /// of every gain is predicted
    #[arg(long, value_name = "FILE")]
    sensors: Option<PathBuf>,
    /// Write plan.toml, the jack programs (CSV) and figures of their margins and of the base with the numbers
    /// of its jacks (SVG) into this folder
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

impl Plan {
    /// Runs the command.
    ///
    /// # Errors
    /// Files that cannot be used, and movements that the base cannot make.
    pub fn run(self) -> anyhow::Result<()> {
        let geometry = GeometryFile::load(&self.base.geometry)?;
        let (plan, file) = match &self.plan {
            Some(path) => (Movements::load(path)?, path.display().to_string()),
            None => (campaign::plan(&geometry)?, "the plan".to_owned()),
        };
        if !plan.is_for(&geometry) {
            anyhow::bail!(
                "{file} was made for another geometry file ({}) than {}; make a plan for this one",
                plan.geometry,
                geometry.source
            );
        }
        let checked = limits::check(&plan, &geometry)
            .map_err(|reason| CampaignError::Limits { file, reason })?;
        let sensors = self.sensors.as_deref().map(SensorFile::load).transpose()?;
        let forecast = match &sensors {
            Some(sensors) => Some(forecast(&plan, &geometry, sensors)?),
            None => None,
        };
        terminal::print(&table(&plan, &checked, &geometry))?;
        if let Some(sensors) = &sensors {
            print_gravity(sensors)?;
        }
        if let Some(forecast) = &forecast {
            terminal::print(&format!("\n{}", predicted(forecast)))?;
        }
        if let Some(folder) = &self.out {
            refuse_other_plan(folder, &plan)?;
            Campaign::write_plan(folder, &plan, &geometry)?;
            files::replace(&folder.join("margins.svg"), &margins(&plan, &geometry))?;
            files::replace(&folder.join("base.svg"), &base_figure::page(&geometry))?;
            say!(
                "written: {0}/geometry.toml, {0}/plan.toml, {0}/programs/*.csv, {0}/margins.svg, {0}/base.svg",
                folder.display()
            )?;
        }
        Ok(())
    }
}

fn refuse_other_plan(folder: &Path, plan: &Movements) -> anyhow::Result<()> {
    let path = folder.join("plan.toml");
    if path.exists() && Movements::load(&path)? != *plan {
        anyhow::bail!(
            "{} is another plan already; choose another folder",
            path.display()
        );
    }
    Ok(())
}

fn table(plan: &Movements, checked: &[Checked], geometry: &GeometryFile) -> String {
    let base = &geometry.geometry;
    let mut text = format!(
        "{}: jacks {} to {} m, home at {:.4} m{}{}\n\n\
         run          for          movement                     time     stroke  speed  accel.  hinges  cond(J)\n",
        one_line(&geometry.name),
        base.length_min_m(),
        base.length_max_m(),
        base.home_height_m(),
        geometry
            .speed_max_m_s
            .map_or(String::new(), |v| format!(", at most {v} m/s")),
        geometry
            .acceleration_max_m_s2
            .map_or(String::new(), |a| format!(", {a} m/s²")),
    );
    for (run, checked) in plan.runs.iter().zip(checked) {
        let uses = &checked.uses;
        let lines = movements(run);
        text += &format!(
            "{:<12} {:<12} {:<26} {:>6.1} s  {:>6}  {:>5}  {:>6}  {:>6}  {:>7.2}\n",
            run.name,
            run.purpose.name(),
            lines[0],
            run.duration_s(),
            percent(&uses.length),
            percent(&uses.speed),
            percent(&uses.acceleration),
            checked.hinge.map_or("-".to_owned(), |hinge| {
                format!("{:.0} %", 100.0 * hinge.fraction())
            }),
            checked.conditioning.condition,
        );
        for line in &lines[1..] {
            text += &format!("{:<25} {line}\n", "");
        }
    }
    text + "\n" + &closest(plan, checked) + &worst_held(plan, checked)
}

/// What moves, one line for each degree of freedom; at least one line.
fn movements(run: &Run) -> Vec<String> {
    let mut lines = Vec::new();
    for ramps in &run.ramps {
        let (levels, unit) = match (&ramps.levels_deg, &ramps.levels_m) {
            (Some(levels), _) => (levels.as_slice(), "°"),
            (None, levels) => (levels.as_deref().unwrap_or_default(), " m"),
        };
        let most = levels
            .iter()
            .fold(0.0_f64, |most, level| most.max(level.abs()));
        lines.push(format!("{:?} ramps to ±{most}{unit}", ramps.freedom).to_lowercase());
    }
    for sine in &run.sine {
        let (amplitude, unit) = match sine.amplitude_deg {
            Some(degrees) => (degrees, "°"),
            None => (sine.amplitude_m.unwrap_or_default(), " m"),
        };
        lines.push(
            format!("{:?} {amplitude}{unit}", sine.freedom).to_lowercase()
                + &format!(" at {} Hz", sine.frequency_hz),
        );
    }
    for (freedom, signal) in run.program().signals {
        if let Signal::Multisine(multisine) = signal {
            lines.push(multisine_line(freedom, &multisine));
        }
    }
    if lines.is_empty() {
        lines.push("rest at home".to_owned());
    }
    lines
}

/// How many lines, and how well their phases suit each other.
fn multisine_line(freedom: DegreeOfFreedom, multisine: &Multisine) -> String {
    let (count, crest) = (multisine.lines().len(), multisine.crest_factor());
    format!("{} {count} lines, crest {crest:.2}", freedom.name())
}

/// The gains that the plan determines, and what to do about the plan.
fn predicted(forecast: &Forecast) -> String {
    let mut text = String::new();
    if !forecast.gains.is_empty() {
        text += &format!(
            "predicted expanded uncertainty of the gains (k = 2), by geometry and sensor file; last column: change of \
             the gain\nif the base tilts {TILT_ERROR_DEG}° further on the holds than the jacks say\n\n\
             gain  uncertainty  mostly by                    {TILT_ERROR_DEG}° of tilt\n"
        );
    }
    for gain in &forecast.gains {
        let share = format!("{} {:.2} %", gain.cause.name(), 100.0 * gain.contribution);
        text += &format!(
            "{:<4}  {:>9.2} %  {share:<26}  {:>10.2} %\n",
            gain.channel,
            100.0 * gain.uncertainty,
            100.0 * gain.tilt_change.abs(),
        );
    }
    for advice in &forecast.advice {
        text += &format!("advice: {advice}\n");
    }
    text
}

fn percent(used: &Use) -> String {
    if used.limit.is_infinite() {
        "-".to_owned()
    } else {
        format!("{:.0} %", 100.0 * used.fraction)
    }
}

/// The place of the whole plan that is closest to a limit.
fn closest(plan: &Movements, checked: &[Checked]) -> String {
    let all = plan.runs.iter().zip(checked).flat_map(|(run, checked)| {
        checked
            .uses
            .all()
            .map(|(quantity, used)| (run, quantity, used))
    });
    let worst = all.max_by(|a, b| a.2.fraction.total_cmp(&b.2.fraction));
    let hinges = plan.runs.iter().zip(checked);
    let hinges = hinges.filter_map(|(run, checked)| Some((run, checked.hinge?)));
    let hinge = hinges.max_by(|a, b| a.1.fraction().total_cmp(&b.1.fraction()));
    match (worst, hinge) {
        (Some((.., used)), Some((run, hinge))) if hinge.fraction() > used.fraction => format!(
            "closest to a limit: run {}, jack {} at {:.2} s, {} {:.2}° (limit {}°)\n",
            run.name, hinge.jack, hinge.time_s, hinge.joint, hinge.angle_deg, hinge.limit_deg,
        ),
        (Some((run, quantity, used)), _) => format!(
            "closest to a limit: run {}, jack {} at {:.2} s, {quantity} {:.4} {unit} (limit {:.4} {unit})\n",
            run.name,
            used.jack,
            used.time_s,
            used.value,
            used.limit,
            unit = quantity.unit(),
        ),
        (None, _) => "the plan is empty\n".to_owned(),
    }
}

/// The place of the whole plan where the jacks hold the platform least.
fn worst_held(plan: &Movements, checked: &[Checked]) -> String {
    let all = plan.runs.iter().zip(checked);
    let worst = all.max_by(|a, b| a.1.conditioning.bound.total_cmp(&b.1.conditioning.bound));
    worst.map_or(String::new(), |(run, checked)| {
        let Checked { conditioning, .. } = checked;
        format!(
            "largest cond(J): run {}, {:.2} at {:.2} s, below {:.2} between samples (limit {MAX_CONDITION}); lengths \
             over the mean\nradius of the upper hinges, so that it has no unit\n",
            run.name, conditioning.condition, conditioning.time_s, conditioning.bound,
        )
    })
}

#[cfg(test)]
mod tests;
