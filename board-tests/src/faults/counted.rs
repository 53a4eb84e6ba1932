//! Every loss is counted: each fault appears in the counters of the status exactly as often as it is injected, and the scans
//! that are missing from the stream are those that the counters name.

use std::time::Duration;

use anyhow::ensure;
use hexsense_core::wire::status::{Events, Status};
use hexsense_core::wire::{Request, StreamContent};
use serde_json::{Value, json};

use super::gaps::Gaps;
use super::outcome::Outcome;
use crate::bench::{Bench, Board};
use crate::key_holder::calibrate;
use crate::trial_set::Random;

/// When the first fault comes, and how far the next are apart.
const FIRST_S: f64 = 0.5;
const APART_S: f64 = 0.1;
/// The archive begins here; every look at the history reads it.
const ARCHIVE: &str = "0x08040000";

/// A kind of fault, and the counter that must show it.
struct Kind {
    name: &'static str,
    fault: Value,
    /// What the host sends around the fault.
    sends: Sends,
    counter: fn(&Events) -> u32,
    /// Whether one fault may count several times.
    several: bool,
}

/// What the host sends.
enum Sends {
    /// One request for the status.
    Status,
    /// Zeros for ten milliseconds. They make no frame.
    Zeros,
    /// A look at the history, which reads the flash.
    History,
}

fn kinds() -> Vec<Kind> {
    let line = |effect: &str, characters: u32| json!({"fault": "line", "towards": "board", "effect": effect, "characters": characters});
    let kind = |name, fault, sends, counter: fn(&Events) -> u32| Kind {
        name,
        fault,
        sends,
        counter,
        several: false,
    };
    let slip = |adc: u8, result: &str| json!({"fault": "dma_slip", "adc": adc, "result": result});
    let slips = |events: &Events| events.slips.count;
    vec![
        kind(
            "inertial result lost",
            slip(1, "lost"),
            Sends::Status,
            slips,
        ),
        kind(
            "inertial result taken twice",
            slip(1, "twice"),
            Sends::Status,
            slips,
        ),
        kind("jack result lost", slip(2, "lost"), Sends::Status, slips),
        kind(
            "jack result taken twice",
            slip(2, "twice"),
            Sends::Status,
            slips,
        ),
        kind(
            "converters' DMA held up",
            json!({"fault": "dma_stall", "of": "converters", "duration_us": 300}),
            Sends::Status,
            |events| events.overruns.count,
        ),
        Kind {
            // The converters count as stuck after 12 ms, and are started anew each time.
            several: true,
            ..kind(
                "triggers missed",
                json!({"fault": "trigger_stall", "duration_us": 40_000}),
                Sends::Status,
                |events| events.stuck.count,
            )
        },
        kind(
            "noise on the line",
            line("noise", 1),
            Sends::Status,
            |events| events.receiver_errors.count,
        ),
        kind(
            "missing stop bit",
            line("framing", 1),
            Sends::Status,
            |events| events.receiver_errors.count,
        ),
        kind(
            "damaged character",
            line("damaged", 1),
            Sends::Status,
            Events::frames_damaged,
        ),
        kind(
            "lost characters",
            line("lost", 2),
            Sends::Status,
            Events::frames_damaged,
        ),
        kind(
            "receiver's DMA held up",
            json!({"fault": "dma_stall", "of": "receiver", "duration_us": 200}),
            Sends::Zeros,
            |events| events.receiver_overruns.count,
        ),
        Kind {
            several: true,
            ..kind(
                "transmitter's DMA held up",
                json!({"fault": "dma_stall", "of": "transmitter", "duration_us": 40_000}),
                Sends::Status,
                |events| events.blocks_dropped.count,
            )
        },
        Kind {
            several: true,
            ..kind(
                "one wrong bit in flash",
                json!({"fault": "bit_error", "address": ARCHIVE, "bits": 1}),
                Sends::History,
                |events| events.flash_corrections.count,
            )
        },
        Kind {
            several: true,
            ..kind(
                "two wrong bits in flash",
                json!({"fault": "bit_error", "address": ARCHIVE, "bits": 2}),
                Sends::History,
                |events| events.torn_words.count,
            )
        },
    ]
}

/// Injects each kind of fault `times` times.
pub fn inject(seed: u64, times: u32) -> anyhow::Result<Outcome> {
    let kinds = kinds();
    let mut outcome = Outcome::new("counted", 100.min(u64::from(times) * kinds.len() as u64));
    let bench = Bench::new("faults/counted", seed)?;
    let mut random = Random(seed as u32 | 1);
    calibrate(&mut bench.on(&[])?.line, &mut random)?;
    bench.keep("calibrated")?;
    for kind in &kinds {
        bench.restore("calibrated")?;
        let done = several(&bench, kind, times, &mut random, &mut outcome);
        outcome.settle(done.map_err(|error| error.context(kind.name)));
    }
    bench.restore("calibrated")?;
    let done = starts(&bench, &mut outcome);
    outcome.settle(done);
    Ok(outcome)
}

