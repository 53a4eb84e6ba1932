//! Both sockets of a served twin, from the side of a board and of a host.

mod support;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use support::{an74, program};
use twin::Program;
use twin::bench::CHUNK_STEPS;
use twin::board::COLUMNS;
use twin::mechanism::Pose;
use twin::truth_log::TruthLog;

/// A twin process; it is killed when the test ends.
struct Served {
    process: Child,
    pins: String,
    control: String,
}

impl Served {
    fn start(extra: &[&str]) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_twin"))
            .args(["serve", "--seed", "3", "--geometry", "an-74tk-200"])
            .args(["--pins", "127.0.0.1:0", "--control", "127.0.0.1:0"])
            .args(extra)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap())
            .read_line(&mut line)
            .unwrap();
        let ready: Value = serde_json::from_str(&line).unwrap();
        let address = |key: &str| ready[key].as_str().unwrap().to_owned();
        Self {
            pins: address("pins"),
            control: address("control"),
            process,
        }
    }

    fn ask(&self, request: &str) -> Value {
        let mut stream = TcpStream::connect(&self.control).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        stream.write_all(b"\n").unwrap();
        let mut line = String::new();
        BufReader::new(stream).read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap()
    }

    fn run(&self, name: &str, program: &Path) -> Value {
        self.ask(&json!({"run": {"name": name, "program": program}}).to_string())
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A board on the pins.
struct Board {
    stream: BufReader<TcpStream>,
    hello: Value,
}

impl Board {
    fn connect(twin: &Served) -> Self {
        let mut stream = BufReader::new(TcpStream::connect(&twin.pins).unwrap());
        let mut line = String::new();
        stream.read_line(&mut line).unwrap();
        Self {
            stream,
            hello: serde_json::from_str(&line).unwrap(),
        }
    }

    fn chunk(&mut self) -> Vec<Vec<f32>> {
        self.stream.get_mut().write_all(b"N").unwrap();
        let mut bytes = vec![0; (CHUNK_STEPS + 1) * COLUMNS.len() * 4];
        self.stream.read_exact(&mut bytes).unwrap();
        let values: Vec<f32> = bytes
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
            .collect();
        values
            .chunks_exact(COLUMNS.len())
            .map(<[f32]>::to_vec)
            .collect()
    }
}

/// A folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn heave(path: &Path) -> PathBuf {
    let geometry = an74();
    let program: Program = program(&geometry, 3.0, |t| Pose {
        position_m: geometry.home.position_m
            + support::Y * (0.05 * (1.0 - (std::f64::consts::TAU * t / 3.0).cos())),
        attitude: geometry.home.attitude,
    });
    let mut text = twin::program::HEADER.to_owned() + "\n";
    for (index, row) in program.rows().iter().enumerate() {
        let jacks: Vec<String> = row.iter().map(|x| format!("{x:.6}")).collect();
        text += &format!("{:.3},{}\n", index as f64 * 0.001, jacks.join(","));
    }
    let file = path.join("heave.csv");
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn the_board_is_told_what_is_soldered_where() {
    let twin = Served::start(&[]);
    let hello = Board::connect(&twin).hello;
    assert_eq!(hello["protocol"], "hexsense-pins 1");
    assert_eq!(hello["step_s"], 0.0005);
    assert_eq!(hello["chunk_steps"], 40);
    assert_eq!(hello["columns"].as_array().unwrap().len(), 17);
    let board = &hello["board"];
    assert_eq!(board["seed"], 3);
    let uid = board["uid"].as_str().unwrap();
    assert!(uid.len() == 24 && uid.chars().all(|c| c.is_ascii_hexdigit()));
    assert!(board["clock_ppm"].as_f64().unwrap().abs() <= 50.0);
    assert!((1.182..=1.232).contains(&board["vrefint_v"].as_f64().unwrap()));
    assert!(board["boot_unix_s"].as_u64().unwrap() >= 1_780_000_000);
    for adc in board["adc"].as_array().unwrap() {
        assert!(adc["gain_error"].as_f64().unwrap().abs() <= 0.001);
        assert!(adc["offset_lsb"].as_f64().unwrap().abs() <= 2.0);
        assert_eq!(adc["noise_lsb"], 1.5);
    }
    assert_eq!(board["adc"].as_array().unwrap().len(), 5);
}

#[test]
fn chunks_follow_each_other_without_a_gap_across_a_power_cycle() {
    let twin = Served::start(&[]);
    let mut board = Board::connect(&twin);
    let (first, second) = (board.chunk(), board.chunk());
    assert_eq!(first.last(), second.first());
    assert_ne!(first[0], second[0]);
    for row in first.iter().chain(&second) {
        // Everything but y is near the middle at rest; the supply is 3.3 V.
        assert!((row[1] - 1.65 - 0.75).abs() < 0.1, "ay {}", row[1]);
        assert!((row[16] - 3.3).abs() < 0.0034, "supply {}", row[16]);
        assert!((25.0..35.0).contains(&row[15]), "temperature {}", row[15]);
    }
    drop(board);
    let again = Board::connect(&twin).chunk();
    assert_eq!(
        second.last(),
        again.first(),
        "time stood still without a board"
    );
}

#[test]
fn a_run_moves_the_base_and_its_truth_is_written_down() {
    let path = folder("truth_log");
    let log = path.join("truth.csv");
    let twin = Served::start(&["--truth-log", log.to_str().unwrap(), "--truth-run", "heave"]);
    let mut board = Board::connect(&twin);
    for _ in 0..5 {
        board.chunk();
    }
    let program = heave(&path);
    assert_eq!(twin.run("heave", &program), json!({"ok": true}));
    let busy = twin.run("heave", &program);
    assert!(busy["error"].as_str().unwrap().contains("has not ended"));
    let chunks = 14 * 50;
    let swing = (0..chunks).fold((f32::MAX, f32::MIN), |(low, high), _| {
        let volts = board.chunk()[0][9];
        (low.min(volts), high.max(volts))
    });
    assert!(swing.1 - swing.0 > 0.15, "jack 1 moved by {swing:?} V");
    drop(board);
    let text = std::fs::read_to_string(&log).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], twin::truth_log::HEADER);
    assert_eq!(lines.len() - 1, chunks * CHUNK_STEPS / 4);
    let value = |line: &str, column: usize| -> f64 {
        line.split(',').nth(column).unwrap().parse().unwrap()
    };
    assert_eq!(value(lines[1], 0), 0.102);
    assert_eq!(value(lines.last().unwrap(), 0), 14.1);
    assert!((value(lines[1], 2) - 9.80665).abs() < 0.02, "fy at rest");
    let moved = lines[1..]
        .iter()
        .map(|line| value(line, 10))
        .fold(0.0, f64::max);
    assert!(moved > 0.05, "jack 1 moved by {moved} m");

    // Without a board nothing is written, and another run ends the log.
    let mut board = Board::connect(&twin);
    for _ in 0..10 {
        board.chunk();
    }
    assert_eq!(twin.run("other", &program), json!({"ok": true}));
    board.chunk();
    assert_eq!(std::fs::read_to_string(&log).unwrap(), text);
}

