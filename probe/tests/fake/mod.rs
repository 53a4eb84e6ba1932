//! A board on this side of a socket: the server, the sample path and the storage of the core, as on the real board. What is
//! written here is only what is fake ([`parts`]) and what goes wrong on purpose.

#![allow(dead_code, reason = "every test takes what it needs")]

pub mod bench;
pub mod desk;
pub mod flash;
pub mod key;
pub mod line;
pub mod parts;
pub mod set;
pub mod source;

use std::ops::{Deref, DerefMut};
use std::time::Duration;

use hexsense_core::authority;
use hexsense_core::server::{MAX_REQUEST_FRAME, Server};
use hexsense_core::storage::{Active, StorageCommand};
use hexsense_core::wire::change::{Act, Change};
use hexsense_core::wire::frame::{self, Closed, Deframer};
use hexsense_core::wire::{Kind, MAX_FRAME, Request, Response, message};

use key::KEY;
use parts::Parts;
use source::{Source, Still};

/// Scans of one second after the start.
pub const RATE_HZ: u32 = 1_000;

/// Blocks that pass while a line is cut.
pub const AWAY_BLOCKS: u64 = 30;

/// What goes wrong, counted in requests from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// Nothing.
    None,
    /// The request is lost on the way.
    LoseRequest(u32),
    /// The request is carried out, and its answer is lost.
    LoseAnswer(u32),
    /// The request is carried out, and its answer comes only with that of the next one.
    DelayAnswer(u32),
    /// The request is carried out, and its answer arrives with a bit changed.
    DamageAnswer(u32),
    /// The line is cut when this request comes.
    CutAt(u32),
    /// The line is cut when this request has been carried out.
    CutAfter(u32),
    /// The board falls silent with this request: no answer, no sample any more. From 0 on it does not even greet.
    SilentFrom(u32),
    /// The flash gives back a changed set.
    WornFlash,
    /// The line is cut after so many blocks.
    CutAfterBlocks(u64),
    /// The line is cut after so many blocks, and the board goes on meanwhile.
    LineCutAfterBlocks(u64),
    /// The line is cut after so many blocks, and another board comes back.
    SwappedAfterBlocks(u64),
    /// The board sends no block any more after so many.
    StarvesAfterBlocks(u64),
    /// The board's poses are off by so much along X, m.
    PoseOff(f32),
    /// The board has had no good reading of its supply for a second.
    OldSupply,
    /// The supply factor in its blocks is no number.
    NoSupplyFactor,
    /// The temperature in its blocks is no number.
    NoTemperature,
    /// Its values are no numbers.
    NoValues,
}

/// The board.
pub struct FakeBoard {
    server: Server<Parts>,
    pub cut: bool,
    /// Every byte that came from hosts.
    pub heard: Vec<u8>,
    /// Loses the frames of these blocks, counted from the start of the board.
    pub lose_blocks: std::ops::Range<u64>,
    /// What a block takes of the time of the test.
    pub pace: Duration,
    deframer: Deframer<MAX_REQUEST_FRAME>,
    requests: u32,
    late: Vec<u8>,
    blocks: u64,
    /// What somebody on the line does with a request.
    pub lie: fn(&Request) -> Lie,
    /// The frames that somebody on the line holds back.
    held: Vec<Vec<u8>>,
}

/// What somebody on the line does with a request.
#[allow(
    clippy::large_enum_variant,
    reason = "one exists at a time, and a box in each test says nothing"
)]
pub enum Lie {
    /// It passes, and so does its answer.
    None,
    /// It is held back, and answered by the liar or not at all.
    Hold(Option<Response>),
}

/// Wire version, unique id, crystal, flash and fault can be set as if they were the board's own.
impl Deref for FakeBoard {
    type Target = Parts;

    fn deref(&self) -> &Parts {
        &self.server.board
    }
}

