//! The runs of a campaign, recorded one after another, whatever happens to the board.

use std::time::Duration;

use super::broken_off::BrokenOff;
use super::session;
use crate::campaign::{Campaign, RunRecord};
use crate::capture::Capture;
use crate::files;
use crate::interrupt::Interrupt;
use crate::motion::Motion;
use crate::plan::Run;
use crate::reconnect::{Patience, reconnect};
use crate::record::drives::Choice;
use crate::record::{self, Settings};
use hexsense_client::Client;

/// How often a run is recorded at most when the board goes away in it.
const ATTEMPTS: u32 = 3;

/// What is recorded, and how.
pub struct Job<'a> {
    /// The campaign.
    pub campaign: &'a Campaign,
    /// Its runs, in order.
    pub runs: &'a [&'a Run],
    /// How they are recorded.
    pub settings: Settings,
    /// Unique id of the board.
    pub board: [u8; 12],
    /// How long the board may be away.
    pub wait: Duration,
    /// Asks to stop.
    pub interrupt: &'a Interrupt,
    /// The command that goes on after a run that broke off.
    pub again: String,
}

/// Records those runs that are not recorded yet; the client of the board, which may have gone away and come back.
///
/// # Errors
/// Before anything moves, a run that the board or the link cannot do at this rate, and one that is recorded at another;
/// then [`BrokenOff`], with what the first run that fails reports, what is safe, and how to go on.
pub fn record_all(
    mut client: Client,
    motion: &mut dyn Motion,
    job: &Job,
) -> anyhow::Result<Client> {
    let choices = choices(job)?;
    for (index, run) in job.runs.iter().enumerate() {
        let place = format!("run {} of {}: {}", index + 1, job.runs.len(), run.name);
        if job.campaign.is_recorded(&run.name) {
            eprintln!("{place} is recorded already");
            continue;
        }
        let choice = &choices[index];
        eprintln!(
            "{place}, {:.0} s, in blocks of {} scans",
            run.duration_s(),
            choice.block.scans()
        );
        say_what_broke_off(job.campaign, run);
        let record;
        (client, record) = until_recorded(client, motion, job, (run, choice))
            .map_err(|reason| broken_off(reason, job, index))?;
        if record.scans_lost > 0 {
            eprintln!(
                "run {}: {} of {} scans were lost on the way",
                run.name, record.scans_lost, record.scans
            );
        }
    }
    job.interrupt.check()?;
    Ok(client)
}

/// What an earlier attempt left; it is recorded anew.
fn say_what_broke_off(campaign: &Campaign, run: &Run) {
    let part = files::part_of(&campaign.capture_path(&run.name));
    if !part.exists() {
        return;
    }
    let name = &run.name;
    match Capture::salvage(&part) {
        Ok((capture, torn)) => {
            let torn = torn.map_or(String::new(), |torn| format!("; {torn}"));
            let scans = capture.scans.len();
            eprintln!(
                "run {name} broke off before, after {scans} scans{torn}; it is recorded again from its start"
            );
        }
        Err(error) => {
            eprintln!("run {name} broke off before: {error}; it is recorded again from its start")
        }
    }
}

/// Records a run, again from its start when the board went away and came back.
fn until_recorded(
    mut client: Client,
    motion: &mut dyn Motion,
    job: &Job,
    (run, choice): (&Run, &Choice),
) -> anyhow::Result<(Client, RunRecord)> {
    let mut attempt = 1;
    loop {
        job.interrupt.check()?;
        let Job {
            campaign,
            settings,
            interrupt,
            ..
        } = *job;
        let what = (run, choice);
        let lost = match record::record(&mut client, motion, campaign, what, settings, interrupt) {
            Ok(record) => return Ok((client, record)),
            Err(error) if error.is_loss() && attempt < ATTEMPTS => error.to_string(),
            Err(error) => return Err(error.into()),
        };
        attempt += 1;
        eprintln!("run {}: {lost}", run.name);
        client = find_again(client, lost, job)?;
        eprintln!("run {} is recorded again from its start", run.name);
    }
}

/// Waits for the board, and makes it ready again.
fn find_again(client: Client, lost: String, job: &Job) -> anyhow::Result<Client> {
    let patience = Patience {
        board: job.board,
        wait: job.wait,
        interrupt: job.interrupt,
    };
    let mut back = reconnect(client, lost, patience)?;
    match back.restarted {
        Some(cause) => eprintln!("the board is back; it has started anew ({cause:?})"),
        None => eprintln!("the board is back; it has gone on meanwhile"),
    }
    session::ready(&mut back.client, job.settings.rate_hz)?;
    Ok(back.client)
}

/// What the board will be asked for in each run.
fn choices(job: &Job) -> anyhow::Result<Vec<Choice>> {
    let Job {
        campaign,
        runs,
        settings,
        ..
    } = *job;
    let rate_hz = settings.rate_hz;
    for run in runs.iter().filter(|run| campaign.is_recorded(&run.name)) {
        let recorded = campaign.record(&run.name)?.rate_hz;
        anyhow::ensure!(
            recorded == rate_hz,
            "run {} is recorded at {recorded} Hz, and the runs of a campaign are analysed together: go on with \
             --rate {recorded}, or choose another folder",
            run.name
        );
    }
    let choices = runs
        .iter()
        .map(|run| Choice::new(run, &campaign.sensors, rate_hz, settings.content()));
    Ok(choices.collect::<Result<_, _>>()?)
}

/// What happened, what is safe, what to do.
fn broken_off(reason: anyhow::Error, job: &Job, failed: usize) -> BrokenOff {
    let folder = job.campaign.folder.display();
    let complete = match failed.checked_sub(1) {
        Some(last) => format!("{folder} is complete up to run {}", job.runs[last].name),
        None => format!("{folder} holds no complete run yet"),
    };
    let name = &job.runs[failed].name;
    BrokenOff {
        what: format!("run {name}"),
        reason,
        safe: format!(
            "nothing on the board has changed, it goes on sampling and its coefficients are still active; {complete}"
        ),
        next: format!(
            "bring the base home, then go on with run {name} by\n         {}",
            job.again
        ),
    }
}
