//! One run of a campaign: from the first block to the capture and the board's own harmonic sums.
//!
//! ```text
//! stream on ── rest seen ── controller started ── onset seen ── drives set ── … ── end + 1 s ── stream off ── sums read
//! ```
//!
//! Every wait ends: a base that does not come to rest within 60 s, a base that does not move within 30 s, and sums that are
//! not complete at the end are errors that say what to check.

use hexsense_client::{Client, LinkError};
use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::{ChannelSums, DriveError};
use hexsense_core::wire::{AnalyserState, Drive, Refusal, StreamContent};

use super::board::Streaming;
use super::csv::CsvSink;
use super::drives::{DriveChoice, DriveLine};
use super::error::RecordError;
use super::event::{Event, Show};
use super::jacks::JackMeans;
use super::onset::OnsetWatch;
use super::recorder::Recorder;
use super::rest::{AtRest, RestWatch, Unrest};
use crate::campaign::{BoardSums, Campaign, RunRecord};
use crate::interrupt::Interrupt;
use crate::motion::Motion;
use crate::plan::Run;

/// How long the base may take to come to rest at home before a run, s.
const MAX_REST_WAIT_S: f64 = 60.0;
/// How long the base may take to start after the start command, s.
const MAX_ONSET_WAIT_S: f64 = 30.0;
/// Recorded after the end of the program, s.
const AFTER_S: f64 = 1.0;
/// Sums start so much before the settling is over, s: the onset is known to a tenth of a second, and the end of the
/// window must not reach into the fade.
const SUM_EARLY_S: f64 = 0.1;

/// How runs are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Whether the board's calibrated values are recorded too, and its poses left with the client
    /// ([`Client::take_poses`]).
    pub values: bool,
}

impl Settings {
    /// What the board is to stream.
    #[must_use]
    pub const fn content(&self) -> StreamContent {
        StreamContent {
            counts: true,
            values: self.values,
            pose: self.values,
        }
    }
}

/// A run, and all that recording it needs.
#[derive(Clone, Copy)]
pub struct RunJob<'a> {
    /// The campaign, into whose folder the run is recorded.
    pub campaign: &'a Campaign,
    /// The run.
    pub run: &'a Run,
    /// What the board is asked to estimate in it.
    pub choice: &'a DriveChoice,
    /// How it is recorded.
    pub settings: Settings,
    /// Asks to stop.
    pub interrupt: &'a Interrupt,
}

/// Records one run.
///
/// # Errors
/// [`RecordError`]. The base is then on its way home, as far as the controller obeys, and the folder holds no recording of
/// this run.
pub fn record(
    client: &mut Client,
    motion: &mut dyn Motion,
    job: RunJob,
    show: Show,
) -> Result<RunRecord, RecordError> {
    show(&Event::Begins {
        run: &job.run.name,
        duration_s: job.run.duration_s() + AFTER_S,
    });
    let result = job.record(client, motion, show);
    show(&Event::Ends);
    if result.is_err() {
        motion.stop();
        // The line may be what failed; the error at hand says so.
        let _ = client.stream(StreamContent::default());
    }
    result
}

