//! `hexsense calibrate`: from the plan to the coefficients.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{Controller, Date, Port, Waiting, print_gravity};
use super::broken_off::typed;
use super::{progress, report};
use crate::analysis::check::Check;
use crate::analysis::results::Results;
use crate::campaign::{Begun, Campaign, Given};
use crate::coefficient_file;
use crate::evaluation::{Evaluation, EvaluationError, Unfit, base_and_jacks};
use crate::interrupt::Interrupt;
use crate::plan::{Purpose, Run};
use crate::record::board::{board_record, ready};
use crate::record::run::Settings;
use crate::record::sequence::SequenceJob;
use crate::terminal::{self, say, tell};

/// Record a calibration campaign and compute offsets, matrices and their uncertainties.
///
/// Drives the base along the planned movements (`hexsense plan` shows them), records what the board measures, and
/// writes coefficients.toml, results.json, characteristics.json and report.html into the campaign's folder. On a real
/// base, load the jack program that hexsense names into the motion controller, and start it when hexsense says so; with
/// --twin the runs start by themselves. Nothing on the board changes: `hexsense upload` does that.
///
/// In sine runs the board sums up harmonics at the drive frequencies, in blocks of 1 to 32 scans. It would mistake a
/// disturbance at m·RATE/BLOCK ± k·f for harmonic k of the drive f; hexsense takes the largest block that keeps every
/// frequency in lines_hz of the sensor file (default: mains of 50 Hz), with its multiples up to the fifth, off these
/// places. Name every other known disturbance there: servos, structure, fans. A disturbance that is not named is not
/// avoided. The coefficients do not depend on it, because they come from the recorded scans.
///
/// Then it checks whether the bench is what the files say: each jack against its program, the base at home, each sensor
/// against its data sheet. results.json and the report hold every check with its figure and its limit. When a check
/// fails, hexsense says which jack or sensor is at fault, writes no coefficients.toml, and ends with status 3. Mend the
/// bench and record the runs again with --repeat, or accept the check with --accept when you know better.
///
/// A campaign that was begun goes on at its first run that is not complete: with the same command, or with --resume,
/// which takes base, sensors, plan, rate and date from the folder. An argument that is given again must agree with the
/// folder. Ctrl-C stops the run under way: the base is sent home, the board keeps sampling, and hexsense prints the command
/// that records the run again from its start. hexsense waits for a board that is unplugged; when the same board is back,
/// the run is recorded again.
#[derive(Args)]
pub struct Calibrate {
    #[command(flatten)]
    port: Port,
    /// Go on with the campaign in this folder
    #[arg(long, value_name = "FOLDER", conflicts_with = "out")]
    resume: Option<PathBuf>,
    /// The motion base: a geometry file (TOML) or one of il-96-300, tu-204, an-74tk-200, rexroth_emotion8000,
    /// rexroth_emotion1500
    #[arg(long, value_name = "NAME|FILE", required_unless_present = "resume")]
    geometry: Option<String>,
    /// What the data sheets say of the sensors, the jack transducers and the converter (TOML)
    #[arg(long, value_name = "FILE", required_unless_present = "resume")]
    sensors: Option<PathBuf>,
    /// Folder of the campaign: plan, recordings, results. A campaign that broke off goes on in its folder
    #[arg(long, value_name = "FOLDER", required_unless_present = "resume")]
    out: Option<PathBuf>,
    /// Scans in a second: 1000, 2000 or 4000 [default: 1000, or as the campaign was begun]
    #[arg(long, value_name = "HZ")]
    rate: Option<u32>,
    /// Record this run again, although it is complete. May be given several times
    #[arg(long, value_name = "RUN")]
    repeat: Vec<String>,
    /// Accept the failure of a check, with the reason; both stand in results.json and in the report. May be given several
    /// times
    #[arg(long, value_name = "CHECK=REASON", value_parser = accepted)]
    accept: Vec<Accepted>,
    #[command(flatten)]
    controller: Controller,
    #[command(flatten)]
    date: Date,
    #[command(flatten)]
    waiting: Waiting,
}

