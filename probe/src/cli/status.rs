//! `hexsense status`: the state of the board.

use clap::Args;
use hexsense_core::facts::BoardFacts;
use hexsense_core::records::log::capacity;
use hexsense_core::wire::message::ActiveSet;
use hexsense_core::wire::status::{PathCycles, ResetCause, StackUse};
use hexsense_core::wire::{AnalyserState, Status as BoardStatus, StreamContent};
use serde_json::{Value, json};

use super::arguments::Port;
use crate::board_events;
use crate::option_bytes;
use crate::record::board::Streaming;
use crate::terminal::{self, one_line};
use hexsense_client::client::SumsReport;
use hexsense_client::{Client, LinkError};

/// Clock of the board's core, Hz, which counts the cycles of the sample path.
const CORE_HZ: f64 = 150e6;

/// Print the state of the board: sampling and restarts, the time that the sample path takes, analysers, link, clock, supply,
/// temperature, key, active set, why it started, stack, option bytes of the chip, last panic.
///
/// Each kind of event that went wrong since the start is printed as an `event`, with its count and the time of the last
/// one. Starts and their causes are counted since the power came on.
///
/// The board counts the core cycles that the sample path takes for each block, from the samples in memory to sums and
/// values. The least, the most and the latest count since the converters were last started are printed, with the time at
/// 150 MHz and the share of a block's duration. Asking changes nothing: a stream that is on goes on.
#[derive(Args)]
pub struct Status {
    #[command(flatten)]
    port: Port,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Status {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        Ok(terminal::print(&text(&mut self.port.open()?, self.json)?)?)
    }
}

/// What the command prints of a board.
///
/// # Errors
/// What the link reports.
pub fn text(client: &mut Client, json: bool) -> anyhow::Result<String> {
    let reading = Reading::take(client)?;
    Ok(match json {
        true => format!("{}\n", reading.to_json()),
        false => reading.table(),
    })
}

/// The board's answers.
struct Reading {
    status: BoardStatus,
    last_start: ResetCause,
    facts: BoardFacts,
    active: Option<ActiveSet>,
    analysers: Vec<SumsReport>,
}

/// The streams whose share of the link is printed.
const STREAMS: [(&str, StreamContent); 3] = [
    ("counts", stream(true, false, false)),
    ("counts and values", stream(true, true, false)),
    ("counts, values and pose", stream(true, true, true)),
];

const fn stream(counts: bool, values: bool, pose: bool) -> StreamContent {
    StreamContent {
        counts,
        values,
        pose,
    }
}

impl Reading {
    fn take(client: &mut Client) -> Result<Self, LinkError> {
        let status = client.status()?;
        let identity = client.identity()?;
        let analysers = 0..status.analysers.len() as u8;
        let analysers = analysers.map(|analyser| client.sums(analyser, 0));
        Ok(Self {
            analysers: analysers.collect::<Result<_, _>>()?,
            active: client.active_set()?,
            last_start: identity.reset,
            facts: identity.facts,
            status,
        })
    }

    fn table(&self) -> String {
        let status = &self.status;
        let mut lines = vec![
            ("uptime", format!("{:.1} s", seconds(status))),
            (
                "scans",
                format!(
                    "{} at {} Hz in blocks of {}",
                    status.scans,
                    status.rate_hz,
                    status.block.scans()
                ),
            ),
            ("restarts", self.restarts()),
        ];
        lines.extend(
            board_events::texts(&status.events)
                .into_iter()
                .map(|text| ("event", text)),
        );
        lines.push(("sample path", self.path()));
        for (number, analyser) in self.analysers.iter().enumerate() {
            lines.push((ANALYSER[number.min(2)], self.analyser(analyser)));
        }
        lines.extend([
            ("link", self.link()),
            ("clock", clock(status).to_owned()),
            ("supply", self.supply()),
            ("temperature", self.temperature()),
        ]);
        if let Some([roll, pitch]) = status.tilt_approximate_rad {
            let (roll, pitch) = (roll.to_degrees(), pitch.to_degrees());
            lines.push(("tilt, rough", format!("roll {roll:.1}°, pitch {pitch:.1}°")));
        }
        lines.push(("key", key(status).to_owned()));
        let set = match self.active {
            Some(set) => format!("set {}, uploaded with change {}", set.id, set.sequence),
            None => "none; calibrate and upload a set".to_owned(),
        };
        lines.push(("coefficients", set));
        lines.push(("log", log(status.log_used, capacity(&self.facts.flash))));
        lines.push((
            "last start",
            board_events::last_start(self.last_start, &status.resets),
        ));
        lines.push(("starts", board_events::starts(&status.resets)));
        lines.push(("stack", stack(status.stack)));
        lines.push(("option bytes", option_bytes::text(&status.option_bytes)));
        let panic = status.panic.as_deref().unwrap_or("none");
        lines.push(("last panic", one_line(panic).to_string()));
        let row = |(name, text): (&str, String)| format!("{name:<14} {text}\n");
        lines.into_iter().map(row).collect()
    }

