//! The firmware on the virtual board, spoken to in lockstep: time runs only while the test waits for the board.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};

use hexsense_core::wire::frame::{self, Closed, Deframer};
use hexsense_core::wire::message::{decode_response, encode_request};
use hexsense_core::wire::telemetry::{self, Block};
use hexsense_core::wire::{
    Kind, MAX_FRAME, PoseReport, Request, Response, Status, StreamContent, pose,
};
use serde::Deserialize;

/// A frame of samples with the time at which its last bit had left the board.
#[derive(Debug, Clone)]
pub struct Arrived {
    /// True time, µs.
    pub at_us: u64,
    /// Bytes on the line.
    pub bytes: usize,
    /// What it carries.
    pub block: Block,
}

/// A run of triggers, as the virtual board tells it.
#[derive(Debug, Clone, Deserialize)]
pub struct TriggerRun {
    pub first_ns: u64,
    pub count: u64,
    pub min_cycles: u64,
    pub max_cycles: u64,
}

#[derive(Deserialize)]
struct Counts {
    triggers: Vec<TriggerRun>,
}

/// A board with the firmware on it.
pub struct Board {
    child: Child,
    stdout: BufReader<ChildStdout>,
    stream: TcpStream,
    flash: PathBuf,
    deframer: Box<Deframer<MAX_FRAME>>,
    sequence: u16,
    held: usize,
    /// A reset may cut a frame off.
    faulty: bool,
    pub now_us: u64,
    pub blocks: Vec<Arrived>,
    pub poses: Vec<PoseReport>,
    answer: Option<(u16, Response)>,
}

fn place(variable: &str) -> PathBuf {
    let place = std::env::var_os(variable);
    place
        .unwrap_or_else(|| panic!("{variable} must name a file; cargo xtask test does it"))
        .into()
}

impl Board {
    /// Powers the board on, with an erased flash and every pin at half the supply, and waits until it samples.
    pub fn on(name: &str) -> Self {
        let flash =
            std::env::temp_dir().join(format!("hexsense-{}-{name}.bin", std::process::id()));
        let _ = std::fs::remove_file(&flash);
        let mut board = Self::power(flash, "");
        board.run_s(1.0);
        board
    }

    /// Pulls the plug and powers the same board on again, at time 0. Faults come as the virtual board's file of faults
    /// says, see docs/virtual-bench.md.
    pub fn power_cycled(mut self, faults: &str) -> Self {
        Self::power(std::mem::take(&mut self.flash), faults)
    }

    fn power(flash: PathBuf, faults: &str) -> Self {
        let mut command = Command::new(place("HEXSENSE_VIRTUAL_BOARD"));
        command
            .arg("--elf")
            .arg(place("HEXSENSE_FIRMWARE"))
            .arg("--flash")
            .arg(&flash)
            .args(["--link", "lockstep:127.0.0.1:0", "--count", "sample_path"]);
        if !faults.is_empty() {
            let file = flash.with_extension("faults");
            std::fs::write(&file, faults).unwrap();
            command.arg("--faults").arg(file);
        }
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut stdout = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        stdout.read_line(&mut line).unwrap();
        let link: serde_json::Value = serde_json::from_str(&line).unwrap();
        let address = link["link"].as_str().unwrap();
        let stream = TcpStream::connect(address.strip_prefix("lockstep:").unwrap()).unwrap();
        stream.set_nodelay(true).unwrap();
        Self {
            child,
            stdout,
            stream,
            flash,
            deframer: Box::default(),
            sequence: 0,
            held: 0,
            faulty: !faults.is_empty(),
            now_us: 0,
            blocks: Vec::new(),
            poses: Vec::new(),
            answer: None,
        }
    }

    /// Lets time pass.
    pub fn run_s(&mut self, seconds: f64) {
        let end_us = self.now_us + (seconds * 1e6) as u64;
        while self.now_us < end_us {
            self.exchange((end_us - self.now_us) as u32, &[]);
        }
    }