/// Injects one kind of fault `times` times.
fn several(
    bench: &Bench,
    kind: &Kind,
    times: u32,
    random: &mut Random,
    outcome: &mut Outcome,
) -> anyhow::Result<()> {
    let instants: Vec<f64> = (0..times)
        .map(|time| FIRST_S + APART_S * (f64::from(time) + 0.2 * f64::from(random.share())))
        .collect();
    let at = |at_s: &f64| {
        let mut fault = kind.fault.clone();
        fault["at_s"] = json!(at_s);
        fault
    };
    let faults: Vec<Value> = instants.iter().map(at).collect();
    let mut board = bench.on(&faults)?;
    board.line.stream_everything()?;
    let before = board.line.status()?;
    let mut gaps = Gaps::default();
    for at_s in instants {
        provoke(&mut board, &kind.sends, at_s)?;
        outcome.inject();
        gaps.follow(&mut board.line);
    }
    let after = quiet(&mut board, &mut gaps)?;
    let counted = (kind.counter)(&after.events) - (kind.counter)(&before.events);
    let right = counted == times || kind.several && counted > times;
    outcome.check(right, || {
        format!(
            "{}: {times} times, but counted {counted}: {:?}",
            kind.name, after.events
        )
    });
    let block = after.block.scans() as u64;
    let lost = after.scans_lost - before.scans_lost;
    let unexplained = gaps.unexplained(lost, block);
    outcome.lose(unexplained, || {
        format!("{}: {gaps:?}, the board says {lost}", kind.name)
    });
    let told = gaps.frames * 16 + gaps.dropped * block + lost;
    outcome.check(gaps.missing == told, || {
        format!("{}: told of {told} scans, but {gaps:?}", kind.name)
    });
    Ok(())
}

/// Sends what the host sends around a fault at `at_s`.
fn provoke(board: &mut Board, sends: &Sends, at_s: f64) -> anyhow::Result<()> {
    let line = &mut board.line;
    let at = Duration::from_secs_f64(at_s);
    match sends {
        Sends::Status => {
            line.run_until(at)?;
            line.send(&Request::Status)?;
        }
        Sends::Zeros => {
            line.run_until(at - Duration::from_millis(2))?;
            line.send_bytes(&[0; 1_500])?;
        }
        Sends::History => {
            line.run_until(at)?;
            line.ask(&Request::History { age: 0 })?;
        }
    }
    line.run(Duration::from_millis(60))
}

/// The status after a last time without faults.
fn quiet(board: &mut Board, gaps: &mut Gaps) -> anyhow::Result<Status> {
    board.line.run(Duration::from_millis(200))?;
    let status = board.line.status()?;
    board
        .line
        .order(&Request::Stream(StreamContent::default()))?;
    board.line.run(Duration::from_millis(50))?;
    gaps.follow(&mut board.line);
    Ok(status)
}

/// Resets of every cause without a power cut between them: each reset and each start is counted.
fn starts(bench: &Bench, outcome: &mut Outcome) -> anyhow::Result<()> {
    let kinds = [
        json!({"fault": "pin_reset"}),
        json!({"fault": "brown_out", "ram_kept": true}),
        json!({"fault": "hang"}),
        json!({"fault": "jump", "address": "0xf0000000"}),
    ];
    const ROUNDS: u32 = 3;
    const APART_S: f64 = 1.5;
    let mut faults = Vec::new();
    for _ in 0..ROUNDS {
        for kind in &kinds {
            let mut fault = kind.clone();
            fault["at_s"] = json!(1.0 + APART_S * faults.len() as f64);
            faults.push(fault);
        }
    }
    let mut board = bench.on(&faults)?;
    let until_s = 1.0 + APART_S * faults.len() as f64;
    board.line.run_until(Duration::from_secs_f64(until_s))?;
    outcome.inject_many(faults.len() as u64);
    let resets = board.line.status()?.resets;
    let counts = [
        resets.pin,
        resets.brown_outs,
        resets.watchdog,
        resets.panics,
    ];
    ensure!(
        counts == [ROUNDS; 4] && resets.starts == 1 + 4 * ROUNDS,
        "each of four causes {ROUNDS} times, but counted {resets:?}"
    );
    Ok(())
}