    /// Starts of the converters anew. The scans that pass meanwhile are in no recording, because one begins after them;
    /// what a recording lost is said by the recording.
    fn restarts(&self) -> String {
        restarts(
            self.status.scans_lost,
            self.status.first_lost_scan,
            self.status.events.converter_faults(),
        )
    }

    fn path(&self) -> String {
        let PathCycles { min, max, last } = self.status.path_cycles;
        if max == 0 {
            return "not measured yet".to_owned();
        }
        let one = |cycles: u32| format!("{cycles} cycles ({:.1} µs)", micros(cycles));
        format!(
            "{} to {}, latest {}; at most {:.2} % of a block's {:.1} ms",
            one(min),
            one(max),
            one(last),
            percent(self.block_share(max)),
            1e3 * self.block_s()
        )
    }

    /// Duration of a block, s.
    fn block_s(&self) -> f64 {
        self.status.block.scans() as f64 / f64::from(self.status.rate_hz.max(1))
    }

    fn block_share(&self, cycles: u32) -> f64 {
        f64::from(cycles) / CORE_HZ / self.block_s()
    }

    fn analyser(&self, report: &SumsReport) -> String {
        let frequency = format!("{:.6} Hz", self.frequency_hz(report));
        match report.state {
            AnalyserState::Idle => "idle".to_owned(),
            state => format!(
                "{frequency}, {}, {} of {} blocks left",
                state_name(state),
                self.blocks_left(report),
                report.drive.blocks
            ),
        }
    }

    fn frequency_hz(&self, report: &SumsReport) -> f64 {
        report.drive.frequency_hz(self.status.rate_hz)
    }

    /// Blocks that are still to be summed.
    fn blocks_left(&self, report: &SumsReport) -> u64 {
        let (status, blocks) = (&self.status, u64::from(report.drive.blocks));
        // Each is below 2^53.
        let next_scan = status.scans + status.scans_lost;
        match report.state {
            AnalyserState::Idle | AnalyserState::Complete => 0,
            AnalyserState::Settling => blocks,
            AnalyserState::Summing => {
                let taken = next_scan.saturating_sub(report.first_scan);
                blocks.saturating_sub(taken / report.drive.block.scans() as u64)
            }
        }
    }

    fn link(&self) -> String {
        let status = &self.status;
        let loads = STREAMS.map(|(name, content)| match self.load(content) {
            load if load > 1.0 => format!("{name} do not fit"),
            load => format!("{name} take {:.0} %", percent(load)),
        });
        format!(
            "of {:.1} Mbit/s for telemetry, {}; {} blocks dropped, {} damaged frames",
            f64::from(self.facts.max_telemetry_bits_per_s()) * 1e-6,
            loads.join(", "),
            status.events.blocks_dropped.count,
            status.events.frames_damaged()
        )
    }

    /// `None` before the first reading.
    fn supply_v(&self) -> Option<f32> {
        let known = self.status.supply_readings > 0;
        known.then_some(self.status.supply * self.facts.nominal_supply_v)
    }

    /// `None` before the first reading.
    fn temperature_c(&self) -> Option<f32> {
        let known = self.status.supply_readings > 0;
        known.then_some(self.status.temperature_c)
    }

    /// The supply, how settled its mean is, and whether it is still true.
    fn supply(&self) -> String {
        let status = &self.status;
        let old = match status.supply_is_old {
            true => {
                ", OLD: no good reading for a second. Recordings are refused; look at the board's supply"
            }
            false => "",
        };
        let Some(supply_v) = self.supply_v() else {
            return format!("not known yet{old}");
        };
        let settling = match status.supply_readings {
            AVERAGED.. => String::new(),
            readings => format!(", settling: mean of {readings} readings of {AVERAGED}"),
        };
        format!("{supply_v:.3} V{settling}{old}")
    }

    /// Share of the link's capacity that a stream takes at the board's rate and block.
    fn load(&self, content: StreamContent) -> f64 {
        let BoardStatus { rate_hz, block, .. } = self.status;
        Streaming {
            rate_hz,
            block,
            content,
        }
        .link_load(&self.facts)
    }

    fn temperature(&self) -> String {
        let range = match (&self.active, self.status.in_calibrated_range) {
            (None, _) => "",
            (Some(_), true) => ", within 10 K of the calibration",
            (Some(_), false) => ", more than 10 K from the calibration: calibrate again",
        };
        match self.temperature_c() {
            Some(temperature_c) => format!("{temperature_c:.1} °C{range}"),
            None => "not known yet".to_owned(),
        }
    }

