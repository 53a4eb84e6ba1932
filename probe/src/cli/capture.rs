//! `hexsense capture`: the stream of scans into a file.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use hexsense_core::records::SetId;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::StreamContent;
use hexsense_core::wire::telemetry::Block;
use serde_json::json;

use super::arguments::{Port, Scanning, Waiting};
use super::broken_off::{BrokenOff, same_again};
use super::session;
use crate::campaign::BoardRecord;
use crate::files;
use crate::interrupt::Interrupt;
use crate::reconnect::{Back, Patience, reconnect};
use crate::record::RecordError;
use crate::record::tape::{Tape, Taped};
use hexsense_client::Client;

/// How long the next block may take.
const BLOCK_WAIT: Duration = Duration::from_secs(2);

/// Record what the board measures into a CSV file, with a note of what it belongs to beside it.
///
/// The file has a row for each scan: its counter, the raw counts of all fifteen channels, the supply factor, the
/// temperature, and with --values the nine values that the board calibrated. Scans that do not arrive are missing rows,
/// and FILE.json lists them beside the rate, the board, and the set that was active. What the link cannot carry is
/// refused: at 4000 Hz it carries counts and no values.
///
/// While it grows, and when it breaks off, the recording is FILE.csv.part, readable like the complete one and on the disk
/// up to the last second. Ctrl-C stops it there; the board goes on sampling. A board whose line was cut is waited for, and
/// what it sampled meanwhile is a gap; one that has started anew ends the recording.
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
    /// one is sooner there. Harmonics that the board sums up in blocks mistake disturbances at m·RATE/BLOCK ± k·f for
    /// harmonic k of f; recorded scans do not
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
        let identity = client.identity()?;
        let board = session::board_record(&client, &identity);
        client.rate(self.scanning.rate)?;
        client.block_size(self.block)?;
        let content = self.content();
        client.stream(content)?;
        eprintln!(
            "recording {} s at {} Hz in blocks of {}: {:.0} % of what the link carries",
            self.seconds,
            self.scanning.rate,
            self.block.scans(),
            100.0 * session::link_load(&identity.facts, content, self.scanning.rate, self.block)
        );
        let set = client.active_set()?.map(|set| set.id);
        let note_path = self.out.with_extension("json");
        files::write_part(&note_path, &self.note(None, set, &board))?;
        let patience = Patience {
            board: identity.board,
            wait: self.waiting.time(),
            interrupt: &interrupt,
        };
        let taped = self.record(client, set, patience)?;
        files::replace(&note_path, &self.note(Some(&taped), set, &board))?;
        if taped.lost > 0 {
            eprintln!(
                "{} scans did not arrive, in {} gaps; the file has no rows for them",
                taped.lost,
                taped.gaps.len()
            );
        }
        println!("written: {}, {} scans", self.out.display(), taped.scans);
        Ok(())
    }

    fn content(&self) -> StreamContent {
        StreamContent {
            counts: true,
            values: self.values,
            pose: false,
        }
    }

    /// The recording on its tape; the stream is off afterwards.
    fn record(
        &self,
        client: Client,
        set: Option<SetId>,
        patience: Patience,
    ) -> anyhow::Result<Taped> {
        let mut tape = Tape::create(&self.out, self.values)?;
        match self.follow(client, &mut tape, set, patience) {
            Ok(()) => Ok(tape.finish()?),
            Err(reason) => Err(self.broken_off(reason, tape.taped()).into()),
        }
    }

    /// Tapes blocks until the recording is long enough, also across a time in which the board was away.
    fn follow(
        &self,
        mut client: Client,
        tape: &mut Tape,
        set: Option<SetId>,
        patience: Patience,
    ) -> anyhow::Result<()> {
        let length = (self.seconds * f64::from(self.scanning.rate)).ceil() as u64;
        let (mut start, mut is_heard) = (None, true);
        while start.is_none_or(|start| tape.next_scan() < start + length) {
            let block = match self.take(&mut client, tape, set, patience.interrupt) {
                Ok(block) => block,
                // A board that comes back and sends nothing would be waited for for ever.
                Err(error) if error.is_loss() && is_heard => {
                    is_heard = false;
                    client = self.find_again(client, error.to_string(), patience)?;
                    continue;
                }
                Err(error) => {
                    // The line may be what failed; the error at hand says so.
                    let _ = client.stream(StreamContent::default());
                    return Err(error.into());
                }
            };
            start.get_or_insert(block.header.first_scan);
            is_heard = true;
        }
        // All is recorded; a board that goes on streaming is stopped by whoever connects next.
        let _ = client.stream(StreamContent::default());
        let missing = client.frames_missing();
        if missing > 0 {
            eprintln!("{missing} frames of the stream did not arrive whole");
        }
        Ok(())
    }

    fn take(
        &self,
        client: &mut Client,
        tape: &mut Tape,
        set: Option<SetId>,
        interrupt: &Interrupt,
    ) -> Result<Block, RecordError> {
        interrupt.check()?;
        let block = client.block(BLOCK_WAIT)?;
        let first_scan = block.header.first_scan;
        if block.header.set != set {
            return Err(RecordError::OtherSet { scan: first_scan });
        }
        tape.push(&block)?;
        Ok(block)
    }

    /// Waits for a board that went away; it must have gone on counting scans meanwhile.
    fn find_again(
        &self,
        client: Client,
        lost: String,
        patience: Patience,
    ) -> anyhow::Result<Client> {
        eprintln!("{lost}");
        let Back {
            mut client,
            restarted,
        } = reconnect(client, lost, patience)?;
        if let Some(cause) = restarted {
            anyhow::bail!(
                "the board has started anew ({cause:?}) and counts its scans from zero, so this recording cannot go on"
            );
        }
        client.stream(self.content())?;
        eprintln!("the board is back and has gone on meanwhile; what is missing is a gap");
        Ok(client)
    }

    fn broken_off(&self, reason: anyhow::Error, taped: &Taped) -> BrokenOff {
        let out = files::part_of(&self.out);
        let note = files::part_of(&self.out.with_extension("json"));
        BrokenOff {
            what: "the recording".to_owned(),
            reason,
            safe: format!(
                "the board goes on sampling; {} scans are in {}, and what they belong to in {}",
                taped.scans,
                out.display(),
                note.display()
            ),
            next: format!(
                "keep those under other names if you need them, then record anew by\n         {}",
                same_again()
            ),
        }
    }

    /// What the recording belongs to, and what is in it when it is complete.
    fn note(&self, taped: Option<&Taped>, set: Option<SetId>, board: &BoardRecord) -> String {
        let mut note = json!({
            "board": board.board,
            "firmware": board.firmware,
            "set": set.map(|set| set.to_string()),
            "rate_hz": self.scanning.rate,
            "block": self.block.scans(),
        });
        if let Some(taped) = taped {
            let gaps = taped.gaps.iter();
            let gaps = gaps.map(|gap| json!({"first_scan": gap.first_scan, "scans": gap.scans}));
            note["scans"] = taped.scans.into();
            note["scans_lost"] = taped.lost.into();
            note["gaps"] = gaps.collect();
        }
        format!("{note:#}\n")
    }
}
