//! `cargo xtask bench sample-path`: the sample path and what others offer, counted on the same core with the same data.
//!
//! The figures are instructions for each scan of nine channels. The sample path calibrates every scan and keeps twelve
//! regressors of every channel; what the others do for their figure is said beside it. Errors are relative to a fit in
//! double precision of the same counts: a sine of 0.5 Hz on gravity at 1 kHz, three periods.

use anyhow::Context;
use hexsense_core::harmonics::Series;
use serde::Serialize;

use crate::build::{self, Parts, cargo};
use crate::counting::{CountingBoard, Counts};
use crate::process::checked;
use crate::setup::{self, BOARD_TARGET};

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

/// `cargo xtask bench sample-path`
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Print one JSON document on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

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

#[derive(Debug, Serialize)]
struct Figures {
    blocks_of_each_size: u64,
    blocks: Vec<Block>,
    analyser_bytes: u64,
    amplitude_error: f64,
    peers: Vec<Peer>,
}

/// Builds the program, runs it on the virtual board and prints its figures; fails when a part takes a time that
/// depends on data.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let figures = measure()?;
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&figures)?);
    } else {
        print_table(&figures);
    }
    Ok(())
}

/// Symbols of the sample path in the program, in blocks of every size.
pub fn path_symbols() -> Vec<String> {
    let sized = |scans: &u64| PARTS.map(|part| format!("{part}_{scans}"));
    BLOCKS.iter().flat_map(sized).collect()
}

/// Builds the program.
pub fn build() -> anyhow::Result<()> {
    setup::board_target()?;
    let bench = ["--package", "sample-path-bench", "--profile", "firmware"];
    checked(cargo("build").args(bench).args(["--target", BOARD_TARGET]))
}

fn measure() -> anyhow::Result<Figures> {
    setup::emulator_packages()?;
    build()?;
    checked(cargo("build").args(["--package", "virtual-board"]))?;
    let parts = Parts::find()?;
    let elf = parts.sample_path_bench();
    let count: Vec<_> = path_symbols()
        .into_iter()
        .chain(PEERS.map(str::to_owned))
        .collect();
    let folder = build::workspace().join("target").join("sample-path-bench");
    let mut board = CountingBoard::start(&parts.virtual_board, &elf, &folder, None, &count)?;
    let log = board.run_until("finished", 120)?;
    figures(&board.counts()?, &log)
}

fn figures(counts: &Counts, log: &[String]) -> anyhow::Result<Figures> {
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
    Ok(Figures {
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

fn print_table(figures: &Figures) {
    println!(
        "instructions on the Cortex-M4, {} blocks of each size, fewest = most",
        figures.blocks_of_each_size
    );
    println!(
        "{:>5} | {:>9} {:>9} | {:>9} {:>9} | {:>9} {:>9}",
        "scans", "path", "a scan", "sums", "a scan", "15 ch.", "a scan"
    );
    for block in &figures.blocks {
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
        figures.analyser_bytes, figures.amplitude_error
    );
    for peer in &figures.peers {
        println!(
            "{:<20} {:>7.0} a scan, {:>5.1} times ours, amplitude error {:>8.1e} ({})",
            peer.name, peer.per_scan, peer.ratio, peer.amplitude_error, peer.does
        );
    }
}
