//! `hexsense verify`: the stored coefficients on a movement that they were not fitted to.

use std::path::PathBuf;

use clap::Args;
use hexsense_core::records::{CoefficientSet, SetId};
use hexsense_core::wire::PoseReport;

use super::arguments::{Base, Controller, Date, Key, Port, Scanning, Waiting};
use super::broken_off::same_again;
use super::proven::Proven;
use super::{progress, report};
use crate::analysis::held_out::{self, ChannelVerdict};
use crate::board_pose::{self, Difference, MAX_DIFFERENCE};
use crate::campaign::{Campaign, Verification};
use crate::capture::Capture;
use crate::coefficient_file;
use crate::evaluation::check_sums;
use crate::geometry_file::GeometryFile;
use crate::interrupt::Interrupt;
use crate::plan::{Purpose, Run};
use crate::record::board::{board_record, ready};
use crate::record::run::Settings;
use crate::record::sequence::SequenceJob;
use crate::replay::{WrongValues, first_wrong_values};
use crate::report::Verified;
use crate::sensor_file::SensorFile;
use crate::terminal::{self, say, tell};
use hexsense_client::Client;

/// Prove the board's coefficients on a movement that they were not fitted to.
///
/// Drives the first run of the plan whose purpose is to verify (by default all six degrees of freedom at once), lets
/// the board calibrate while it samples, and compares with what the jacks say. Writes verification.json and completes
/// report.html. The movement is recorded again each time. --out is the folder of the campaign that the coefficients came
/// from. The command fails when the error of a channel is over 3 % of its signal, when a mean error is outside its
/// uncertainty, and when a pose of the board differs by more than 5e-7 m or rad from the pose that double precision finds
/// from the same counts. With its key at hand the board first proves that it is the board, and nothing moves when it cannot.
#[derive(Args)]
pub struct Verify {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    key: Key,
    #[command(flatten)]
    base: Base,
    #[command(flatten)]
    scanning: Scanning,
    /// What the data sheets say of the sensors, the jack transducers and the converter (TOML)
    #[arg(long, value_name = "FILE")]
    sensors: PathBuf,
    /// Folder of the campaign that the coefficients came from
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    #[command(flatten)]
    controller: Controller,
    #[command(flatten)]
    date: Date,
    #[command(flatten)]
    waiting: Waiting,
}

impl Verify {
    /// Runs the command.
    ///
    /// # Errors
    /// Files, link, motion controller, analysis, and channels that do not pass.
    pub fn run(self) -> anyhow::Result<()> {
        let campaign = Campaign::prepare(
            &self.out,
            GeometryFile::load(&self.base.geometry)?,
            SensorFile::load(&self.sensors)?,
            |_| {
                Err(anyhow::anyhow!(
                    "{} holds no campaign; verify needs the folder that the coefficients came from",
                    self.out.display()
                ))
            },
        )?;
        let run = campaign.first_run_to(Purpose::Verify)?;
        let (ours, _) = coefficient_file::load(&campaign.folder.join("coefficients.toml"))?;
        let (mut client, id) = self.record(&campaign, run, &ours)?;
        let poses = check_poses(&campaign, run, &client.take_poses(), &ours, id)?;
        let date = self
            .date
            .date
            .unwrap_or_else(hexsense_client::change::unix_now);
        let since_set_s = date.saturating_sub(ours.unix_s) as f64;
        let elapsed_s = since_set_s + campaign.recorded_s()?;
        judge(&campaign, run, &ours, poses, elapsed_s)
    }

    /// Records the movement; returns the client of the board, and the identity of its set.
    fn record(
        &self,
        campaign: &Campaign,
        run: &Run,
        ours: &CoefficientSet,
    ) -> anyhow::Result<(Client, SetId)> {
        let interrupt = Interrupt::on_signals()?;
        let mut client = self.port.open()?;
        let identity = ready(&mut client, self.scanning.rate)?;
        campaign.check_board(&board_record(&client, &identity))?;
        let proven = Proven::of(&mut client, &self.key)?;
        tell!("{}", proven.line());
        proven.check()?;
        let id = check_active(&mut client, ours, campaign)?;
        proven.check_set(Some(id))?;
        let mut motion = self.controller.motion(&interrupt)?;
        campaign.write()?;
        campaign.forget_verification(&run.name)?;
        let job = SequenceJob {
            campaign,
            runs: &[run],
            settings: Settings {
                rate_hz: self.scanning.rate,
                values: true,
            },
            board: identity.board,
            wait: self.waiting.time(),
            interrupt: &interrupt,
        };
        progress::record(&job, &mut client, motion.as_mut(), &same_again())?;
        Ok((client, id))
    }
}

/// Makes sure that the set on the board is the one that this campaign ended with, and returns its identity.
fn check_active(
    client: &mut Client,
    ours: &CoefficientSet,
    campaign: &Campaign,
) -> anyhow::Result<SetId> {
    let Some((active, encoded)) = client.read_set()? else {
        return Err(hexsense_core::wire::Refusal::NoSet.into());
    };
    if CoefficientSet::decode(&encoded)? != *ours {
        anyhow::bail!(
            "the board uses set {}, which is not the one of {folder}; `hexsense upload` that one, or verify in the \
             folder of the board's set",
            active.id,
            folder = campaign.folder.display()
        );
    }
    Ok(active.id)
}

/// Compares the poses that the board found during the run with those of double precision, and reports.
fn check_poses(
    campaign: &Campaign,
    run: &Run,
    poses: &[PoseReport],
    set: &CoefficientSet,
    id: SetId,
) -> anyhow::Result<Difference> {
    let (capture, record) = (campaign.capture(&run.name)?, campaign.record(&run.name)?);
    let difference = board_pose::compare(&capture, (record.rate_hz, record.block), poses, set, id)
        .map_err(|error| anyhow::anyhow!("run {}, {error}", run.name))?;
    say!("{}", poses_line(&difference))?;
    Ok(difference)
}

