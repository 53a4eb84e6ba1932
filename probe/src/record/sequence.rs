//! The runs of a campaign, one after another. A run in which the board goes away is recorded again.

use std::time::Duration;

use hexsense_client::Client;

use super::board::ready;
use super::drives::{DriveChoice, NoChoice};
use super::error::RecordError;
use super::event::{Event, Place, Show};
use super::reconnect::{Patience, reconnect};
use super::run::{self, RunJob, Settings};
use crate::campaign::{Campaign, CampaignError, RunRecord};
use crate::capture::Capture;
use crate::files;
use crate::interrupt::{Interrupt, Interrupted};
use crate::motion::Motion;
use crate::plan::Run;

/// How often a run is recorded at most when the board goes away in it.
const ATTEMPTS: u32 = 3;

/// What is recorded, and how.
pub struct SequenceJob<'a> {
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
}

/// Why the runs are not all recorded.
#[derive(Debug, thiserror::Error)]
pub enum SequenceError {
    /// The board or the link cannot do a run at this rate. Nothing has moved.
    #[error(transparent)]
    NoChoice(#[from] NoChoice),
    /// What is noted of a recorded run cannot be used. Nothing has moved.
    #[error(transparent)]
    Campaign(#[from] CampaignError),
    /// A run is recorded at another rate. Nothing has moved.
    #[error(
        "run {run} is recorded at {recorded_hz} Hz, and the runs of a campaign are analysed together: go on with \
         --rate {recorded_hz}, or choose another folder"
    )]
    OtherRate {
        /// The run.
        run: String,
        /// Its rate, Hz.
        recorded_hz: u32,
    },
    /// A run broke off.
    #[error("run {run} broke off: {reason}")]
    BrokenOff {
        /// The run.
        run: String,
        /// The run before it, up to which the campaign is complete.
        complete_to: Option<String>,
        /// Why.
        #[source]
        reason: Box<RecordError>,
    },
    /// A request to stop came after the last run.
    #[error("{0}")]
    Interrupted(#[from] Interrupted),
}

impl SequenceJob<'_> {
    /// Records those runs that are not recorded yet.
    ///
    /// # Errors
    /// [`SequenceError`].
    pub fn record(
        &self,
        client: &mut Client,
        motion: &mut dyn Motion,
        show: Show,
    ) -> Result<(), SequenceError> {
        let choices = self.choices()?;
        for (index, (run, choice)) in self.runs.iter().zip(&choices).enumerate() {
            let place = Place {
                number: index + 1,
                of: self.runs.len(),
                run: &run.name,
            };
            if self.campaign.is_recorded(&run.name) {
                show(&Event::RecordedAlready(place));
                continue;
            }
            show(&Event::Next {
                place,
                duration_s: run.duration_s(),
                block: choice.block,
            });
            self.show_what_broke_off(run, show);
            let recorded = self.until_recorded(client, motion, (run, choice), show);
            let record = recorded.map_err(|reason| SequenceError::BrokenOff {
                run: run.name.clone(),
                complete_to: index
                    .checked_sub(1)
                    .map(|last| self.runs[last].name.clone()),
                reason: Box::new(reason),
            })?;
            if record.scans_lost > 0 {
                show(&Event::Lost {
                    run: &run.name,
                    lost: record.scans_lost,
                    scans: record.scans,
                });
            }
        }
        Ok(self.interrupt.check()?)
    }

    /// Shows what an earlier attempt left; the run is recorded again.
    fn show_what_broke_off(&self, run: &Run, show: Show) {
        let part = files::part_of(&self.campaign.capture_path(&run.name));
        if part.exists() {
            let left = Capture::salvage(&part);
            show(&Event::BrokeOffBefore {
                run: &run.name,
                left: left.map(|(capture, torn)| (capture.scans.len(), torn)),
            });
        }
    }

    /// Records a run, again from its start when the board went away and came back.
    fn until_recorded(
        &self,
        client: &mut Client,
        motion: &mut dyn Motion,
        (run, choice): (&Run, &DriveChoice),
        show: Show,
    ) -> Result<RunRecord, RecordError> {
        let job = RunJob {
            campaign: self.campaign,
            run,
            choice,
            settings: self.settings,
            interrupt: self.interrupt,
        };
        let mut attempt = 1;
        loop {
            self.interrupt.check()?;
            let lost = match run::record(client, motion, job, show) {
                Ok(record) => return Ok(record),
                Err(error) if error.is_loss() && attempt < ATTEMPTS => error.to_string(),
                Err(error) => return Err(error),
            };
            attempt += 1;
            let run = &run.name;
            show(&Event::Away {
                run: Some(run),
                lost: &lost,
            });
            self.find_again(client, lost, show)?;
            show(&Event::Again { run });
        }
    }

    /// Waits for the board, and makes it ready again.
    fn find_again(&self, client: &mut Client, lost: String, show: Show) -> Result<(), RecordError> {
        let patience = Patience {
            board: self.board,
            wait: self.wait,
            interrupt: self.interrupt,
        };
        let restarted = reconnect(client, lost, patience, show)?;
        show(&Event::Back { restarted });
        ready(client, self.settings.rate_hz)?;
        Ok(())
    }

    /// What the board will be asked for in each run.
    fn choices(&self) -> Result<Vec<DriveChoice>, SequenceError> {
        let (campaign, rate_hz) = (self.campaign, self.settings.rate_hz);
        for run in self
            .runs
            .iter()
            .filter(|run| campaign.is_recorded(&run.name))
        {
            let recorded_hz = campaign.record(&run.name)?.rate_hz;
            if recorded_hz != rate_hz {
                return Err(SequenceError::OtherRate {
                    run: run.name.clone(),
                    recorded_hz,
                });
            }
        }
        let content = self.settings.content();
        let choices = self
            .runs
            .iter()
            .map(|run| DriveChoice::new(run, &campaign.sensors, rate_hz, content));
        Ok(choices.collect::<Result<_, _>>()?)
    }
}
