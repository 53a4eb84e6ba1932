//! `hexsense status` and `hexsense capture` against a board made of the core's own parts.

mod fake;

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use fake::FakeBoard;
use fake::line::lockstep;
use fake::source::Source;
use hexsense_client::Client;
use hexsense_core::channel::Scan;
use hexsense_core::harmonics::increment;
use hexsense_core::sampling::{BlockSize, Calibrator};
use hexsense_core::wire::Drive;
use hexsense_probe::capture::Capture;
use serde_json::Value;

/// Counts that are different in every scan and channel.
struct Moving(u32);

impl Source for Moving {
    fn scan(&mut self, _rate_hz: u32) -> Scan {
        self.0 = self.0.wrapping_add(1);
        std::array::from_fn(|channel| {
            (self.0.wrapping_mul(2_654_435_761) >> 16) as u16 ^ (channel as u16 * 977)
        })
    }

    fn supply(&self) -> f32 {
        0.998_7
    }
}

fn board(change: impl FnOnce(&mut FakeBoard)) -> String {
    let mut board = FakeBoard::new(Box::new(Moving(0)));
    change(&mut board);
    lockstep(board)
}

fn hexsense(port: &str, folder: &Path, arguments: &[&str]) -> Output {
    Command::cargo_bin("hexsense")
        .unwrap()
        .current_dir(folder)
        .args(arguments)
        .args(["--port", port])
        .output()
        .unwrap()
}

fn json(bytes: &[u8]) -> Value {
    serde_json::from_slice(bytes).unwrap_or_else(|error| panic!("{error}: {bytes:?}"))
}

#[test]
fn status_says_how_the_board_is_in_numbers_and_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let port = board(|_| {});
    let mut client = Client::open(&port).unwrap();
    client.rate(2_000).unwrap();
    client.block_size(BlockSize::ThirtyTwo).unwrap();
    let drive = Drive {
        increment: increment(0.5, 2_000).unwrap(),
        block: BlockSize::ThirtyTwo,
        settle_blocks: 0,
        blocks: 300,
    };
    client.drive(1, drive).unwrap();
    drop(client);
    let status = json(&hexsense(&port, folder.path(), &["status", "--json"]).stdout);
    assert_eq!(
        (&status["rate_hz"], &status["block"]),
        (&2_000.into(), &32.into())
    );
    let number = |pointer: &str| {
        let value = status.pointer(pointer).and_then(Value::as_f64);
        value.unwrap_or_else(|| panic!("{pointer} in {status}"))
    };
    // 4800 cycles at 150 MHz are 32 µs, 0.2 % of the 16 ms that 32 scans take.
    for (pointer, expected) in [
        ("/sample_path/max/cycles", 4_800.0),
        ("/sample_path/max/us", 32.0),
        ("/sample_path/max/block_percent", 0.2),
        ("/analysers/1/frequency_hz", 0.5),
        ("/analysers/1/blocks", 300.0),
    ] {
        assert!(
            (number(pointer) - expected).abs() < 1e-9,
            "{pointer} in {status}"
        );
    }
    assert!((200.0..=300.0).contains(&number("/analysers/1/blocks_left")));
    assert_eq!(status["analysers"][0]["state"], "idle");
    // Half of the samples of 4 kHz, at which counts alone take more than four fifths.
    assert!((0.4..0.5).contains(&(number("/link/load_percent/counts") / 100.0)));
    assert_eq!(
        (&status["set"], &status["in_calibrated_range"]),
        (&Value::Null, &Value::Null)
    );
    let text = String::from_utf8(hexsense(&port, folder.path(), &["status"]).stdout).unwrap();
    for part in [
        "at 2000 Hz in blocks of 32",
        "4800 cycles (32.0 µs)",
        "at most 0.20 % of a block's 16.0 ms",
        "analyser 0     idle",
        "analyser 1     0.500000 Hz, ",
        "clock          crystal",
        "none; calibrate and upload a set",
        "last panic     none",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
}

