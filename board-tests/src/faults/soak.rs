//! The soak: at 4 kHz all channels stream for a virtual hour, while faults of all kinds come at random instants.
//! Every scan that is missing must lie in a gap that the board announced.
//!
//! A board that was reset no longer streams. The host notices this, asks for the reason and starts the stream again; the
//! scans between are an announced gap. From one reset to the next, [`Gaps`] and the status account for every scan.

use std::time::Duration;

use hexsense_core::wire::{Request, Response, Status};
use serde_json::{Value, json};

use super::gaps::Gaps;
use super::outcome::Outcome;
use crate::bench::Bench;
use crate::key_holder::{Act, KeyHolder};
use crate::line::Line;
use crate::trial_set::Random;

/// When the first fault comes, s, and how far the next are apart at least and at most.
const FIRST_S: f64 = 2.0;
const APART_S: [f64; 2] = [3.0, 9.0];
/// How long the host looks at the stream before it asks how the board is.
const LOOK: Duration = Duration::from_millis(250);
/// A board that streams nothing for so long has been reset.
const SILENCE: Duration = Duration::from_millis(20);
/// Within this time a board that was reset samples with its coefficients, ms.
const STARTED_MS: u64 = 100;
/// The watchdog bites within a second.
const MAX_HANG: Duration = Duration::from_millis(1_300);
/// An upload in so many looks.
const UPLOAD_EVERY: u64 = 40;

/// Runs for `virtual_s` seconds of virtual time; the outcome is a part of the promise `recovery`.
pub fn soak(seed: u64, virtual_s: u64) -> anyhow::Result<Outcome> {
    let bench = Bench::new("faults/soak", seed)?;
    let mut random = Random(seed as u32 | 1);
    let faults = timeline(&mut random, virtual_s as f64);
    let mut board = bench.on(&faults)?;
    let mut soak = Soak {
        key_holder: KeyHolder::of(&mut board.line)?,
        random,
        outcome: Outcome::new("recovery", 0),
        gaps: Gaps::default(),
        born: Duration::ZERO,
        lost: 0,
        unexplained: 0,
        lives: 0,
        scans: 0,
        announced: 0,
    };
    soak.key_holder.provision(&mut board.line)?;
    soak.begin(&mut board.line)?;
    let end = Duration::from_secs(virtual_s);
    let mut look = 0;
    while board.line.now() < end {
        look += 1;
        soak.look(&mut board.line, look)?;
    }
    soak.outcome.inject_many(faults.len() as u64);
    let figures = json!({
        "virtual_s": virtual_s,
        "faults": faults.len(),
        "restarts": soak.lives - 1,
        "scans": soak.scans + soak.gaps.scans,
        "announced_lost": soak.announced + soak.gaps.missing,
    });
    soak.outcome.figure("soak", figures);
    Ok(soak.outcome)
}

/// Faults of all kinds at random instants.
fn timeline(random: &mut Random, virtual_s: f64) -> Vec<Value> {
    let mut faults = Vec::new();
    let mut at_s = FIRST_S;
    while at_s < virtual_s - FIRST_S {
        let mut fault = any(random);
        fault["at_s"] = json!(at_s);
        faults.push(fault);
        let share = f64::from(random.share()).abs();
        at_s += APART_S[0] + (APART_S[1] - APART_S[0]) * share;
    }
    faults
}

fn any(random: &mut Random) -> Value {
    let some = |random: &mut Random, most: u32| 1 + random.bits() % most;
    let line = |random: &mut Random, towards: &str, effect: &str| {
        let characters = some(random, 20);
        json!({"fault": "line", "towards": towards, "effect": effect, "characters": characters})
    };
    match random.bits() % 17 {
        0 | 1 => {
            json!({"fault": "dma_stall", "of": "converters", "duration_us": some(random, 5_000)})
        }
        2 => json!({"fault": "dma_stall", "of": "receiver", "duration_us": some(random, 5_000)}),
        3 | 4 => json!({"fault": "trigger_stall", "duration_us": some(random, 50_000)}),
        5 => line(random, "board", "noise"),
        6 => line(random, "board", "framing"),
        7 => line(random, "board", "damaged"),
        8 => line(random, "host", "damaged"),
        9 => line(random, "host", "lost"),
        10 => json!({"fault": "bit_error", "address": "0x08040000", "bits": 1}),
        11 => json!({"fault": "pin_reset"}),
        12 => json!({"fault": "brown_out", "ram_kept": random.bits().is_multiple_of(2)}),
        13 => json!({"fault": "jump", "address": "0xf0000000"}),
        14 => json!({"fault": "stack_pointer", "address": "0x20000008"}),
        15 => {
            let result = ["lost", "twice"][random.bits() as usize % 2];
            json!({"fault": "dma_slip", "adc": some(random, 2), "result": result})
        }
        _ => json!({"fault": "hang"}),
    }
}