#[test]
fn a_run_that_is_commanded_again_begins_the_truth_afresh() {
    let path = folder("again").join("truth.csv");
    let bench = twin::Bench::with_geometry(1, &an74()).unwrap();
    let mut log = TruthLog::create(&path, "pitch").unwrap();
    let mut record = |name: &str, steps: usize| {
        log.run_commanded(name).unwrap();
        (0..steps).for_each(|_| log.step(bench.motion()).unwrap());
        std::fs::read_to_string(&path).unwrap().lines().count()
    };
    assert_eq!(record("pitch", 43), 1 + 10);
    assert_eq!(record("roll", 40), 1 + 10);
    assert_eq!(record("pitch", 8), 1 + 2);
}

#[test]
fn a_killed_twin_leaves_whole_lines_of_truth() {
    let path = folder("killed");
    let log = path.join("truth.csv");
    let mut twin = Served::start(&["--truth-log", log.to_str().unwrap(), "--truth-run", "heave"]);
    let mut board = Board::connect(&twin);
    assert_eq!(twin.run("heave", &heave(&path)), json!({"ok": true}));
    for _ in 0..25 {
        board.chunk();
    }
    twin.process.kill().unwrap();
    twin.process.wait().unwrap();
    let text = std::fs::read_to_string(&log).unwrap();
    assert!(text.ends_with('\n'));
    assert_eq!(text.lines().count(), 1 + 250);
    assert!(text.lines().all(|line| line.split(',').count() == 16));
}

#[test]
fn stop_takes_the_base_home() {
    let twin = Served::start(&[]);
    let mut board = Board::connect(&twin);
    let home = board.chunk()[0][9];
    assert_eq!(
        twin.run("heave", &heave(&folder("stop"))),
        json!({"ok": true})
    );
    while (board.chunk()[0][9] - home).abs() < 0.05 {}
    assert_eq!(twin.ask(r#"{"stop":true}"#), json!({"ok": true}));
    let settled = (0..5 * 50).map(|_| board.chunk()[0][9]).last().unwrap();
    assert!(
        (settled - home).abs() < 0.005,
        "{settled} V, home is {home} V"
    );
}

#[test]
fn what_cannot_be_done_is_answered_and_the_twin_lives_on() {
    let twin = Served::start(&[]);
    let path = folder("requests");
    let short = path.join("short.csv");
    std::fs::write(&short, "time_s,jack1_m\n0,0\n").unwrap();
    for (request, says) in [
        ("nonsense".to_owned(), "not a request"),
        (r#"{"stop":false}"#.to_owned(), "send true"),
        (r#"{"stop":true,"run":{}}"#.to_owned(), "not a request"),
        (r#"{"run":{"name":"x"}}"#.to_owned(), "program"),
        (
            r#"{"run":{"name":"x","program":"/no/such.csv"}}"#.to_owned(),
            "/no/such.csv",
        ),
        (
            json!({"run": {"name": "x", "program": short}}).to_string(),
            "header",
        ),
    ] {
        let answer = twin.ask(&request);
        assert_eq!(answer["ok"], false, "{request}");
        let error = answer["error"].as_str().unwrap();
        assert!(error.contains(says), "{request}: {error}");
    }
    let mut board = TcpStream::connect(&twin.pins).unwrap();
    board.write_all(b"?").unwrap();
    board
        .set_read_timeout(Some(Duration::from_secs(10)))
        .unwrap();
    let mut rest = Vec::new();
    board.read_to_end(&mut rest).unwrap();
    assert_eq!(
        rest.iter().filter(|byte| **byte == b'\n').count(),
        1,
        "only the first line"
    );
    assert_eq!(Board::connect(&twin).chunk().len(), 41);
}
