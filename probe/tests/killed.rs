//! `hexsense` killed, asked to stop, or out of disk: real processes with real signals.

#![cfg(unix)]

mod fake;

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

use assert_cmd::cargo::cargo_bin;
use fake::line::shared;
use fake::source::{self, Still};
use fake::{AWAY_BLOCKS, FakeBoard, Fault};
use hexsense_probe::capture::Capture;
use serde_json::Value;

type Board = Arc<Mutex<FakeBoard>>;

/// A board whose blocks take their true time, 16 ms; its port.
fn board(change: impl FnOnce(&mut FakeBoard)) -> (Board, String) {
    let mut board = FakeBoard::new(Box::new(Still));
    board.pace = Duration::from_millis(16);
    change(&mut board);
    let board = Arc::new(Mutex::new(board));
    let port = shared(&board);
    (board, port)
}

fn hexsense(folder: &Path, port: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(cargo_bin("hexsense"));
    command
        .current_dir(folder)
        .args(arguments)
        .args(["--port", port])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

const CAPTURE: [&str; 5] = ["capture", "--seconds", "60", "--out", "run.csv"];

/// Waits until `until` is true.
fn wait(what: &str, mut until: impl FnMut() -> bool) {
    let start = Instant::now();
    while !until() {
        assert!(start.elapsed() < Duration::from_secs(30), "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn is_longer(file: &Path, bytes: u64) -> bool {
    file.metadata().is_ok_and(|file| file.len() > bytes)
}

fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args([name, &id])
            .status()
            .unwrap()
            .success()
    );
}

fn said(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn a_killed_capture_leaves_everything_up_to_the_last_second() {
    let folder = tempfile::tempdir().unwrap();
    let (board, port) = board(|_| {});
    let mut child = hexsense(folder.path(), &port, &CAPTURE).spawn().unwrap();
    let part = folder.path().join("run.csv.part");
    let sampled = || board.lock().unwrap().scans();
    wait("the board never sampled", || sampled() > 3_000);
    let sampled = sampled();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!folder.path().join("run.csv").exists());
    let (capture, _) = Capture::salvage(&part).unwrap();
    let last = *capture.scans.last().unwrap();
    assert!(last + 1_000 >= sampled, "scan {last} of {sampled}");
    assert!(capture.gaps().is_empty());
    let note = std::fs::read(folder.path().join("run.json.part")).unwrap();
    let note: Value = serde_json::from_slice(&note).unwrap();
    assert_eq!(note["rate_hz"], 1_000);
    // The killed process left the stream on; commands that only ask leave it so.
    for command in ["status", "info", "log", "history", "show"] {
        let output = hexsense(folder.path(), &port, &[command]).output().unwrap();
        assert!(output.status.success(), "{command}: {}", said(&output));
        assert!(board.lock().unwrap().streams(), "{command}");
    }
    let again = ["capture", "--seconds", "0.02", "--rate", "2000"];
    let again = [&again[..], &["--block", "1", "--out", "run.csv"]].concat();
    let output = hexsense(folder.path(), &port, &again).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    assert!(!board.lock().unwrap().streams());
}

#[test]
fn a_capture_asked_to_stop_stops_the_stream_and_says_where_the_scans_are() {
    for name in ["-INT", "-TERM"] {
        let folder = tempfile::tempdir().unwrap();
        let (board, port) = board(|_| {});
        let child = hexsense(folder.path(), &port, &CAPTURE).spawn().unwrap();
        let part = folder.path().join("run.csv.part");
        wait("the capture never grew", || is_longer(&part, 10_000));
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        let text = said(&output);
        assert_eq!(output.status.code(), Some(130), "{text}");
        for says in [
            "the recording broke off: stopped on request",
            "the board keeps sampling",
            "scans are in run.csv.part, and what they belong to in run.json.part",
            "hexsense capture --seconds 60 --out run.csv",
        ] {
            assert!(text.contains(says), "{says:?} is not in: {text}");
        }
        let (capture, torn) = Capture::salvage(&part).unwrap();
        assert!(capture.scans.len() > 100 && torn.is_none());
        assert!(!board.lock().unwrap().streams());
    }
}

/// A motion controller that notes what it is told.
fn controller() -> (String, mpsc::Receiver<String>) {
    let listener = source::listener();
    let address = source::address(&listener);
    let (tell, told) = mpsc::channel();
    std::thread::spawn(move || {
        let (stream, _) = listener.accept().unwrap();
        for line in BufReader::new(&stream).lines() {
            tell.send(line.unwrap()).unwrap();
            (&stream).write_all(b"{\"ok\":true}\n").unwrap();
        }
    });
    (address, told)
}

#[test]
fn a_campaign_asked_to_stop_has_the_base_go_home_and_says_how_to_resume() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("sensors.toml"),
        twin::papers::sensor_file(1),
    )
    .unwrap();
    let (board, port) = board(|_| {});
    let (address, told) = controller();
    let base = [
        "calibrate",
        "--geometry",
        "an-74tk-200",
        "--out",
        "campaign",
    ];
    let rest = ["--sensors", "sensors.toml", "--twin", &address];
    let arguments = [&base[..], &rest[..]].concat();
    let child = hexsense(folder.path(), &port, &arguments).spawn().unwrap();
    let part = folder.path().join("campaign/captures/zero.csv.part");
    wait("the zero run never grew", || is_longer(&part, 100_000));
    signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    let text = said(&output);
    assert_eq!(output.status.code(), Some(130), "{text}");
    let go_on = format!("hexsense calibrate --resume campaign --port {port} --twin {address}");
    assert!(
        text.contains("run zero broke off: stopped on request") && text.contains(&go_on),
        "{text}"
    );
    assert_eq!(told.recv().unwrap(), "{\"stop\":true}");
    assert!(!board.lock().unwrap().streams());
    let (capture, torn) = Capture::salvage(&part).unwrap();
    assert!(capture.scans.len() > 1_000 && torn.is_none());
}