impl Calibrate {
    /// Runs the command.
    ///
    /// # Errors
    /// Files, link, motion controller and analysis.
    pub fn run(self) -> anyhow::Result<()> {
        let (campaign, begun) = self.campaign()?;
        print_gravity(&campaign.sensors)?;
        campaign.check_complete()?;
        // The board must be able to use them; that is seen before anything moves.
        let (base, jacks) = base_and_jacks(&campaign);
        base.geometry().and_then(|_| jacks.check())?;
        let coefficients = campaign.folder.join("coefficients.toml");
        if coefficients.exists() {
            anyhow::bail!(
                "{} is the result of a finished campaign; choose another folder for a new one",
                coefficients.display()
            );
        }
        for run in &self.repeat {
            campaign.forget_run(run)?;
        }
        let runs: Vec<&Run> = campaign.plan.runs_to(Purpose::Calibrate).collect();
        let (board, has_key) = self.record(&campaign, &begun, &runs)?;
        tell!("analysing");
        let mut evaluation = report::evaluate(&campaign)?;
        self.judge(&campaign, &mut evaluation)?;
        let unix_s = begun.date_unix_s;
        let unix_s = unix_s.unwrap_or_else(hexsense_client::change::unix_now);
        let sources = campaign.sources()?;
        let set = evaluation.coefficient_set(&campaign, &sources, board, unix_s)?;
        let results = &evaluation.analysis.results;
        terminal::print(&table(results))?;
        for warning in &results.warnings {
            tell!("warning: {warning}");
        }
        report::write(&campaign, &set, &evaluation, None)?;
        campaign.note_results(results)?;
        campaign.note_characteristics(&evaluation.characterisation.characteristics)?;
        coefficient_file::save(&coefficients, &set, &sources)?;
        say!("written: {}", coefficients.display())?;
        let port = &self.port.port;
        if !has_key {
            say!("next: hexsense provision --port {port}, for the board has no key yet")?;
        }
        say!(
            "next: hexsense upload --port {port} {}",
            campaign.folder.display()
        )?;
        Ok(())
    }

    /// Prints the checks, and refuses a campaign that fails one which nobody accepts.
    fn judge(&self, campaign: &Campaign, evaluation: &mut Evaluation) -> anyhow::Result<()> {
        let results = &mut evaluation.analysis.results;
        for Accepted { check, reason } in &self.accept {
            if !results.checks.iter().any(|known| known.name == *check) {
                let names = results.checks.iter().map(|known| known.name.as_str());
                let names = names.collect::<Vec<_>>().join(", ");
                anyhow::bail!("--accept: there is no check {check}; there are {names}");
            }
            results.accept(check, reason);
        }
        tell!("{}", checks(&results.checks).trim_end());
        if results.checks.iter().any(Check::is_open) {
            campaign.note_results(results)?;
            return Err(EvaluationError::from(Unfit(results.checks.clone())).into());
        }
        Ok(())
    }

    /// The campaign to begin or to resume.
    fn campaign(&self) -> anyhow::Result<(Campaign, Begun)> {
        let given = Given {
            geometry: self.geometry.clone(),
            sensors: self.sensors.clone(),
            rate_hz: self.rate,
            date_unix_s: self.date.date,
        };
        match (&self.resume, &self.out) {
            (Some(folder), _) => Ok(given.resume(folder)?),
            (None, Some(folder)) => given.begin_or_resume(folder),
            (None, None) => anyhow::bail!("give --out FOLDER, or --resume FOLDER"),
        }
    }

    /// Records the runs that are not recorded yet; returns the unique id of the board, and whether it has a key.
    fn record(
        &self,
        campaign: &Campaign,
        begun: &Begun,
        runs: &[&Run],
    ) -> anyhow::Result<([u8; 12], bool)> {
        let interrupt = Interrupt::on_signals()?;
        let mut client = self.port.open()?;
        let identity = ready(&mut client, begun.rate_hz)?;
        let board = board_record(&client, &identity);
        let has_key = client.status()?.provisioned;
        let mut motion = self.controller.motion(&interrupt)?;
        campaign.check_board(&board)?;
        campaign.write()?;
        if runs.iter().any(|run| !campaign.is_recorded(&run.name)) {
            campaign.check_build(&board)?;
            campaign.note_board(&board)?;
        }
        campaign.note_begun(begun)?;
        let job = SequenceJob {
            campaign,
            runs,
            settings: Settings {
                rate_hz: begun.rate_hz,
                values: false,
            },
            board: identity.board,
            wait: self.waiting.time(),
            interrupt: &interrupt,
        };
        let again = format!(
            "hexsense calibrate --resume {} --port {}{}{}",
            typed(&campaign.folder),
            self.port.port,
            self.controller.again(),
            self.waiting.again(),
        );
        progress::record(&job, &mut client, motion.as_mut(), &again)?;
        Ok((identity.board, has_key))
    }
}

/// A check whose failure is accepted.
#[derive(Debug, Clone)]
struct Accepted {
    check: String,
    reason: String,
}

fn accepted(text: &str) -> Result<Accepted, String> {
    match text.split_once('=') {
        Some((check, reason)) if !reason.trim().is_empty() => Ok(Accepted {
            check: check.trim().to_owned(),
            reason: reason.trim().to_owned(),
        }),
        _ => Err("give CHECK=REASON, for example \"jack gain=scale of the controller\"".to_owned()),
    }
}

/// One line for each check: its name, how it came out, its figure and its limit.
fn checks(checks: &[Check]) -> String {
    let line = |check: &Check| {
        let [statistic, limit] = check.figures();
        format!(
            "{:<20} {:<15} {:>9} of {:>9} {}, {}\n",
            check.name,
            check.verdict.name(),
            statistic,
            limit,
            check.unit,
            check.names.join(" ")
        )
    };
    checks.iter().map(line).collect()
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

#[cfg(test)]
mod tests;
