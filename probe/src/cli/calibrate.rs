//! `hexsense calibrate`: from the plan to the coefficients.

use clap::Args;
use hexsense::store::{CoefficientSet, MotionBase};

use super::arguments::{Base, Bench, Port};
use super::{report, session};
use crate::analysis;
use crate::analysis::belief::Belief;
use crate::analysis::results::Results;
use crate::campaign::Campaign;
use crate::coefficient_file;
use crate::geometry_file::GeometryFile;
use crate::plan::{Purpose, Run, campaign};
use crate::record::Settings;
use crate::sensor_file::SensorFile;

/// Record a calibration campaign and compute offsets, matrices and their uncertainties.
///
/// Drives the base along the planned movements (`hexsense plan` shows them), records what the board measures, and
/// writes coefficients.toml, results.json and report.html into the campaign's folder. On a real base, load the jack program that
/// hexsense names into the motion controller and start it when told to; with --twin the runs start by themselves.
/// Nothing on the board changes: `hexsense upload` does that.
///
/// In sine runs the board sums up harmonics at the drive frequencies, in blocks of 1 to 32 scans. It would mistake a
/// disturbance at m·RATE/BLOCK ± k·f for harmonic k of the drive f; hexsense takes the largest block that keeps every
/// frequency in lines_hz of the sensor file (default: mains of 50 Hz), with its multiples up to the fifth, off these
/// places. Name there what else is known to disturb: servos, structure, fans. What is not named is not avoided; the
/// coefficients do not depend on it, as they come from the recorded scans.
#[derive(Args)]
pub struct Calibrate {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    base: Base,
    #[command(flatten)]
    bench: Bench,
}

impl Calibrate {
    /// Runs the command.
    ///
    /// # Errors
    /// Files, link, motion controller and analysis.
    pub fn run(self) -> anyhow::Result<()> {
        let campaign = Campaign::prepare(
            &self.bench.out,
            GeometryFile::load(&self.base.geometry)?,
            SensorFile::load(&self.bench.sensors)?,
            |geometry| Ok::<_, anyhow::Error>(campaign::plan(geometry)?),
        )?;
        let base = MotionBase::new(&campaign.geometry.geometry);
        let jacks = Belief::new(&campaign.geometry, &campaign.sensors).jack_coefficients();
        // The board must be able to use them; that is seen before anything moves.
        base.geometry().and_then(|_| jacks.check())?;
        let coefficients = campaign.folder.join("coefficients.toml");
        if coefficients.exists() {
            anyhow::bail!(
                "{} is the result of a finished campaign; choose another folder for a new one",
                coefficients.display()
            );
        }
        let mut client = self.port.open()?;
        let identity = session::ready(&mut client, self.bench.scanning.rate)?;
        let mut motion = self.bench.motion()?;
        campaign.check_board(&session::board_record(&client, &identity))?;
        campaign.write()?;
        campaign.note_board(&session::board_record(&client, &identity))?;
        let runs: Vec<&Run> = campaign.plan.runs_to(Purpose::Calibrate).collect();
        let settings = Settings {
            rate_hz: self.bench.scanning.rate,
            values: false,
        };
        session::record_all(&mut client, motion.as_mut(), &campaign, &runs, settings)?;
        eprintln!("analysing");
        let (recorded, analysis) = session::analyse(&campaign)?;
        let set = CoefficientSet {
            board: identity.board,
            // A geometry file whose name is too long has been refused.
            geometry: campaign
                .geometry
                .name
                .as_str()
                .try_into()
                .unwrap_or_default(),
            geometry_hash: geometry_hash(&campaign.geometry),
            unix_s: self.bench.unix_s(),
            temperature_c: mean_temperature_c(&recorded),
            provenance: campaign.provenance(runs.iter().map(|run| run.name.as_str()))?,
            triads: analysis.triads,
            base,
            jacks,
        };
        print!("{}", table(&analysis.results));
        for warning in &analysis.results.warnings {
            eprintln!("warning: {warning}");
        }
        report::write(&campaign, &set, &recorded, &analysis, None)?;
        campaign.note_results(&analysis.results)?;
        coefficient_file::save(&coefficients, &set)?;
        println!("written: {}", coefficients.display());
        println!(
            "next: hexsense upload --port {} {}",
            self.port.port,
            campaign.folder.display()
        );
        Ok(())
    }
}

/// The part of the geometry file's SHA-256 that a set carries.
fn geometry_hash(geometry: &GeometryFile) -> [u8; 8] {
    let mut hash = [0; 8];
    hash.copy_from_slice(&geometry.hash[..8]);
    hash
}

fn mean_temperature_c(runs: &[analysis::Run]) -> f32 {
    let degrees = runs.iter().flat_map(|run| &run.capture.temperature_c);
    let count = degrees.clone().count().max(1);
    (degrees.map(|degrees| f64::from(*degrees)).sum::<f64>() / count as f64) as f32
}

/// The nine channels as a table.
fn table(results: &Results) -> String {
    let mut text = String::from(
        "\nchannel  offset u0, counts       k, unit per count                    S, counts per unit\n",
    );
    for channel in &results.channels {
        let k = channel.gain.estimate;
        text += &format!(
            "{:<7} {:>9.2} ± {:<8.2}  {:>13.6e} ± {:<9.2e} {:<7}  {:>12.3}\n",
            channel.name,
            channel.offset.estimate,
            channel.offset.expanded_uncertainty,
            k,
            channel.gain.expanded_uncertainty,
            channel.unit,
            channel.sensitivity,
        );
    }
    text + "± is the expanded uncertainty, coverage factor 2\n\n"
}