struct Soak {
    key_holder: KeyHolder,
    random: Random,
    outcome: Outcome,
    /// The gaps since the board's last reset.
    gaps: Gaps,
    /// When the board started after it.
    born: Duration,
    /// Scans that the board had lost since then when the stream began.
    lost: u64,
    /// Unexplained scans since then that are counted already.
    unexplained: u64,
    lives: u64,
    scans: u64,
    announced: u64,
}

impl Soak {
    /// Starts the stream. A fault on the line may hit the request, so it is sent again.
    fn begin(&mut self, line: &mut Line) -> anyhow::Result<()> {
        line.stream_everything()
            .or_else(|_| line.stream_everything())?;
        let status = line.status().or_else(|_| line.status())?;
        self.gaps = Gaps::default();
        self.born = born(line, &status);
        (self.lost, self.unexplained) = (status.scans_lost, 0);
        self.lives += 1;
        Ok(())
    }

    /// Follows the stream for a while, then compares what is missing with what the board says.
    fn look(&mut self, line: &mut Line, look: u64) -> anyhow::Result<()> {
        let until = line.now() + LOOK;
        while line.now() < until {
            line.run(SILENCE)?;
            if line.blocks.is_empty() {
                return self.find_out(line);
            }
            self.gaps.follow(line);
        }
        if look.is_multiple_of(UPLOAD_EVERY) {
            let set = self.random.set(self.key_holder.board);
            // A fault may hit the upload; whether the board keeps its sets then is another promise.
            let _ = self.key_holder.carry_out(line, &Act::Upload(Box::new(set)));
        }
        self.compare(line)
    }

    /// Asks for the status. When a fault on the line spoils the answer, the next look asks again. Blocks that arrive with the
    /// answer may be newer than it; the next look takes them.
    fn compare(&mut self, line: &mut Line) -> anyhow::Result<()> {
        let Some(status) = line.status_within(SILENCE)? else {
            return Ok(());
        };
        if born(line, &status) > self.born + SILENCE {
            return self.restarted(line);
        }
        let lost = status.scans_lost - self.lost;
        let unexplained = self.gaps.unexplained(lost, status.block.scans() as u64);
        let new = unexplained.saturating_sub(self.unexplained);
        self.outcome.lose(new, || {
            format!(
                "at {:?}: {:?}, the board says {lost}",
                line.now(),
                self.gaps
            )
        });
        self.unexplained += new;
        Ok(())
    }

    /// The stream has stopped: it goes on by itself, or the board reports a reset.
    fn find_out(&mut self, line: &mut Line) -> anyhow::Result<()> {
        let until = line.now() + MAX_HANG;
        while line.now() < until {
            let status = line.status_within(SILENCE)?;
            match status {
                Some(status) if born(line, &status) > self.born + SILENCE => {
                    return self.restarted(line);
                }
                _ if !line.blocks.is_empty() => return Ok(()),
                _ => {}
            }
        }
        self.outcome.lose(1, || {
            format!(
                "at {:?} it neither streams nor says that it was reset",
                line.now()
            )
        });
        self.live_on(line)
    }

    /// A board with an active set must have sampled with it in time.
    fn restarted(&mut self, line: &mut Line) -> anyhow::Result<()> {
        line.run(Duration::from_millis(STARTED_MS))?;
        let set = line.ask(&Request::ActiveSet);
        if let (Ok(Response::ActiveSet(Some(_))), Some(status)) =
            (set, line.status_within(SILENCE)?)
        {
            let soon = status.first_with_set_ms.is_some_and(|ms| ms <= STARTED_MS);
            self.outcome.check(soon, || {
                format!(
                    "at {:?}: first block with coefficients after {:?} ms",
                    line.now(),
                    status.first_with_set_ms
                )
            });
        }
        self.live_on(line)
    }

    /// Adds up the scans up to a reset, and starts the stream after it.
    fn live_on(&mut self, line: &mut Line) -> anyhow::Result<()> {
        self.scans += self.gaps.scans;
        self.announced += self.gaps.missing;
        self.begin(line)
    }
}

/// When the board started, by its status.
fn born(line: &Line, status: &Status) -> Duration {
    line.now()
        .saturating_sub(Duration::from_millis(status.uptime_ms))
}
