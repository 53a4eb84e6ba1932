//! `hexsense capture`: the stream of scans into a file.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use hexsense::sampling::BlockSize;
use hexsense::store::SetId;
use hexsense::wire::StreamContent;
use serde_json::json;

use super::arguments::{Port, Scanning};
use super::session;
use crate::campaign::BoardRecord;
use crate::files;
use crate::link::Client;
use crate::record::tape::{Tape, Taped};

/// How long the next block may take.
const BLOCK_WAIT: Duration = Duration::from_secs(2);

/// Record what the board measures into a CSV file, with a note of what it belongs to beside it.
///
/// The file has a row for each scan: its counter, the raw counts of all fifteen channels, the supply factor, the
/// temperature, and with --values the nine values that the board calibrated. Scans that do not arrive are missing rows,
/// and FILE.json lists them beside the rate, the board, and the set that was active. What the link cannot carry is
/// refused: at 4000 Hz it carries counts in blocks of 8 scans or more and no values.
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
        let mut client = self.port.open()?;
        let identity = client.identity()?;
        let board = session::board_record(&client, &identity);
        client.rate(self.scanning.rate)?;
        client.block_size(self.block)?;
        let content = StreamContent {
            counts: true,
            values: self.values,
            pose: false,
        };
        client.stream(content)?;
        eprintln!(
            "recording {} s at {} Hz in blocks of {}: {:.0} % of what the link carries",
            self.seconds,
            self.scanning.rate,
            self.block.scans(),
            100.0 * session::link_load(content, self.scanning.rate, self.block)
        );
        let recorded = self.record(&mut client);
        // The line may be what failed; the error at hand says so.
        let _ = client.stream(StreamContent::default());
        let (taped, set) = recorded?;
        let note = self.note(&taped, set, &board);
        files::replace(&self.out.with_extension("json"), &note)?;
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

    /// The recording on its tape, and the set that was active.
    fn record(&self, client: &mut Client) -> anyhow::Result<(Taped, Option<SetId>)> {
        let length = (self.seconds * f64::from(self.scanning.rate)).ceil() as u64;
        let mut tape = Tape::create(&self.out, self.values)?;
        let first = client.block(BLOCK_WAIT)?;
        let (start, set) = (first.header.first_scan, first.header.set);
        tape.push(&first)?;
        while tape.next_scan() < start + length {
            let block = client.block(BLOCK_WAIT)?;
            anyhow::ensure!(
                block.header.set == set,
                "the board's active set changed at scan {}; record again",
                block.header.first_scan
            );
            tape.push(&block)?;
        }
        Ok((tape.finish()?, set))
    }

    fn note(&self, taped: &Taped, set: Option<SetId>, board: &BoardRecord) -> String {
        let gaps = taped.gaps.iter();
        let gaps = gaps.map(|gap| json!({"first_scan": gap.first_scan, "scans": gap.scans}));
        let note = json!({
            "board": board.board,
            "firmware": board.firmware,
            "set": set.map(|set| set.to_string()),
            "rate_hz": self.scanning.rate,
            "block": self.block.scans(),
            "scans": taped.scans,
            "scans_lost": taped.lost,
            "gaps": gaps.collect::<Vec<_>>(),
        });
        format!("{note:#}\n")
    }
}
