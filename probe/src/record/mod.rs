//! Recording one run: the stream of scans into a capture, and the board's own harmonic sums.
//!
//! ```text
//! block set ── stream on ── rest seen ── controller told ── onset seen ── drives set ── … ── end + 1 s ── stream off ── sums read
//! ```
//!
//! - [`drives`]: what the board is asked to estimate, in which blocks.
//! - [`tape`]: the capture as it grows.
//! - [`jacks`]: displacements of the jacks, averaged.
//! - [`rest`]: whether the base is at home and at rest.
//! - [`onset`]: when it begins to move.
//!
//! Nothing waits for ever: a base that does not come to rest within 60 s or does not move within 30 s, samples that do not
//! come for 2 s and sums that are not complete at the end are errors that say what to check. A request to stop is heard
//! between two blocks.

pub mod drives;
mod error;
pub mod jacks;
pub mod onset;
pub mod rest;
pub mod tape;

use std::time::Duration;

use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::{ChannelSums, DriveError};
use hexsense_core::wire::telemetry::Block;
use hexsense_core::wire::{AnalyserState, Drive, Refusal, StreamContent};
use indicatif::{ProgressBar, ProgressStyle};

use crate::campaign::{BoardSums, Campaign, RunRecord};
use crate::files::FileError;
use crate::interrupt::Interrupt;
use crate::motion::Motion;
use crate::plan::Run;
use drives::{Choice, Line};
pub use error::RecordError;
use hexsense_client::{Client, LinkError};
use jacks::JackMeans;
use onset::OnsetWatch;
use rest::{Rest, RestWatch, Unrest};
use tape::Tape;

/// How long the next block may take.
const BLOCK_WAIT: Duration = Duration::from_secs(2);
/// How long the base may take to come to rest at home before a run, s.
const MAX_REST_WAIT_S: f64 = 60.0;
/// How long the base may take to start after the controller was told, s.
const MAX_ONSET_WAIT_S: f64 = 30.0;
/// Recorded after the end of the program, s.
const AFTER_S: f64 = 1.0;
/// Sums start so much before the settling is over, s: the onset is known to a tenth of a second, and the end of the
/// window must not reach into the fade.
const SUM_EARLY_S: f64 = 0.1;

/// How runs are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Scan rate, Hz, as the board has it.
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

/// Records one run of the campaign, for which this was chosen, into the campaign's folder.
///
/// # Errors
/// [`RecordError`]. The base has then been told to return home, and the folder holds no recording of this run.
pub fn record(
    client: &mut Client,
    motion: &mut dyn Motion,
    campaign: &Campaign,
    (run, choice): (&Run, &Choice),
    settings: Settings,
    interrupt: &Interrupt,
) -> Result<RunRecord, RecordError> {
    let bar = bar(run);
    let result = Recording {
        client,
        motion,
        campaign,
        run,
        choice,
        settings,
        interrupt,
        bar: &bar,
    }
    .record();
    bar.finish_and_clear();
    if result.is_err() {
        motion.stop();
        // The line may be what failed; the error at hand says so.
        let _ = client.stream(StreamContent::default());
    }
    result
}

struct Recording<'a> {
    client: &'a mut Client,
    motion: &'a mut dyn Motion,
    campaign: &'a Campaign,
    run: &'a Run,
    choice: &'a Choice,
    settings: Settings,
    interrupt: &'a Interrupt,
    bar: &'a ProgressBar,
}