#[test]
fn a_prompt_is_left_by_a_request_to_stop() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("sensors.toml"),
        twin::papers::sensor_file(1),
    )
    .unwrap();
    let (_board, port) = board(|_| {});
    let base = [
        "calibrate",
        "--geometry",
        "an-74tk-200",
        "--out",
        "campaign",
    ];
    let arguments = [&base[..], &["--sensors", "sensors.toml"]].concat();
    let mut child = hexsense(folder.path(), &port, &arguments).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().contains("Press Enter when it is")));
    // Waiting closes standard input, which is an answer too.
    let _keyboard = child.stdin.take();
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

#[test]
fn a_capture_goes_on_across_a_cut_line_with_a_gap() {
    let folder = tempfile::tempdir().unwrap();
    let (_board, port) = board(|board| {
        board.pace = Duration::ZERO;
        board.fault = Fault::LineCutAfterBlocks(100);
    });
    let arguments = ["capture", "--seconds", "5", "--out", "run.csv"];
    let output = hexsense(folder.path(), &port, &arguments).output().unwrap();
    let text = said(&output);
    assert!(output.status.success(), "{text}");
    assert!(
        text.contains("the scans that are missing are a gap"),
        "{text}"
    );
    let capture = Capture::load(&folder.path().join("run.csv")).unwrap();
    let [gap] = capture.gaps()[..] else {
        panic!("{:?}", capture.gaps())
    };
    assert!(gap.scans >= 16 * AWAY_BLOCKS, "{gap:?}");
    let note = std::fs::read(folder.path().join("run.json")).unwrap();
    let note: Value = serde_json::from_slice(&note).unwrap();
    assert_eq!(note["scans_lost"], gap.scans);
    assert!(!folder.path().join("run.json.part").exists());
}

#[test]
fn a_capture_does_not_go_on_across_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let (_board, port) = board(|board| {
        board.pace = Duration::ZERO;
        board.fault = Fault::CutAfterBlocks(100);
    });
    let arguments = ["capture", "--seconds", "5", "--out", "run.csv"];
    let output = hexsense(folder.path(), &port, &arguments).output().unwrap();
    let text = said(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(
        text.contains("the board has restarted (PowerOn)") && text.contains("run.csv.part"),
        "{text}"
    );
    let (capture, _) = Capture::salvage(&folder.path().join("run.csv.part")).unwrap();
    assert!(capture.gaps().is_empty() && capture.scans.len() > 1_000);
}

/// `hexsense` that may write files of at most so many blocks of 512 bytes.
fn limited(folder: &Path, blocks: u32, arguments: &[&str]) -> Output {
    let script = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command
        .current_dir(folder)
        .args(["-c", &script])
        .arg(cargo_bin("hexsense"));
    command.args(arguments).output().unwrap()
}

#[test]
fn a_capture_on_a_full_disk_names_the_file_and_keeps_every_whole_row() {
    let folder = tempfile::tempdir().unwrap();
    let (_board, port) = board(|board| board.pace = Duration::ZERO);
    let arguments = [&CAPTURE[..], &["--port", &port]].concat();
    let output = limited(folder.path(), 300, &arguments);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    let part = folder.path().join("run.csv.part");
    let (capture, torn) = Capture::salvage(&part).unwrap();
    assert_eq!(torn, None);
    let scans = capture.scans.len();
    assert!(scans > 1_000);
    for says in [
        "run.csv.part: cannot be written on: File too large",
        &format!("the {scans} scans before are in it and stay readable"),
    ] {
        assert!(text.contains(says), "{says:?} is not in: {text}");
    }
}

#[test]
fn a_file_replaced_on_a_full_disk_stays_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let plan = ["plan", "--geometry", "an-74tk-200", "--out", "campaign"];
    assert!(limited(folder.path(), 100_000, &plan).status.success());
    let program = folder.path().join("campaign/programs/pitch.csv");
    let before = std::fs::read(&program).unwrap();
    let text = said(&limited(folder.path(), 20, &plan));
    assert!(
        text.contains("campaign/programs/pitch.csv: cannot be written: File too large")
            && text.contains("what was there before is unchanged"),
        "{text}"
    );
    assert_eq!(std::fs::read(&program).unwrap(), before);
    assert!(
        !folder
            .path()
            .join("campaign/programs/pitch.csv.part")
            .exists()
    );
}