fn poses_line(difference: &Difference) -> String {
    format!(
        "{} poses of the board: at most {:.2e} m (scan {}) and {:.2e} rad off double precision, limit {MAX_DIFFERENCE:.0e}",
        difference.poses, difference.largest_m, difference.scan, difference.largest_rad
    )
}

/// Compares the recorded run with what the jacks say, and reports.
fn judge(
    campaign: &Campaign,
    run: &Run,
    set: &CoefficientSet,
    poses: Difference,
    elapsed_s: f64,
) -> anyhow::Result<()> {
    let recorded = campaign.recorded(run)?;
    check_values(&recorded.capture, set, &run.name)?;
    let sums = check_sums(campaign, &recorded)?;
    tell!(
        "{sums} harmonic sums of the board in run {}: likewise",
        run.name
    );
    let evaluation = report::evaluate(campaign)?;
    let results = &evaluation.analysis.results;
    let curves = held_out::held_out(&campaign.geometry, &campaign.sensors, &recorded, results)?;
    let (reference, after, before) = (&curves.reference, &curves.after, &curves.before);
    let verification = Verification {
        board_pose: poses.into(),
        channels: held_out::compare(reference, after, before, results, elapsed_s),
    };
    terminal::print(&table(&verification.channels))?;
    let verified = Verified {
        run: &recorded,
        curves: &curves,
        verification: &verification,
    };
    report::write(campaign, set, &evaluation, Some(verified))?;
    campaign.note_verification(&verification)?;
    let failures = held_out::failures(&verification.channels);
    if !failures.is_empty() {
        anyhow::bail!("{} did not pass; calibrate again", failures.join(", "));
    }
    Ok(())
}

/// Whether the board's values are bit for bit what its counts and its set give.
fn check_values(capture: &Capture, set: &CoefficientSet, run: &str) -> anyhow::Result<()> {
    let values = capture.values.as_deref().unwrap_or_default();
    if values.is_empty() {
        anyhow::bail!("run {run} holds no values made by the board; record it again");
    }
    if let Some(WrongValues { scan, board, host }) = first_wrong_values(capture, set) {
        anyhow::bail!(
            "run {run}, scan {scan}: the board's values {board:?} are not those that its counts and its set give, \
             {host:?}; firmware and hexsense are of different builds, or the set was changed during the run"
        );
    }
    tell!(
        "{} scans: the board's values are bit for bit those that its counts give",
        values.len()
    );
    Ok(())
}

fn table(verdicts: &[ChannelVerdict]) -> String {
    let mut text = String::from(
        "\nchannel  signal rms  error rms before  after      of signal   mean error ± uncertainty\n",
    );
    for verdict in verdicts {
        text += &format!(
            "{:<7} {:>11.5} {:>17.5} {:>10.5} {:>8.2} % {:>12.5} ± {:<9.5} {:<7} {}\n",
            verdict.name,
            verdict.rms_signal,
            verdict.rms_error_before,
            verdict.rms_error_after,
            100.0 * verdict.rms_error_after / verdict.rms_signal,
            verdict.mean_error,
            verdict.mean_uncertainty,
            verdict.unit,
            if verdict.passes() {
                "passes"
            } else {
                "does not pass"
            },
        );
    }
    text + "\n"
}

#[cfg(test)]
mod printed;

#[cfg(test)]
mod tests {
    use super::*;
    use hexsense_core::records::{JackCoefficients, MotionBase, TriadCoefficients};
    use hexsense_core::sampling::{Calibrator, Values};

    #[test]
    fn a_value_that_is_off_by_its_last_bit_is_found() {
        let triad = TriadCoefficients {
            offset: [32_768.0; 3],
            matrix: [[1e-3, 1e-5, 0.0], [0.0, 1e-3, 2e-5], [0.0, 0.0, 1e-3]],
            offset_uncertainty: [1.0; 3],
            matrix_uncertainty: [[1e-7; 3]; 3],
            delay_s: 0.0,
        };
        let set = CoefficientSet {
            board: [1; 12],
            geometry: "base".try_into().unwrap(),
            geometry_hash: [1; 8],
            unix_s: 0,
            temperature_c: 30.0,
            provenance: [2; 32],
            ratiometric: Default::default(),
            build: None,
            triads: [triad; 3],
            base: MotionBase::new(&GeometryFile::load("an-74tk-200").unwrap().geometry),
            jacks: JackCoefficients {
                zero_length_m: 2.75,
                zero_counts: [32_768.0; 6],
                metres_per_count: [2e-5; 6],
            },
        };
        let counts = vec![[30_001; 15], [40_000; 15]];
        let calibrator = Calibrator::new(&set);
        let mut values: Vec<Values> = counts
            .iter()
            .map(|scan| calibrator.apply(scan, 0.999))
            .collect();
        let capture = |values: &[Values]| Capture {
            scans: vec![7, 8],
            counts: counts.clone(),
            supply: vec![0.999; 2],
            temperature_c: vec![30.0; 2],
            values: Some(values.to_vec()),
        };
        check_values(&capture(&values), &set, "held-out").unwrap();
        values[1][4] = values[1][4].next_up();
        let error = check_values(&capture(&values), &set, "held-out").unwrap_err();
        assert!(error.to_string().contains("scan 8"), "{error}");
        assert!(check_values(&capture(&[]), &set, "held-out").is_err());
    }
}
