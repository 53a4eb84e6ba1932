//! `cargo xtask bench sample-path`: the sample path and what others offer, counted on the same core with the same data.
//!
//! The figures are instructions for each scan of nine channels. The sample path calibrates every scan and keeps twelve
//! regressors of every channel; what the others do for their figure is said beside it. Errors are relative to a fit in
//! double precision of the same counts: a sine of 0.5 Hz on gravity at 1 kHz, three periods.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, bail};
use hexsense_core::harmonics::Series;
use serde::Serialize;

use crate::counts::Counts;
use crate::figures::Figures;
use crate::folders;
use crate::line::Line;
use crate::power::{self, Power};
use crate::programs::Program;

/// Calibrated values and sums of nine channels; those sums alone; and calibrated values with the sums of fifteen.
const PARTS: [&str; 3] = ["path", "sums", "path_with_jacks"];
const BLOCKS: [u64; 5] = [1, 4, 8, 16, 32];
const PEERS: [&str; 4] = [
    "peer_goertzel_scan",
    "peer_idsp_scan",
    "peer_microfft_scan",
    "peer_microfft_window",
];
/// Scans that go into one transform.
const SCANS_OF_A_TRANSFORM: u64 = 4_096;

/// Longest virtual time that the program may take.
const LIMIT_S: u32 = 120;

/// Figures for one size of block, whole instructions for each block.
#[derive(Debug, Serialize)]
struct Block {
    scans: u64,
    /// Calibrated values and sums of nine channels.
    path: u64,
    /// Sums of nine channels alone.
    sums: u64,
    /// Calibrated values of nine channels and sums of fifteen.
    path_with_jacks: u64,
    path_per_scan: f64,
    sums_per_scan: f64,
    path_with_jacks_per_scan: f64,
}

#[derive(Debug, Serialize)]
struct Peer {
    name: &'static str,
    does: &'static str,
    per_scan: f64,
    /// Instructions for each scan, as a multiple of the sample path's in blocks of sixteen.
    ratio: f64,
    amplitude_error: f64,
}

/// Figures of the sample path and of the others.
#[derive(Debug, Serialize)]
pub struct SamplePath {
    blocks_of_each_size: u64,
    blocks: Vec<Block>,
    analyser_bytes: u64,
    amplitude_error: f64,
    peers: Vec<Peer>,
}

/// Symbols of the sample path in the program, for blocks of every size.
#[must_use]
pub fn symbols() -> Vec<String> {
    let sized = |scans: &u64| PARTS.map(|part| format!("{part}_{scans}"));
    BLOCKS.iter().flat_map(sized).collect()
}

/// Runs the program.
pub fn measure() -> anyhow::Result<SamplePath> {
    let symbols = symbols();
    let count: Vec<&str> = symbols.iter().map(String::as_str).chain(PEERS).collect();
    let (counts, log) = run(&count, "finished")?;
    figures(&counts, &log)
}

/// Runs the program until a line of its log begins with `last`; the calls of `count`, and the log.
pub fn run(count: &[&str], last: &str) -> anyhow::Result<(Counts, Vec<String>)> {
    let folder = folders::emptied("sample-path")?;
    let power = Power {
        count,
        ..Power::default()
    };
    let mut board = power.on(Program::SamplePathBench, &folder)?;
    let mut line = Line::open(board.address("link")?)?;
    for _ in 0..LIMIT_S {
        line.run(Duration::from_secs(1))?;
        let log = logged(&folder);
        if let Some(panic) = log.iter().find(|said| said.starts_with("panic")) {
            bail!("{panic}");
        }
        if log.iter().any(|said| said.starts_with(last)) {
            drop(line);
            return Ok((Counts::read(&mut board)?, log));
        }
    }
    bail!("the program was not done after {LIMIT_S} s of virtual time")
}

/// The lines of the log without their times, which stand before them in brackets, and places, which stand behind them in
/// parentheses.
fn logged(folder: &Path) -> Vec<String> {
    let log = power::log(folder);
    let said = log.lines().filter_map(|line| {
        let (_, said) = line.split_once(']')?;
        let said = said.rsplit_once("  (").map_or(said, |(said, _)| said);
        Some(said.trim().to_owned())
    });
    said.collect()
}

