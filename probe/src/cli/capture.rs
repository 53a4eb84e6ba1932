//! `hexsense capture`: the stream of scans into a file.

use std::path::PathBuf;

use clap::Args;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::StreamContent;

use super::arguments::{Port, Scanning, Waiting};
use super::broken_off::{BrokenOff, same_again};
use super::progress::Progress;
use crate::files;
use crate::interrupt::Interrupt;
use crate::record::RecordError;
use crate::record::board::Streaming;
use crate::record::sink::Recorded;
use crate::record::timed::{TimedError, TimedJob};
use crate::terminal::{say, tell};

/// Record what the board measures into a CSV file, with a note beside it.
///
/// The file has a row for each scan: its counter, the raw counts of all fifteen channels, the supply factor, the
/// temperature, and with --values the nine values that the board calibrated. Scans that do not arrive are missing rows,
/// and the note FILE.json lists them beside the rate, the board, and the set that was active. A stream that the link
/// cannot carry is refused: at 4000 Hz it carries counts and no values.
///
/// While it grows, and when it breaks off, the recording is FILE.csv.part, readable like the complete one and on the disk
/// up to the last second. Ctrl-C stops the recording; the board keeps sampling. When the line to the board is cut, hexsense
/// waits for it, and the scans of that time are a gap; a board that has restarted ends the recording.
#[derive(Args)]
pub struct Capture {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    scanning: Scanning,
    /// Length of the recording, s
    #[arg(long, value_name = "S", value_parser = length)]
    seconds: f64,
    /// Scans that the board takes at a time: 1, 4, 8, 16 or 32. A large block costs the board and the link less, a small
    /// one arrives sooner. Harmonic sums of the board mistake disturbances at m·RATE/BLOCK ± k·f for harmonic k of f;
    /// recorded scans do not
    #[arg(long, value_name = "BLOCK", default_value = "16", value_parser = block)]
    block: BlockSize,
    /// Record the board's calibrated values too
    #[arg(long)]
    values: bool,
    /// The file to write; a file that is there is replaced when the recording is complete
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    waiting: Waiting,
}

fn length(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (1e-3..=86_400.0).contains(&seconds) {
        Ok(seconds)
    } else {
        Err("a recording takes 0.001 to 86400 s".to_owned())
    }
}

fn block(text: &str) -> Result<BlockSize, String> {
    let scans = text.parse().ok();
    scans
        .and_then(BlockSize::of_scans)
        .ok_or_else(|| "the board takes 1, 4, 8, 16 or 32 scans at a time".to_owned())
}

impl Capture {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports, what the board refuses, and a file that cannot be written.
    pub fn run(self) -> anyhow::Result<()> {
        let interrupt = Interrupt::on_signals()?;
        let mut client = self.port.open()?;
        let job = TimedJob {
            streaming: Streaming {
                rate_hz: self.scanning.rate,
                block: self.block,
                content: StreamContent {
                    counts: true,
                    values: self.values,
                    pose: false,
                },
            },
            seconds: self.seconds,
            out: &self.out,
            wait: self.waiting.time(),
            interrupt: &interrupt,
        };
        let mut progress = Progress::default();
        let recorded = job.record(&mut client, &mut |event| progress.show(event));
        let recorded = recorded.map_err(|error| match error {
            TimedError {
                reason,
                recorded: Some(recorded),
            } => self.broken_off(reason, &recorded).into(),
            TimedError { reason, .. } => anyhow::Error::from(reason),
        })?;
        if recorded.lost > 0 {
            tell!(
                "{} scans did not arrive, in {} gaps; the file has no rows for them",
                recorded.lost,
                recorded.gaps.len()
            );
        }
        say!("written: {}, {} scans", self.out.display(), recorded.scans)?;
        Ok(())
    }

    fn broken_off(&self, reason: Box<RecordError>, recorded: &Recorded) -> BrokenOff {
        let out = files::part_of(&self.out);
        let note = files::part_of(&self.out.with_extension("json"));
        BrokenOff {
            what: "the recording".to_owned(),
            reason,
            safe: format!(
                "the board keeps sampling; {} scans are in {}, and what they belong to in {}",
                recorded.scans,
                out.display(),
                note.display()
            ),
            next: format!(
                "keep those under other names if you need them, then record again by\n         {}",
                same_again()
            ),
        }
    }
}
