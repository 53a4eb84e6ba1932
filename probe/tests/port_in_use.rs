//! `hexsense` on a port that another process uses: it changes nothing, names that process, and the recording under way
//! loses no scan.

#![cfg(target_os = "linux")]

mod fake;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use assert_cmd::cargo::cargo_bin;
use fake::FakeBoard;
use fake::source::{self, Still};
use hexsense_probe::capture::Capture;
use serde_json::Value;
use serialport::{SerialPort, TTYPort};

type Board = Arc<Mutex<FakeBoard>>;

/// What the board sends before the host reads, in time: a host that is held up for longer loses blocks.
const BLOCK: Duration = Duration::from_millis(16);

fn board() -> Board {
    Arc::new(Mutex::new(FakeBoard::new(Box::new(Still))))
}

/// Carries bytes between a board and a line at the pace of real time until the line ends.
fn serve(board: &Board, mut line: impl Read + Write) {
    let mut due = Instant::now() + BLOCK;
    loop {
        let mut bytes = [0; 512];
        // Nothing in time, or a terminal that no host has open.
        let count = line.read(&mut bytes);
        let mut sent = match count {
            Ok(0) => return,
            Ok(count) => board.lock().unwrap().take(&bytes[..count]),
            Err(_) => Vec::new(),
        };
        while Instant::now() >= due {
            sent.extend(board.lock().unwrap().block().unwrap_or_default());
            due += BLOCK;
        }
        let _ = line.write_all(&sent);
    }
}

/// A board behind a pseudo-terminal; its device.
fn terminal(board: &Board) -> String {
    let (mut master, host) = TTYPort::pair().unwrap();
    let device = host.name().unwrap();
    master.set_timeout(Duration::from_millis(2)).unwrap();
    let board = Arc::clone(board);
    thread::spawn(move || serve(&board, master));
    // The host opens it for itself; the board waits meanwhile.
    drop(host);
    device
}

/// A board behind a socket that serves one host and closes every other connection at once, as the virtual board does.
fn socket(board: &Board) -> String {
    let listener = source::listener();
    let port = format!("tcp:{}", source::address(&listener));
    let board = Arc::clone(board);
    thread::spawn(move || {
        let mut host: Option<thread::JoinHandle<()>> = None;
        for stream in listener.incoming().map(Result::unwrap) {
            if host.as_ref().is_none_or(thread::JoinHandle::is_finished) {
                host = Some(serve_host(&board, stream));
            }
        }
    });
    port
}

fn serve_host(board: &Board, stream: TcpStream) -> thread::JoinHandle<()> {
    stream.set_nodelay(true).unwrap();
    let wait = Some(Duration::from_millis(2));
    stream.set_read_timeout(wait).unwrap();
    let board = Arc::clone(board);
    thread::spawn(move || serve(&board, stream))
}

fn hexsense(folder: &Path, port: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(cargo_bin("hexsense"));
    command
        .current_dir(folder)
        .args(arguments)
        .args(["--port", port])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Waits until the recording has scans in its file.
fn wait_for_scans(folder: &Path, recording: &mut Child) {
    let start = Instant::now();
    let part = folder.join("run.csv.part");
    while !part.metadata().is_ok_and(|file| file.len() > 1_000) {
        assert!(start.elapsed() < Duration::from_secs(30), "no scan came");
        assert!(recording.try_wait().unwrap().is_none(), "it has ended");
        thread::sleep(Duration::from_millis(5));
    }
}

fn assert_refused(output: &Output, port: &str, user: u32, arguments: &[&str]) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {said}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    let named = format!("{port} is in use by process {user} (");
    for part in [&named, "hexsense capture", "Nothing was sent to it"] {
        assert!(said.contains(part), "{part:?}, {arguments:?}: {said}");
    }
}

fn nothing_disturbs_a_recording_on(port: &str, board: &Board) {
    let folder = tempfile::tempdir().unwrap();
    let capture = ["capture", "--seconds", "4", "--out", "run.csv"];
    let mut recording = hexsense(folder.path(), port, &capture).spawn().unwrap();
    wait_for_scans(folder.path(), &mut recording);
    let heard = board.lock().unwrap().heard.len();
    let start = Instant::now();
    let second = ["capture", "--seconds", "1", "--out", "second.csv"];
    for arguments in [&["status"][..], &["info"], &["log"], &second] {
        let output = hexsense(folder.path(), port, arguments).output().unwrap();
        assert_refused(&output, port, recording.id(), arguments);
    }
    assert!(start.elapsed() < Duration::from_secs(3), "not soon");
    assert!(recording.try_wait().unwrap().is_none(), "all came too late");
    assert_eq!(board.lock().unwrap().heard.len(), heard, "bytes were sent");
    assert!(!folder.path().join("second.csv.part").exists());

    let output = recording.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let capture = Capture::load(&folder.path().join("run.csv")).unwrap();
    let note = std::fs::read(folder.path().join("run.json")).unwrap();
    let note: Value = serde_json::from_slice(&note).unwrap();
    assert_eq!(note["scans_lost"], 0, "{said}");
    assert!(capture.gaps().is_empty() && capture.scans.len() >= 4_000);
    // The port is free again.
    let output = hexsense(folder.path(), port, &["info"]).output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn a_serial_port_belongs_to_the_process_that_records_on_it() {
    let board = board();
    nothing_disturbs_a_recording_on(&terminal(&board), &board);
}

#[test]
fn a_socket_belongs_to_the_process_that_records_on_it() {
    let board = board();
    nothing_disturbs_a_recording_on(&socket(&board), &board);
}