fn figures(counts: &Counts, log: &[String]) -> anyhow::Result<SamplePath> {
    let blocks = BLOCKS
        .iter()
        .map(|scans| block(counts, *scans))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let sixteen = blocks
        .iter()
        .find(|block| block.scans == 16)
        .context("blocks of sixteen were measured")?;
    let truth = truth()?;
    let error = |name: &str| -> anyhow::Result<f64> {
        let bits = said(log, &format!("amplitude {name} "))?;
        Ok(f64::from_bits(bits) / truth - 1.0)
    };
    let mean = |name: &str| -> anyhow::Result<f64> {
        let count = counts.of(name).next().context("every peer was counted")?;
        Ok(count.total as f64 / count.calls as f64)
    };
    let peer = |name, does, per_scan: f64| -> anyhow::Result<Peer> {
        Ok(Peer {
            name,
            does,
            per_scan,
            ratio: per_scan / sixteen.path_per_scan,
            amplitude_error: error(name)?,
        })
    };
    let transform = mean(PEERS[2])? + mean(PEERS[3])? / SCANS_OF_A_TRANSFORM as f64;
    let peers = vec![
        peer(
            "goertzel_algorithm",
            "one frequency, no calibration",
            mean(PEERS[0])?,
        )?,
        peer(
            "microfft",
            "1024 points over means of four scans, no calibration",
            transform,
        )?,
        peer(
            "idsp",
            "45 lock-ins, five harmonics, no calibration",
            mean(PEERS[1])?,
        )?,
    ];
    Ok(SamplePath {
        blocks_of_each_size: counts.of("path_16").map(|count| count.calls).sum(),
        amplitude_error: error("hexsense")?,
        analyser_bytes: said(log, "analyser bytes ")?,
        blocks,
        peers,
    })
}

fn block(counts: &Counts, scans: u64) -> anyhow::Result<Block> {
    let of = |part: &str| counts.fixed(&format!("{part}_{scans}"));
    let [path, sums, path_with_jacks] = PARTS.map(of);
    let (path, sums, path_with_jacks) = (path?, sums?, path_with_jacks?);
    let per_scan = |instructions: u64| instructions as f64 / scans as f64;
    Ok(Block {
        scans,
        path,
        sums,
        path_with_jacks,
        path_per_scan: per_scan(path),
        sums_per_scan: per_scan(sums),
        path_with_jacks_per_scan: per_scan(path_with_jacks),
    })
}

fn said(log: &[String], what: &str) -> anyhow::Result<u64> {
    log.iter()
        .find_map(|line| line.strip_prefix(what)?.parse().ok())
        .with_context(|| format!("the program did not say `{what}`"))
}

/// Amplitude of the very counts that the program takes, by a fit in double precision.
fn truth() -> anyhow::Result<f64> {
    let omega = core::f64::consts::TAU * 0.5 / 1_000.0;
    let counts: Vec<f64> = (0..6_000)
        .map(|n| (32_768.0 + 2_000.0 * (9.806_65 + (omega * f64::from(n) - 0.7).cos())).round())
        .collect();
    let fit = Series::fit(omega, &counts).context("the signal determines its fit")?;
    Ok(fit.first().amplitude())
}

impl Figures for SamplePath {
    fn print_table(&self) {
        println!(
            "instructions on the Cortex-M4, {} blocks of each size, fewest = most",
            self.blocks_of_each_size
        );
        println!(
            "{:>5} | {:>9} {:>9} | {:>9} {:>9} | {:>9} {:>9}",
            "scans", "path", "a scan", "sums", "a scan", "15 ch.", "a scan"
        );
        for block in &self.blocks {
            println!(
                "{:>5} | {:>9} {:>9.1} | {:>9} {:>9.1} | {:>9} {:>9.1}",
                block.scans,
                block.path,
                block.path_per_scan,
                block.sums,
                block.sums_per_scan,
                block.path_with_jacks,
                block.path_with_jacks_per_scan
            );
        }
        println!(
            "path: nine channels calibrated, twelve regressors each; an analyser takes {} bytes; amplitude error {:.1e}\n",
            self.analyser_bytes, self.amplitude_error
        );
        for peer in &self.peers {
            println!(
                "{:<20} {:>7.0} a scan, {:>5.1} times ours, amplitude error {:>8.1e} ({})",
                peer.name, peer.per_scan, peer.ratio, peer.amplitude_error, peer.does
            );
        }
    }

    /// Nothing more: where times depend on data there are no figures.
    fn check(&self) -> anyhow::Result<()> {
        Ok(())
    }
}
