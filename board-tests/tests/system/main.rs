//! The firmware's ELF on the virtual board, as part of `cargo xtask test`.
//!
//! - the demo twice from one seed: it holds, and every byte is the same again;
//! - streams at every rate: no scan is missing, values are those that the counts give, and what the link cannot carry is
//!   refused;
//! - the plug pulled in runs and in an upload: the host tool says so in time, nothing is half, the campaign goes on by
//!   itself or from its folder, and the upload can be repeated.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};
use hexsense_core::channel::{CHANNELS, NAMES};
use hexsense_probe::capture::Capture;
use hexsense_probe::replay::first_wrong_values;
use hexsense_probe::{coefficient_file, key_file};
use serde_json::Value;

use crate::bench::Bench;
use crate::build::{self, Parts};
use crate::demo;
use crate::process::{Beside, checked, output};
use crate::told::{self, Told};

/// A campaign takes less, on two busy cores.
const CAMPAIGN_TAKES: Duration = Duration::from_secs(180);
const SEED: u64 = 1;
const GEOMETRY: &str = "an-74tk-200";

/// The demo twice: it holds, and the second time gives the bytes of the first.
pub fn demo_twice() -> anyhow::Result<()> {
    let folders = ["system-test/first", "system-test/second"]
        .map(|name| build::workspace().join("target").join(name));
    let [first, second] = folders.each_ref().map(|folder| {
        let out = Some(folder.clone());
        demo::run(&demo::Arguments {
            seed: SEED,
            geometry: GEOMETRY.to_owned(),
            json: false,
            out,
        })?;
        contents(folder)
    });
    let (first, second) = (first?, second?);
    ensure!(
        first.keys().eq(second.keys()),
        "the same seed left other files: {:?} {:?}",
        first.keys(),
        second.keys()
    );
    for (name, bytes) in &first {
        ensure!(
            second.get(name) == Some(bytes),
            "the same seed gave other bytes in {}",
            name.display()
        );
    }
    Ok(())
}

/// All files below a folder; of the demo's document the time it took is left out, and with the board's key, which is
/// new each time, its flash, which has key and time of day in it.
fn contents(folder: &Path) -> anyhow::Result<BTreeMap<PathBuf, Vec<u8>>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(place) = folders.pop() {
        for entry in std::fs::read_dir(&place)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            if path.ends_with(key_file::DEFAULT) || path.ends_with("flash.bin") {
                continue;
            }
            let mut bytes = std::fs::read(&path)?;
            if path.ends_with("demo.json") {
                let mut document: serde_json::Value = serde_json::from_slice(&bytes)?;
                document["wall_seconds"].take();
                bytes = document.to_string().into_bytes();
            }
            files.insert(path.strip_prefix(folder)?.to_owned(), bytes);
        }
    }
    Ok(files)
}

/// A bench in a folder of its own, which is emptied.
fn bench<'a>(parts: &'a Parts, folder: &'a Path) -> anyhow::Result<Bench<'a>> {
    build::empty_folder(folder)?;
    Ok(Bench {
        parts,
        seed: SEED,
        geometry: GEOMETRY,
        folder,
    })
}

/// Rates with the blocks that are recorded at each.
const STREAMS: [(u32, u32); 6] = [
    (1_000, 1),
    (1_000, 16),
    (2_000, 1),
    (4_000, 1),
    (4_000, 8),
    (4_000, 32),
];
/// Length of a recording, s.
const STREAM_S: u32 = 4;

/// Streams at every rate.
pub fn streams() -> anyhow::Result<()> {
    let parts = Parts::find()?;
    let folder = build::workspace().join("target/system-test/streams");
    let bench = bench(&parts, &folder)?;
    let twin = bench.twin()?;
    bench.papers()?;
    let board = bench.board(&twin)?;
    for (rate, block) in STREAMS {
        let (capture, _) = record(&bench, &board, (rate, block), &[])?;
        ensure!(capture.values.is_none(), "values that nobody asked for");
    }
    checked(&mut bench.drive("calibrate", &board, &twin, 0)?)?;
    bench.provision(&board)?;
    checked(&mut bench.upload(&board)?)?;
    factors(&bench, &board)?;
    let (capture, note) = record(&bench, &board, (1_000, 16), &["--values"])?;
    ensure!(
        note["set"] == bench.active_id(&board)?,
        "the note names another set: {note}"
    );
    ensure!(capture.values.is_some(), "no values were recorded");
    let wrong = first_wrong_values(&capture, &coefficient_file::load(&bench.coefficients())?);
    ensure!(wrong.is_none(), "the board's values are wrong: {wrong:?}");
    let refused = Told::start(&mut capture_command(
        &bench,
        &board,
        (4_000, 16),
        &["--values"],
    )?)?;
    let (success, said) = refused.ended(told::WITHIN)?;
    ensure!(
        !success && said.contains("the link cannot carry"),
        "4 kHz with values was not refused: {said}"
    );
    let status = output(bench.hexsense("status", &board)?.arg("--json"))?;
    let status: Value = serde_json::from_str(&status)?;
    ensure!(
        status["link"]["blocks_dropped"] == 0 && status["faults"] == 0,
        "the board dropped blocks or had faults: {status}"
    );
    Ok(())
}

/// Largest difference between a factor of the board and the fitted gain, which the cross terms of the matrix and the
/// servos' own frequency make.
const FACTOR_OFF: f64 = 0.05;