    fn to_json(&self) -> Value {
        let status = &self.status;
        let PathCycles { min, max, last } = status.path_cycles;
        let cycles = |cycles: u32| {
            json!({
                "cycles": cycles,
                "us": micros(cycles),
                "block_percent": percent(self.block_share(cycles)),
            })
        };
        let analysers = self.analysers.iter().map(|report| {
            let idle = report.state == AnalyserState::Idle;
            json!({
                "state": state_name(report.state),
                "frequency_hz": (!idle).then(|| self.frequency_hz(report)),
                "blocks": report.drive.blocks,
                "blocks_left": self.blocks_left(report),
            })
        });
        let loads =
            STREAMS.map(|(name, content)| (name.to_owned(), percent(self.load(content)).into()));
        json!({
            "uptime_s": seconds(status),
            "rate_hz": status.rate_hz,
            "block": status.block.scans(),
            "scans": status.scans,
            "scans_lost": status.scans_lost,
            "first_lost_scan": status.first_lost_scan,
            "faults": status.events.converter_faults(),
            "events": board_events::to_json(&status.events),
            "first_with_set_ms": status.first_with_set_ms,
            "sample_path": {"min": cycles(min), "max": cycles(max), "last": cycles(last)},
            "analysers": analysers.collect::<Vec<_>>(),
            "link": {
                "limit_bits_per_s": self.facts.max_telemetry_bits_per_s(),
                "load_percent": Value::Object(loads.into_iter().collect()),
                "blocks_dropped": status.events.blocks_dropped.count,
                "frames_damaged": status.events.frames_damaged(),
            },
            "clock": if status.crystal { "crystal" } else { "internal" },
            "supply_v": self.supply_v(),
            "supply_readings": status.supply_readings,
            "supply_is_old": status.supply_is_old,
            "temperature_c": self.temperature_c(),
            "in_calibrated_range": self.active.map(|_| status.in_calibrated_range),
            "tilt_approximate_rad": status.tilt_approximate_rad,
            "provisioned": status.provisioned,
            "key_damaged": status.key_damaged,
            "set": self.active.map(|set| json!({"id": set.id.to_string(), "sequence": set.sequence})),
            "log": {"used": status.log_used, "capacity": capacity(&self.facts.flash)},
            "start": board_events::starts_to_json(self.last_start, &status.resets),
            "stack": {"deepest_bytes": status.stack.deepest, "bytes": status.stack.size},
            "panic": status.panic.as_deref(),
            "option_bytes": option_bytes::to_json(&status.option_bytes),
        })
    }
}

/// What passed while the converters were started anew.
fn restarts(scans: u64, first: Option<u64>, faults: u32) -> String {
    let first = first.map_or(String::new(), |scan| format!(", the first was scan {scan}"));
    let why = match faults {
        0 => "rate or block changed; none after a fault".to_owned(),
        1 => "once after a fault".to_owned(),
        faults => format!("{faults} times after a fault"),
    };
    match (scans, faults) {
        (0, 0) => "none since the start".to_owned(),
        _ => format!(
            "of the converters ({why}): {scans} scans passed meanwhile{first}; what a recording lost stands in its note"
        ),
    }
}

/// Readings of the supply that the board averages.
const AVERAGED: u8 = 16;
/// Names of the analysers' lines.
const ANALYSER: [&str; 3] = ["analyser 0", "analyser 1", "analyser 2"];

fn seconds(status: &BoardStatus) -> f64 {
    status.uptime_ms as f64 / 1e3
}

fn stack(StackUse { deepest, size }: StackUse) -> String {
    format!("{deepest} of {size} bytes used at most")
}

/// How full the log is; from nine tenths on with what to do.
fn log(used: Option<u32>, capacity: u32) -> String {
    let Some(used) = used else {
        return "none: the flash holds what this firmware did not write; `hexsense provision` takes it for the board"
            .to_owned();
    };
    let level = format!("{used} of {capacity} entries");
    let advice =
        "export it and begin its next volume with `hexsense log --export FILE --new-volume`";
    if used >= capacity {
        format!("{level}, FULL: the board takes no change but a new key; {advice}")
    } else if u64::from(used) * 10 >= u64::from(capacity) * 9 {
        format!("{level}, nearly full; {advice}")
    } else {
        level
    }
}

fn clock(status: &BoardStatus) -> &'static str {
    if status.crystal {
        "crystal"
    } else {
        "internal oscillator, about 1 % off: not fit to calibrate"
    }
}

/// Whether the board has a key, in words.
pub(super) fn key(status: &BoardStatus) -> &'static str {
    match (status.key_damaged, status.provisioned) {
        (true, _) => {
            "DAMAGED: the board takes no changes from anybody and measures on; to give it another key, erase flash bank 2 \
             with a debug probe, sets and log included, then provision it and upload again"
        }
        (false, true) => "provisioned; the board takes changes only with its key",
        (false, false) => {
            "NONE: the board takes no changes until `hexsense provision` gives it a key"
        }
    }
}

fn micros(cycles: u32) -> f64 {
    1e6 * f64::from(cycles) / CORE_HZ
}

fn percent(share: f64) -> f64 {
    100.0 * share
}

fn state_name(state: AnalyserState) -> &'static str {
    match state {
        AnalyserState::Idle => "idle",
        AnalyserState::Settling => "settling",
        AnalyserState::Summing => "summing",
        AnalyserState::Complete => "complete",
    }
}

#[cfg(test)]
mod tests;