impl DerefMut for FakeBoard {
    fn deref_mut(&mut self) -> &mut Parts {
        &mut self.server.board
    }
}

impl FakeBoard {
    /// A board with [`KEY`] that measures what `source` has.
    pub fn new(source: Box<dyn Source>) -> Self {
        let mut board = Self::unprovisioned(source);
        let Ok(Response::Challenge(challenge)) = board.keep(StorageCommand::Challenge) else {
            panic!("a challenge is always given");
        };
        let act = Act::Provision(KEY);
        let change = Change { unix_s: 1, act };
        let tag = authority::tag(&KEY, &challenge, &board.uid, &change);
        board.keep(StorageCommand::Change(change, tag)).unwrap();
        board
    }

    /// A board without a key.
    pub fn unprovisioned(source: Box<dyn Source>) -> Self {
        Self::with(Parts::new(source))
    }

    fn with(parts: Parts) -> Self {
        Self {
            server: Server::new(parts),
            cut: false,
            heard: Vec::new(),
            lose_blocks: 0..0,
            pace: Duration::ZERO,
            deframer: Deframer::default(),
            requests: 0,
            late: Vec::new(),
            blocks: 0,
            lie: |_| Lie::None,
            held: Vec::new(),
        }
    }

    /// Switches a board on whose power was cut: its flash is as it was, everything else starts anew.
    pub fn switch_on(&mut self) {
        let nothing = Self::unprovisioned(Box::new(Still));
        *self = std::mem::replace(self, nothing).restarted();
    }

    fn restarted(self) -> Self {
        let Self {
            server,
            heard,
            lose_blocks,
            pace,
            requests,
            ..
        } = self;
        let mut parts = server.board;
        parts.fault = Fault::None;
        parts.start();
        Self {
            heard,
            lose_blocks,
            pace,
            requests,
            ..Self::with(parts)
        }
    }

    /// Lets all requests arrive that somebody on the line held back, again with each call; what the board answers.
    pub fn deliver(&mut self) -> Vec<Response> {
        let held = self.held.clone();
        let answers = held.into_iter().map(|mut frame| {
            let mut answer = self.answer(&mut frame);
            let length = answer.len() - 1;
            let frame = frame::decode(&mut answer[..length]).unwrap();
            message::decode_response(frame.payload).unwrap()
        });
        answers.collect()
    }

    /// What a liar on the line does with a frame; its answer, when it takes the frame.
    fn lie_to(&mut self, bytes: &[u8]) -> Option<Vec<u8>> {
        let mut copy = bytes.to_vec();
        let frame = frame::decode(&mut copy).ok()?;
        let request = message::decode_request(frame.payload)?;
        let Lie::Hold(answer) = (self.lie)(&request) else {
            return None;
        };
        let sequence = frame.sequence;
        self.held.push(bytes.to_vec());
        let mut out = vec![0; MAX_FRAME];
        let length = answer.map_or(0, |answer| {
            message::encode_response(&answer, sequence, &mut out).unwrap()
        });
        out.truncate(length);
        Some(out)
    }

    /// The active set.
    pub fn active(&self) -> Option<&Active> {
        self.storage.active()
    }

    /// Requests that were heard so far.
    pub fn requests(&self) -> u32 {
        self.requests
    }

    /// Lets time pass in which nothing happens.
    pub fn wait(&mut self, time: Duration) {
        self.uptime += time;
    }

    /// Comes back after the line was cut.
    pub fn come_back(&mut self) {
        match self.fault {
            Fault::LineCutAfterBlocks(_) => {
                (self.fault, self.cut) = (Fault::None, false);
                for _ in 0..AWAY_BLOCKS {
                    self.block();
                }
            }
            Fault::SwappedAfterBlocks(_) => {
                self.uid = *b"fake board 2";
                self.switch_on();
            }
            _ => self.switch_on(),
        }
    }

    /// Whether it sends blocks.
    pub fn streams(&self) -> bool {
        self.server.content().has_blocks()
    }