#[test]
fn every_rate_is_recorded_and_noted_in_every_block_that_the_link_carries() {
    let folder = tempfile::tempdir().unwrap();
    let port = board(|_| {});
    for (rate, block) in [(1_000, 1), (2_000, 4), (4_000, 8), (4_000, 32)] {
        let [rate, block] = [rate, block].map(|number: u32| number.to_string());
        let arguments = [
            "capture",
            "--seconds",
            "1",
            "--rate",
            &rate,
            "--block",
            &block,
        ];
        let output = hexsense(
            &port,
            folder.path(),
            &[&arguments[..], &["--out", "run.csv"]].concat(),
        );
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let capture = Capture::load(&folder.path().join("run.csv")).unwrap();
        let note = json(&std::fs::read(folder.path().join("run.json")).unwrap());
        assert_eq!(note["rate_hz"].to_string(), rate);
        assert_eq!(note["block"].to_string(), block);
        assert_eq!(capture.scans.len().to_string(), rate);
        assert_eq!(
            (&note["scans_lost"], &note["set"]),
            (&0.into(), &Value::Null)
        );
        assert!(capture.gaps().is_empty());
    }
}

#[test]
fn a_gap_is_a_gap_in_the_file_and_in_its_note() {
    let folder = tempfile::tempdir().unwrap();
    let port = board(|board| board.lose_blocks = 20..22);
    let output = hexsense(
        &port,
        folder.path(),
        &["capture", "--seconds", "1", "--out", "run.csv"],
    );
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("32 scans did not arrive, in 1 gaps"),
        "{said}"
    );
    let capture = Capture::load(&folder.path().join("run.csv")).unwrap();
    let note = json(&std::fs::read(folder.path().join("run.json")).unwrap());
    let [gap] = capture.gaps()[..] else {
        panic!("{:?}", capture.gaps())
    };
    assert_eq!(gap.scans, 32);
    assert_eq!(note["gaps"][0]["first_scan"], gap.first_scan);
    assert_eq!(
        (&note["gaps"][0]["scans"], &note["scans_lost"]),
        (&32.into(), &32.into())
    );
}

#[test]
fn recorded_values_are_bit_for_bit_those_of_the_counts_and_the_noted_set() {
    let folder = tempfile::tempdir().unwrap();
    let port = board(|_| {});
    fake::key::save(folder.path(), b"fake board 1");
    let set = fake::set::set(7);
    hexsense_probe::coefficient_file::save(
        &folder.path().join("coefficients.toml"),
        &set,
        &fake::set::sources(),
    )
    .unwrap();
    assert!(
        hexsense(&port, folder.path(), &["upload", "coefficients.toml"])
            .status
            .success()
    );
    let arguments = ["capture", "--seconds", "1", "--values", "--out", "run.csv"];
    assert!(hexsense(&port, folder.path(), &arguments).status.success());
    let capture = Capture::load(&folder.path().join("run.csv")).unwrap();
    let note = json(&std::fs::read(folder.path().join("run.json")).unwrap());
    let shown = json(&hexsense(&port, folder.path(), &["show", "--json"]).stdout);
    assert!(note["set"].is_string());
    assert_eq!(note["set"], shown["id"]);
    let calibrator = Calibrator::new(&set);
    let values = capture.values.unwrap();
    assert_eq!(values.len(), capture.counts.len());
    for (row, values) in values.iter().enumerate() {
        let ours = calibrator.apply(&capture.counts[row], capture.supply[row]);
        assert_eq!(
            ours.map(f32::to_bits),
            values.map(f32::to_bits),
            "row {row}"
        );
    }
    let too_fast = hexsense(
        &port,
        folder.path(),
        &[&arguments[..], &["--rate", "4000"]].concat(),
    );
    let said = String::from_utf8(too_fast.stderr).unwrap();
    assert!(!too_fast.status.success());
    assert!(
        said.contains("ask for less content or a lower rate"),
        "{said}"
    );
}

#[test]
fn what_the_board_or_the_link_cannot_do_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let port = board(|_| {});
    for (arguments, says) in [
        (&["--rate", "3000"][..], "choose 1000, 2000 or 4000"),
        (
            &["--values"],
            "the board has no coefficients; calibrate and upload a set first",
        ),
        (&["--block", "5"], "1, 4, 8, 16 or 32 scans at a time"),
    ] {
        let all = [
            &["capture", "--seconds", "1", "--out", "run.csv"],
            arguments,
        ]
        .concat();
        let output = hexsense(&port, folder.path(), &all);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(
            !output.status.success() && said.contains(says),
            "{arguments:?}: {said}"
        );
        assert!(!folder.path().join("run.csv").exists());
    }
    // What was refused left the board as it can be used.
    let output = hexsense(
        &port,
        folder.path(),
        &["capture", "--seconds", "0.1", "--out", "run.csv"],
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