impl Recording<'_> {
    fn record(&mut self) -> Result<RunRecord, RecordError> {
        let moves = self.run.rest_s.is_none();
        let program = self.campaign.program_path(self.run);
        self.motion
            .prepare(&self.run.name, moves.then_some(program.as_path()))?;
        if self.client.status()?.block != self.choice.block {
            self.client.block_size(self.choice.block)?;
        }
        let set = self.client.active_set()?.map(|set| set.id.to_string());
        self.client.forget_blocks();
        self.client.stream(self.settings.content())?;
        let mut tape = self.tape()?;
        let mut jacks = JackMeans::new(&self.campaign.geometry, &self.campaign.sensors);
        let rest = self.settle(&mut tape, &mut jacks)?;
        let onset_scan = if moves {
            Some(self.start(&mut tape, &mut jacks, rest)?)
        } else {
            None
        };
        let drives = match onset_scan {
            Some(onset) => self.drives(&tape, onset)?,
            None => Vec::new(),
        };
        self.follow(&mut tape, onset_scan)?;
        self.client.stream(StreamContent::default())?;
        let board_sums = (0..).zip(drives);
        let board_sums = board_sums.map(|(analyser, drive)| self.sums(analyser, drive));
        let board_sums = board_sums.collect::<Result<_, _>>()?;
        let taped = tape.finish()?;
        let record = RunRecord {
            run: self.run.name.clone(),
            program_sha256: self.campaign.program_hash(self.run),
            rate_hz: self.settings.rate_hz,
            block: self.choice.block,
            set,
            onset_scan,
            scans: taped.scans,
            scans_lost: taped.lost,
            board_sums,
        };
        self.campaign.note_run(&record)?;
        Ok(record)
    }

    /// Waits until the base is at rest at home; the tape then begins with that rest.
    fn settle(&mut self, tape: &mut Tape, jacks: &mut JackMeans) -> Result<Rest, RecordError> {
        let mut watch = RestWatch::new(&self.campaign.geometry);
        self.bar.set_message("at rest");
        let first = self.take(tape)?.header.first_scan;
        let limit = first + self.scans(MAX_REST_WAIT_S);
        loop {
            let block = self.take(tape)?;
            match watch.learn(&block, jacks) {
                Ok(Some(rest)) => return Ok(rest),
                Ok(None) => {}
                Err(unrest) if tape.next_scan() >= limit => return Err(self.restless(unrest)),
                Err(_) => {
                    self.bar
                        .set_message("waiting for the base to come to rest at home");
                    *tape = self.tape()?;
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
            },
            Unrest::Away { jack, off_m } => RecordError::NotAtHome {
                run,
                jack,
                off_mm: 1e3 * off_m,
            },
        }
    }

    /// Has the controller start, and waits for the onset.
    fn start(
        &mut self,
        tape: &mut Tape,
        jacks: &mut JackMeans,
        rest: Rest,
    ) -> Result<u64, RecordError> {
        let mut watch = OnsetWatch::new(self.run, &self.campaign.geometry, rest);
        self.motion
            .start(&self.run.name, &self.campaign.program_path(self.run))?;
        self.bar.set_message("waiting for the base to move");
        let limit = tape.next_scan() + self.scans(MAX_ONSET_WAIT_S);
        while tape.next_scan() < limit {
            let block = self.take(tape)?;
            if let Some(onset) = watch.watch(&block, jacks) {
                return Ok(onset);
            }
        }
        Err(RecordError::NoOnset {
            run: self.run.name.clone(),
        })
    }

    /// Has the board sum at each line, from a little before the line's window on.
    fn drives(&mut self, tape: &Tape, onset: u64) -> Result<Vec<Drive>, RecordError> {
        let lines = (0..).zip(&self.choice.lines);
        lines
            .map(|(analyser, line)| self.drive(analyser, line, tape, onset))
            .collect()
    }

    fn drive(
        &mut self,
        analyser: u8,
        line: &Line,
        tape: &Tape,
        onset: u64,
    ) -> Result<Drive, RecordError> {
        let Settings { rate_hz, .. } = self.settings;
        let block = self.choice.block;
        let start = onset + self.scans((line.start_s - SUM_EARLY_S).max(0.0));
        let settle = start.saturating_sub(tape.next_scan()) as f64 / block.scans() as f64;
        let drive = line.drive(rate_hz, block, settle.round() as u32);
        let drive = drive.ok_or(LinkError::Refused(Refusal::Drive(DriveError::Frequency)))?;
        self.client.drive(analyser, drive)?;
        Ok(drive)
    }

    /// Records to the end of the run, or for the length of a rest.
    fn follow(&mut self, tape: &mut Tape, onset_scan: Option<u64>) -> Result<(), RecordError> {
        let (start, length) = match onset_scan {
            Some(onset) => (onset, self.scans(self.run.duration_s() + AFTER_S)),
            None => (tape.next_scan(), self.scans(self.run.duration_s())),
        };
        self.bar.set_message("");
        while tape.next_scan() < start + length {
            self.take(tape)?;
            let done = tape.next_scan().saturating_sub(start);
            self.bar
                .set_position(done * 1000 / u64::from(self.settings.rate_hz));
        }
        Ok(())
    }

    fn scans(&self, seconds: f64) -> u64 {
        (seconds * f64::from(self.settings.rate_hz)) as u64
    }

    fn tape(&self) -> Result<Tape, FileError> {
        Tape::create(
            &self.campaign.capture_path(&self.run.name),
            self.settings.values,
        )
    }

    fn take(&mut self, tape: &mut Tape) -> Result<Block, RecordError> {
        self.interrupt.check()?;
        let block = self.client.block(BLOCK_WAIT)?;
        tape.push(&block)?;
        Ok(block)
    }

    fn sums(&mut self, analyser: u8, drive: Drive) -> Result<BoardSums, RecordError> {
        let mut sums = BoardSums {
            drive,
            first_scan: 0,
            channels: [ChannelSums::default(); CHANNELS],
        };
        for channel in 0..CHANNELS {
            let report = self.client.sums(analyser, channel as u8)?;
            if report.state != AnalyserState::Complete || report.drive != drive {
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

/// A bar that shows the run's seconds; hidden when standard error is not a terminal.
fn bar(run: &Run) -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix:>12} [{bar:40}] {msg} {eta}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(((run.duration_s() + AFTER_S) * 1000.0) as u64)
        .with_style(style)
        .with_prefix(run.name.clone())
}