    /// Asks, and waits for the answer.
    pub fn ask(&mut self, request: &Request) -> Response {
        let sequence = self.send(request);
        let until_us = self.now_us + 1_000_000;
        while self.now_us < until_us {
            match self.answer.take() {
                Some((number, response)) if number == sequence => return response,
                _ => self.exchange(1_000, &[]),
            }
        }
        panic!("no answer to {request:?}");
    }

    /// Asks for the status every two milliseconds until the board answers, `patience_s` at most: it may be in a reset.
    pub fn status_as_soon_as(&mut self, patience_s: f64) -> Option<Status> {
        let until_us = self.now_us + (patience_s * 1e6) as u64;
        while self.now_us < until_us {
            let sequence = self.send(&Request::Status);
            self.run_s(2e-3);
            match self.answer.take() {
                Some((number, Response::Status(status))) if number == sequence => {
                    return Some(status);
                }
                _ => {}
            }
        }
        None
    }

    /// Asks for something that is simply done.
    pub fn order(&mut self, request: &Request) {
        assert_eq!(self.ask(request), Response::Done, "{request:?}");
    }

    /// Sends a request without waiting.
    pub fn send(&mut self, request: &Request) -> u16 {
        self.sequence = self.sequence.wrapping_add(1);
        // The zero closes whatever a lost byte has left open.
        let mut bytes = [0; 1 + MAX_FRAME];
        let length = encode_request(request, self.sequence, &mut bytes[1..]).unwrap();
        self.exchange(1, &bytes[..=length]);
        self.sequence
    }

    /// Sends bytes as they are, and waits until the board has had them.
    pub fn raw(&mut self, bytes: &[u8]) {
        self.exchange(1, bytes);
        self.run_s(10e-3);
    }

    pub fn status(&mut self) -> Status {
        match self.ask(&Request::Status) {
            Response::Status(status) => status,
            other => panic!("{other:?}"),
        }
    }

    /// Streams counts and what else is wanted.
    pub fn stream(&mut self, values: bool, pose: bool) {
        self.order(&Request::Stream(StreamContent {
            counts: true,
            values,
            pose,
        }));
    }

    /// Lets the host go away and returns the runs of triggers until now.
    pub fn triggers(mut self) -> Vec<TriggerRun> {
        self.stream.shutdown(std::net::Shutdown::Both).unwrap();
        let mut line = String::new();
        self.stdout.read_line(&mut line).unwrap();
        serde_json::from_str::<Counts>(&line).unwrap().triggers
    }

    fn exchange(&mut self, run_us: u32, bytes: &[u8]) {
        let mut request = run_us.to_le_bytes().to_vec();
        request.extend((bytes.len() as u32).to_le_bytes());
        request.extend(bytes);
        self.stream.write_all(&request).unwrap();
        let mut head = [0; 12];
        self.stream.read_exact(&mut head).unwrap();
        self.now_us = u64::from_le_bytes(*head.first_chunk().unwrap());
        let mut sent = vec![0; u32::from_le_bytes(*head.last_chunk().unwrap()) as usize];
        self.stream.read_exact(&mut sent).unwrap();
        for byte in sent {
            self.held += 1;
            let Some(closed) = self.deframer.push(byte) else {
                continue;
            };
            let Closed::Frame(bytes) = closed else {
                panic!("an overlong frame");
            };
            let frame = match frame::decode(bytes) {
                Err(_) if self.faulty => continue,
                frame => frame.unwrap(),
            };
            let length = std::mem::take(&mut self.held);
            match frame.kind {
                Kind::Response => {
                    self.answer = Some((frame.sequence, decode_response(frame.payload).unwrap()));
                }
                Kind::Block => self.blocks.push(Arrived {
                    at_us: self.now_us,
                    bytes: length,
                    block: telemetry::decode(frame.payload).unwrap(),
                }),
                Kind::Pose => self.poses.push(pose::decode(frame.payload).unwrap()),
                _ => {}
            }
        }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_file(&self.flash);
        let _ = std::fs::remove_file(self.flash.with_extension("faults"));
    }
}