    /// Counter of the next scan.
    pub fn scans(&self) -> u64 {
        self.path().progress.next_scan
    }

    /// Takes bytes from the host; what the board answers.
    pub fn take(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.heard.extend_from_slice(bytes);
        let mut out = Vec::new();
        for byte in bytes {
            if let Some(Closed::Frame(frame)) = self.deframer.push(*byte) {
                let mut frame = frame.to_vec();
                self.frame(&mut frame, &mut out);
            }
        }
        out
    }

    fn frame(&mut self, bytes: &mut [u8], out: &mut Vec<u8>) {
        let kind = frame::decode(&mut bytes.to_vec()).map(|frame| frame.kind);
        match kind {
            Ok(Kind::Request) => self.request(bytes, out),
            Ok(Kind::Hello) if self.fault == Fault::SilentFrom(0) => {}
            _ => {
                let answer = self.answer(bytes);
                out.append(&mut self.late);
                out.extend(answer);
            }
        }
    }

    fn request(&mut self, bytes: &mut [u8], out: &mut Vec<u8>) {
        self.requests += 1;
        let number = self.requests;
        if self.fault == Fault::LoseRequest(number) {
            return;
        }
        if let Some(lie) = self.lie_to(bytes) {
            out.extend(lie);
            return;
        }
        if matches!(self.fault, Fault::CutAt(at) if number >= at) {
            self.cut = true;
            return;
        }
        let mut answer = self.answer(bytes);
        match self.fault {
            Fault::CutAfter(at) if number >= at => self.cut = true,
            Fault::LoseAnswer(at) if number == at => return,
            Fault::SilentFrom(from) if number >= from => return,
            Fault::DelayAnswer(at) if number == at => {
                self.late = answer;
                return;
            }
            Fault::DamageAnswer(at) if number == at => {
                let middle = answer.len() / 2;
                answer[middle] ^= 0x10;
            }
            _ => {}
        }
        out.append(&mut self.late);
        out.extend(answer);
    }

    /// What the server makes of a frame.
    fn answer(&mut self, bytes: &mut [u8]) -> Vec<u8> {
        let mut buffer = [0; MAX_FRAME];
        let mut length = self.server.take_in(Closed::Frame(bytes), &mut buffer);
        if let Some(answer) = self.answers.pop_front() {
            length = self.server.hand_out(&answer, &mut buffer);
        }
        buffer[..length.unwrap_or(0)].to_vec()
    }

    /// Lets a block pass; the frames that are sent, if the board streams.
    pub fn block(&mut self) -> Option<Vec<u8>> {
        self.blocks += 1;
        let number = self.blocks;
        self.sample();
        self.cut |= matches!(
            self.fault,
            Fault::CutAfterBlocks(blocks)
            | Fault::LineCutAfterBlocks(blocks)
            | Fault::SwappedAfterBlocks(blocks) if number > blocks
        );
        let frames = self.frames();
        let silent = match self.fault {
            Fault::SilentFrom(from) => self.requests >= from,
            Fault::StarvesAfterBlocks(blocks) => number > blocks,
            _ => false,
        };
        let lost = silent || self.lose_blocks.contains(&number);
        (!lost && !frames.is_empty()).then_some(frames)
    }

    /// The frames that are due: pieces of the queue, and poses.
    fn frames(&mut self) -> Vec<u8> {
        let mut frames = Vec::new();
        let mut buffer = [0; MAX_FRAME];
        while self.path().queue.is_due() {
            let length = self.server.pass_on(&mut buffer);
            frames.extend_from_slice(&buffer[..length.unwrap_or(0)]);
            while let Some(report) = self.poses.pop_front() {
                let length = self.server.pass_on_pose(&report, &mut buffer);
                frames.extend_from_slice(&buffer[..length.unwrap_or(0)]);
            }
        }
        frames
    }
}