/// The board's own harmonics of the run that was recorded last, and its calibration factors beside the fitted gains.
fn factors(bench: &Bench, board: &Beside) -> anyhow::Result<()> {
    let said = output(bench.hexsense("harmonics", board)?.arg("--json"))?;
    let said: Value = serde_json::from_str(&said)?;
    let channels = said["channels"].as_array().context("no channels")?;
    ensure!(channels.len() == CHANNELS, "not all channels: {said}");
    let factors = said["motion"]["factors"].as_array();
    let factors = factors.with_context(|| format!("no factors: {said}"))?;
    let set = coefficient_file::load(&bench.coefficients())?;
    let mut compared = 0;
    for factor in factors {
        let channel = NAMES.iter().position(|name| factor["channel"] == *name);
        let channel = channel.with_context(|| format!("no such channel: {factor}"))?;
        let (triad, axis) = (channel / 3, channel % 3);
        // What an accelerometer feels of a rotation is the lever arm's and gravity's.
        if triad == 0 {
            continue;
        }
        let gain = f64::from(set.triads[triad].matrix[axis][axis]).abs();
        let found = factor["per_count"].as_f64().unwrap_or(f64::NAN);
        let off = (found / gain - 1.0).abs();
        ensure!(off < FACTOR_OFF, "{factor}, and the fitted gain is {gain}");
        compared += 1;
    }
    ensure!(compared > 0, "no factor was compared: {said}");
    Ok(())
}

/// A recording that must be complete, and its note.
fn record(
    bench: &Bench,
    board: &Beside,
    (rate, block): (u32, u32),
    more: &[&str],
) -> anyhow::Result<(Capture, Value)> {
    checked(&mut capture_command(bench, board, (rate, block), more)?)?;
    let capture = Capture::load(&bench.folder.join("stream.csv"))?;
    let note = std::fs::read_to_string(bench.folder.join("stream.json"))?;
    let note: Value = serde_json::from_str(&note)?;
    let due = (STREAM_S * rate) as usize;
    ensure!(
        capture.gaps().is_empty() && capture.scans.len() >= due && note["scans_lost"] == 0,
        "{} of {due} scans at {rate} Hz in blocks of {block}: {note}",
        capture.scans.len()
    );
    Ok((capture, note))
}

fn capture_command(
    bench: &Bench,
    board: &Beside,
    (rate, block): (u32, u32),
    more: &[&str],
) -> anyhow::Result<Command> {
    let mut capture = bench.hexsense("capture", board)?;
    let [seconds, rate, block] = [STREAM_S, rate, block].map(|number| number.to_string());
    capture.args(["--seconds", &seconds, "--rate", &rate, "--block", &block]);
    capture
        .arg("--out")
        .arg(bench.folder.join("stream.csv"))
        .args(more);
    Ok(capture)
}

/// The plug pulled in three runs of a campaign, then during an upload.
pub fn plug_pulled() -> anyhow::Result<()> {
    let parts = Parts::find()?;
    let folder = build::workspace().join("target/system-test/plug");
    let bench = bench(&parts, &folder)?;
    let twin = bench.twin()?;
    bench.papers()?;
    pulled_in_runs(&bench, &twin).context("the plug pulled in a run")?;
    pulled_in_an_upload(&bench, &twin).context("the plug pulled in an upload")
}

/// A board that stays away is reported, at once or after the time that was said, and the campaign goes on from its
/// folder; one that comes back is waited for, and the campaign goes on by itself.
fn pulled_in_runs(bench: &Bench, twin: &Beside) -> anyhow::Result<()> {
    let captures = bench.campaign().join("captures");
    let board = bench.board(twin)?;
    let mut calibrate = bench.drive("calibrate", &board, twin, 0)?;
    let calibrate = Told::start(calibrate.args(["--board-wait", "0"]))?;
    wait_for(&captures.join("pitch.json"))?;
    drop(board);
    calibrate.must_explain("starting again goes on")?;

    let board = bench.board(twin)?;
    let mut resume = bench.resume(&board, twin)?;
    let resume = Told::start(resume.args(["--board-wait", "2"]))?;
    wait_for(&captures.join("roll.json"))?;
    drop(board);
    resume.must_explain("starting again goes on")?;

    let board = bench.board(twin)?;
    let link = board.address("link")?.to_owned();
    let mut resume = Told::start(&mut bench.resume(&board, twin)?)?;
    wait_for(&captures.join("heave.json"))?;
    drop(board);
    resume.says("waiting 60 s for the board to come back")?;
    let board = bench.board_on(twin, &link)?;
    resume.says("is recorded again from its start")?;
    resume.must_succeed(CAMPAIGN_TAKES)?;
    ensure!(bench.coefficients().exists(), "no coefficients were made");
    ensure!(
        bench.active_id(&board).is_err(),
        "a set is active that was never uploaded"
    );
    Ok(())
}

/// The old set or the new one is active, and the upload can be repeated.
fn pulled_in_an_upload(bench: &Bench, twin: &Beside) -> anyhow::Result<()> {
    let board = bench.board(twin)?;
    bench.provision(&board)?;
    let flash = bench.folder.join("flash.bin");
    let before = std::fs::read(&flash)?;
    let upload = Told::start(&mut bench.upload(&board)?)?;
    let start = Instant::now();
    while std::fs::read(&flash)? == before {
        ensure!(
            start.elapsed() < told::WITHIN,
            "the upload never reached the flash"
        );
    }
    drop(board);
    upload.ended(told::WITHIN)?;
    let board = bench.board(twin)?;
    checked(&mut bench.upload(&board)?)?;
    bench.active_id(&board).map(drop)
}

fn wait_for(file: &Path) -> anyhow::Result<()> {
    let start = Instant::now();
    while !file.exists() {
        ensure!(
            start.elapsed() < Duration::from_secs(60),
            "{} never came",
            file.display()
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}