impl RunJob<'_> {
    fn record(
        &self,
        client: &mut Client,
        motion: &mut dyn Motion,
        show: Show,
    ) -> Result<RunRecord, RecordError> {
        let moves = self.run.rest_s.is_none();
        let program = self.campaign.program_path(self.run);
        motion.prepare(&self.run.name, moves.then_some(program.as_path()))?;
        let streaming = Streaming {
            rate_hz: self.settings.rate_hz,
            block: self.choice.block,
            content: self.settings.content(),
        };
        let mut recorder = Recorder::start(client, streaming, self.interrupt)?;
        let capture = self.campaign.capture_path(&self.run.name);
        recorder.begin(vec![Box::new(CsvSink::new(capture))])?;
        let mut jacks = JackMeans::new(&self.campaign.geometry, &self.campaign.sensors);
        let rest = self.settle(&mut recorder, &mut jacks, show)?;
        let (mut onset_scan, mut drives) = (None, Vec::new());
        if moves {
            motion.start(&self.run.name, &program)?;
            show(&Event::Phase("waiting for the base to move"));
            let onset = self.onset(&mut recorder, &mut jacks, rest)?;
            onset_scan = Some(onset);
            drives = self.drives(&mut recorder, onset)?;
        }
        self.follow(&mut recorder, onset_scan, show)?;
        recorder.client().stream(StreamContent::default())?;
        let board_sums = (0..).zip(drives);
        let board_sums =
            board_sums.map(|(analyser, drive)| self.sums(recorder.client(), analyser, drive));
        let board_sums = board_sums.collect::<Result<_, _>>()?;
        let set = recorder.notes().set.map(|set| set.to_string());
        let recorded = recorder.end()?;
        let record = RunRecord {
            run: self.run.name.clone(),
            program_sha256: self.campaign.program_hash(self.run),
            rate_hz: self.settings.rate_hz,
            block: self.choice.block,
            set,
            onset_scan,
            scans: recorded.scans,
            scans_lost: recorded.lost,
            board_sums,
        };
        self.campaign.note_run(&record)?;
        Ok(record)
    }

    /// Waits until the base is at rest at home; the recording then begins with that rest.
    fn settle(
        &self,
        recorder: &mut Recorder,
        jacks: &mut JackMeans,
        show: Show,
    ) -> Result<AtRest, RecordError> {
        let mut watch = RestWatch::new(&self.campaign.geometry);
        show(&Event::Phase("at rest"));
        let first = recorder.next_block()?.header.first_scan;
        let limit = first + self.scans(MAX_REST_WAIT_S);
        loop {
            let block = recorder.next_block()?;
            match watch.learn(&block, jacks) {
                Ok(Some(rest)) => return Ok(rest),
                Ok(None) => {}
                Err(unrest) if recorder.next_scan() >= limit => return Err(self.restless(unrest)),
                Err(_) => {
                    show(&Event::Phase(
                        "waiting for the base to come to rest at home",
                    ));
                    recorder.begin_again()?;
                }
            }
        }
    }

    fn restless(&self, unrest: Unrest) -> RecordError {
        let run = self.run.name.clone();
        match unrest {
            Unrest::Moving { jack, moved_m } => RecordError::NotAtRest {
                run,
                jack,
                moved_mm: 1e3 * moved_m,
                waited_s: MAX_REST_WAIT_S,
            },
            Unrest::Away { jack, off_m } => RecordError::NotAtHome {
                run,
                jack,
                off_mm: 1e3 * off_m,
            },
        }
    }

    /// Waits for the onset of the program that the controller starts.
    fn onset(
        &self,
        recorder: &mut Recorder,
        jacks: &mut JackMeans,
        rest: AtRest,
    ) -> Result<u64, RecordError> {
        let mut watch = OnsetWatch::new(self.run, &self.campaign.geometry, rest);
        let limit = recorder.next_scan() + self.scans(MAX_ONSET_WAIT_S);
        while recorder.next_scan() < limit {
            let block = recorder.next_block()?;
            if let Some(onset) = watch.watch(&block, jacks) {
                return Ok(onset);
            }
        }
        Err(RecordError::NoOnset {
            run: self.run.name.clone(),
            waited_s: MAX_ONSET_WAIT_S,
        })
    }

    /// Has the board sum at each line, from a little before the line's window on.
    fn drives(&self, recorder: &mut Recorder, onset: u64) -> Result<Vec<Drive>, RecordError> {
        let lines = (0..).zip(&self.choice.lines);
        lines
            .map(|(analyser, line)| self.drive(recorder, analyser, line, onset))
            .collect()
    }

    fn drive(
        &self,
        recorder: &mut Recorder,
        analyser: u8,
        line: &DriveLine,
        onset: u64,
    ) -> Result<Drive, RecordError> {
        let block = self.choice.block;
        let start = onset + self.scans((line.start_s - SUM_EARLY_S).max(0.0));
        let settle = start.saturating_sub(recorder.next_scan()) as f64 / block.scans() as f64;
        let drive = line.drive(self.settings.rate_hz, block, settle.round() as u32);
        let drive = drive.ok_or(LinkError::Refused(Refusal::Drive(DriveError::Frequency)))?;
        recorder.client().drive(analyser, drive)?;
        Ok(drive)
    }

    /// Records to the end of the run, or for the length of a rest.
    fn follow(
        &self,
        recorder: &mut Recorder,
        onset_scan: Option<u64>,
        show: Show,
    ) -> Result<(), RecordError> {
        let (start, length) = match onset_scan {
            Some(onset) => (onset, self.scans(self.run.duration_s() + AFTER_S)),
            None => (recorder.next_scan(), self.scans(self.run.duration_s())),
        };
        show(&Event::Phase(""));
        while recorder.next_scan() < start + length {
            recorder.next_block()?;
            let done = recorder.next_scan().saturating_sub(start);
            show(&Event::Progress(
                done as f64 / f64::from(self.settings.rate_hz),
            ));
        }
        Ok(())
    }

    fn scans(&self, seconds: f64) -> u64 {
        (seconds * f64::from(self.settings.rate_hz)) as u64
    }

    fn sums(
        &self,
        client: &mut Client,
        analyser: u8,
        drive: Drive,
    ) -> Result<BoardSums, RecordError> {
        let mut sums = BoardSums {
            drive,
            first_scan: 0,
            channels: [ChannelSums::default(); CHANNELS],
        };
        for channel in 0..CHANNELS {
            let report = client.sums(analyser, channel as u8)?;
            if !is_whole(report.state, &report.drive, &drive) {
                return Err(RecordError::Sums {
                    run: self.run.name.clone(),
                    frequency_hz: self.choice.lines[usize::from(analyser)].frequency_hz,
                    state: report.state,
                });
            }
            sums.first_scan = report.first_scan;
            sums.channels[channel] = report.sums;
        }
        Ok(sums)
    }
}

/// Whether sums in this state and of this drive are those that were asked for.
fn is_whole(state: AnalyserState, of: &Drive, asked: &Drive) -> bool {
    state == AnalyserState::Complete && of == asked
}

#[cfg(test)]
mod tests;
