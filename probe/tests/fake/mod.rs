//! A board made of the core's own parts, on this side of a socket: frames, messages, sums, calibration and the
//! storage of the coefficients are the core's; what is written here is only what answers which request, and what goes wrong on purpose.

#![allow(dead_code, reason = "every test takes what it needs")]

pub mod bench;
pub mod flash;
pub mod key;
pub mod line;
pub mod set;
pub mod source;

use std::time::Duration;

use embassy_futures::block_on;
use hexsense_core::authority;
use hexsense_core::channel::Scan;
use hexsense_core::harmonics::{ANALYSERS, Analyser, ChannelSums, solve_channel};
use hexsense_core::live_pose::{JackBlock, Tracker};
use hexsense_core::sampling::{BlockSize, BlockSums, Calibrator, RATES_HZ, Values};
use hexsense_core::storage::{Active, Command, Storage};
use hexsense_core::wire::change::{Act, Challenge, Change};
use hexsense_core::wire::frame::{self, Closed, Deframer};
use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::message::{ChannelHarmonics, decode_request, encode_response};
use hexsense_core::wire::status::{Events, PathCycles, ResetCause, Resets, StackUse};
use hexsense_core::wire::telemetry::{self, Header, MAX_SCANS, Samples};
use hexsense_core::wire::{
    AnalyserState, BoardPose, Drive, Identity, Kind, MAX_FRAME, PoseReport, Refusal, Request,
    Response, Status, StreamContent, VERSION, pose,
};

use flash::Flash;
use key::KEY;
use source::Source;

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
}

/// The board.
pub struct FakeBoard {
    pub wire: u16,
    pub uid: [u8; 12],
    pub fault: Fault,
    pub cut: bool,
    pub crystal: bool,
    pub flash: Flash,
    /// Every byte that came from hosts.
    pub heard: Vec<u8>,
    /// Loses the frames of these blocks, counted from the start of the board.
    pub lose_blocks: std::ops::Range<u64>,
    /// What a block takes of the time of the test.
    pub pace: Duration,
    source: Box<dyn Source>,
    requests: u32,
    late: Vec<u8>,
    deframer: Deframer<MAX_FRAME>,
    storage: Storage<Flash>,
    challenges: u128,
    tracker: Option<Tracker<f32>>,
    analysers: [Analyser; ANALYSERS],
    stream: StreamContent,
    rate_hz: u32,
    block: BlockSize,
    blocks: u64,
    scans: u64,
    uptime: Duration,
}

impl FakeBoard {
    /// A board with [`KEY`] that measures what `source` has.
    pub fn new(source: Box<dyn Source>) -> Self {
        let mut board = Self::unprovisioned(source);
        let Ok(Response::Challenge(challenge)) = board.keep(Command::Challenge) else {
            panic!("a challenge is always given");
        };
        let act = Act::Provision(KEY);
        let change = Change { unix_s: 1, act };
        let tag = authority::tag(&KEY, &challenge, &board.uid, &change);
        board.keep(Command::Change(change, tag)).unwrap();
        board
    }

    /// A board without a key.
    pub fn unprovisioned(source: Box<dyn Source>) -> Self {
        let (uid, flash) = (source.uid(), Flash::default());
        let mut board = Self {
            wire: VERSION,
            uid,
            fault: Fault::None,
            cut: false,
            crystal: true,
            storage: Storage::new(flash.clone(), uid),
            flash,
            heard: Vec::new(),
            lose_blocks: 0..0,
            pace: Duration::ZERO,
            source,
            requests: 0,
            late: Vec::new(),
            deframer: Deframer::default(),
            challenges: 0,
            tracker: None,
            analysers: Default::default(),
            stream: StreamContent::default(),
            rate_hz: RATE_HZ,
            block: BlockSize::default(),
            blocks: 0,
            scans: 0,
            uptime: Duration::ZERO,
        };
        board.load();
        board
    }

    /// Switches a board on whose power was cut: its flash is as it was, everything else starts anew.
    pub fn switch_on(&mut self) {
        self.fault = Fault::None;
        self.cut = false;
        self.stream = StreamContent::default();
        self.analysers = Default::default();
        (self.rate_hz, self.block) = (RATE_HZ, BlockSize::default());
        (self.blocks, self.scans, self.uptime) = (0, 0, Duration::ZERO);
        self.load();
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
        self.stream.has_blocks()
    }

    /// Counter of the next scan.
    pub fn scans(&self) -> u64 {
        self.scans
    }

    /// Takes bytes from the host; what the board answers.
    pub fn take(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.heard.extend_from_slice(bytes);
        let mut out = Vec::new();
        for byte in bytes {
            let Some(Closed::Frame(frame)) = self.deframer.push(*byte) else {
                continue;
            };
            let Ok(frame) = frame::decode(frame) else {
                continue;
            };
            let (kind, sequence, payload) = (frame.kind, frame.sequence, frame.payload.to_vec());
            let mut buffer = [0; MAX_FRAME];
            let length = match kind {
                Kind::Hello if self.fault == Fault::SilentFrom(0) => continue,
                Kind::Hello => {
                    let greeting = Greeting {
                        wire: self.wire,
                        firmware: [9, 8, 7],
                    };
                    greeting.encode(sequence, &mut buffer).unwrap()
                }
                Kind::Request => match self.answer(&payload) {
                    Some(response) => encode_response(&response, sequence, &mut buffer).unwrap(),
                    None => continue,
                },
                _ => continue,
            };
            if self.fault == Fault::DelayAnswer(self.requests) && kind == Kind::Request {
                self.late = buffer[..length].to_vec();
                continue;
            }
            out.append(&mut self.late);
            if self.fault == Fault::DamageAnswer(self.requests) && kind == Kind::Request {
                buffer[length / 2] ^= 0x10;
            }
            out.extend_from_slice(&buffer[..length]);
        }
        out
    }

    /// Time of one block.
    pub fn block_time(&self) -> Duration {
        Duration::from_micros(1_000_000 / u64::from(self.rate_hz)) * self.block.scans() as u32
    }

    /// Lets a block pass; the frames that are sent, if the board streams.
    pub fn block(&mut self) -> Option<Vec<u8>> {
        let first_scan = self.scans;
        self.blocks += 1;
        self.uptime += self.block_time();
        self.scans += self.block.scans() as u64;
        self.cut |= matches!(
            self.fault,
            Fault::CutAfterBlocks(blocks)
            | Fault::LineCutAfterBlocks(blocks)
            | Fault::SwappedAfterBlocks(blocks) if self.blocks > blocks
        );
        let scans = 0..self.block.scans();
        let scans: Vec<Scan> = scans.map(|_| self.source.scan(self.rate_hz)).collect();
        for analyser in &mut self.analysers {
            analyser.take(&BlockSums::of_scans(&scans, first_scan));
        }
        let silent = match self.fault {
            Fault::SilentFrom(from) => self.requests >= from,
            Fault::StarvesAfterBlocks(blocks) => self.blocks > blocks,
            _ => false,
        };
        let lost = self.lose_blocks.contains(&self.blocks);
        if silent || lost {
            return None;
        }
        let supply = self.source.supply();
        let mut frames = Vec::new();
        if self.stream.has_blocks() {
            let first_scans = (first_scan..).step_by(MAX_SCANS);
            for (scans, first_scan) in scans.chunks(MAX_SCANS).zip(first_scans) {
                frames.extend(self.block_frame(scans, first_scan, supply));
            }
        }
        if self.stream.pose {
            frames.extend(self.pose_frame(&JackBlock::new(first_scan, supply, &scans).unwrap()));
        }
        (!frames.is_empty()).then_some(frames)
    }

    fn block_frame(&self, scans: &[Scan], first_scan: u64, supply: f32) -> Vec<u8> {
        let active = self.storage.active();
        let calibrator = active.map(|active| Calibrator::new(&active.content));
        let value = |scan| {
            calibrator
                .as_ref()
                .map(|calibrator| calibrator.apply(scan, supply))
        };
        let values: Vec<Values> = scans
            .iter()
            .map(|scan| value(scan).unwrap_or_default())
            .collect();
        let inertial: Vec<_> = scans
            .iter()
            .map(|scan| *scan.first_chunk().unwrap())
            .collect();
        let jacks: Vec<_> = scans
            .iter()
            .map(|scan| *scan.last_chunk().unwrap())
            .collect();
        let header = Header {
            first_scan,
            scans: scans.len() as u8,
            rate_hz: self.rate_hz,
            supply,
            temperature_c: 31.5,
            set: active.map(|active| active.set.id),
            dropped: 0,
            content: self.stream,
        };
        let mut buffer = [0; MAX_FRAME];
        let samples = Samples {
            inertial: &inertial,
            jacks: &jacks,
            values: &values,
        };
        let length = telemetry::encode(&header, samples, self.blocks as u16, &mut buffer);
        buffer[..length.unwrap()].to_vec()
    }

    fn pose_frame(&mut self, jacks: &JackBlock) -> Vec<u8> {
        let Some(Active { set: active, .. }) = self.storage.active() else {
            return Vec::new();
        };
        let tracker = self.tracker.as_mut().expect("an active set has a tracker");
        let mut outcome = tracker.next(jacks).map(Into::into).map_err(Into::into);
        if let (Ok(pose), Fault::PoseOff(off_m)) = (&mut outcome, self.fault) {
            let pose: &mut BoardPose = pose;
            pose.position_m[0] += off_m;
        }
        let report = PoseReport {
            first_scan: jacks.first_scan,
            block: jacks.block,
            set: active.id,
            outcome,
        };
        let mut buffer = [0; MAX_FRAME];
        let length = pose::encode(&report, self.blocks as u16, &mut buffer).unwrap();
        buffer[..length].to_vec()
    }

    fn answer(&mut self, payload: &[u8]) -> Option<Response> {
        self.requests += 1;
        if self.fault == Fault::LoseRequest(self.requests) {
            return None;
        }
        let response = match decode_request(payload) {
            Some(request) => match self.carry_out(request) {
                Ok(response) => response,
                Err(refusal) => Response::Refused(refusal),
            },
            None => Response::Refused(Refusal::Malformed),
        };
        match self.fault {
            Fault::CutAt(at) | Fault::CutAfter(at) if self.requests >= at => self.cut = true,
            Fault::LoseAnswer(at) if self.requests == at => return None,
            Fault::SilentFrom(from) if self.requests >= from => return None,
            _ => {}
        }
        Some(response)
    }

    fn carry_out(&mut self, request: Request) -> Result<Response, Refusal> {
        match request {
            // A power cut comes before the request is carried out.
            _ if matches!(self.fault, Fault::CutAt(at) if self.requests >= at) => {}
            Request::Identity => {
                return Ok(Response::Identity(Identity {
                    board: self.uid,
                    hardware: "fake board".try_into().unwrap(),
                    reset: ResetCause::PowerOn,
                }));
            }
            Request::Status => return Ok(Response::Status(self.status())),
            Request::Stream(content)
                if (content.values || content.pose) && self.storage.active().is_none() =>
            {
                return Err(Refusal::NoSet);
            }
            Request::Stream(content) => {
                carried(content, self.rate_hz, self.block)?;
                self.stream = content;
            }
            Request::Rate(hz) if !RATES_HZ.contains(&hz) => return Err(Refusal::Rate { hz }),
            Request::Rate(hz) => {
                carried(self.stream, hz, self.block)?;
                (self.rate_hz, self.analysers) = (hz, Default::default());
            }
            Request::Block(block) => {
                carried(self.stream, self.rate_hz, block)?;
                (self.block, self.analysers) = (block, Default::default());
            }
            Request::Drive { analyser, drive } => {
                drive.check().map_err(Refusal::Drive)?;
                if drive.block != self.block {
                    return Err(Refusal::OtherBlock {
                        drive: drive.block.scans() as u8,
                        board: self.block.scans() as u8,
                    });
                }
                let refusal = Refusal::Analyser { analyser };
                let analyser = self
                    .analysers
                    .get_mut(usize::from(analyser))
                    .ok_or(refusal)?;
                analyser.start(drive);
            }
            Request::Sums { analyser, channel } => {
                return Ok(harmonics(&self.analysers[usize::from(analyser)], channel));
            }
            Request::ActiveSet => return self.keep(Command::ActiveSet),
            Request::ReadSet { offset } => {
                let mut response = self.keep(Command::Read(offset))?;
                if let (Response::SetBytes { bytes, .. }, Fault::WornFlash) =
                    (&mut response, self.fault)
                {
                    bytes[0] ^= 1;
                }
                return Ok(response);
            }
            Request::History { age } => return self.keep(Command::History(age)),
            Request::Log { counter } => return self.keep(Command::Log(counter)),
            Request::Challenge => return self.keep(Command::Challenge),
            Request::Change { change, tag } => return self.keep(Command::Change(change, tag)),
            Request::UploadChunk { offset, bytes } => {
                return self.keep(Command::Chunk(offset, bytes));
            }
            Request::UploadCommit => return self.keep(Command::Commit),
            Request::UploadAbort => return self.keep(Command::Abort),
            Request::Harmonics { analyser, channel } => return self.fit(analyser, channel),
            Request::Motion { .. } => return Err(Refusal::NoSet),
        }
        Ok(Response::Done)
    }

    fn fit(&self, analyser: u8, channel: u8) -> Result<Response, Refusal> {
        let found = self.analysers.get(usize::from(analyser));
        let found = found.ok_or(Refusal::Analyser { analyser })?;
        if found.state() != AnalyserState::Complete {
            return Err(Refusal::Incomplete { analyser });
        }
        let channel = usize::from(channel);
        let (drive, first_scan, sums) = found.report(channel).unwrap();
        let solved = solve_channel(&drive, self.rate_hz, channel, &sums);
        Ok(Response::Harmonics {
            drive,
            first_scan,
            harmonics: ChannelHarmonics::from(&solved.ok_or(Refusal::Undetermined {
                blocks: drive.blocks,
            })?),
        })
    }

    /// Has the storage carry out a command.
    fn keep(&mut self, command: Command) -> Result<Response, Refusal> {
        let now_ms = self.uptime.as_millis() as u64;
        let challenges = &mut self.challenges;
        let random = async |challenge: &mut Challenge| {
            *challenges += 1;
            *challenge = challenges.to_le_bytes();
            true
        };
        let before = self.storage.active().map(|active| active.set);
        let response = block_on(self.storage.carry_out(command, now_ms, random));
        if before != self.storage.active().map(|active| active.set) {
            self.track();
        }
        response
    }

    /// Starts a storage on what the flash has.
    fn load(&mut self) {
        self.storage = Storage::new(self.flash.clone(), self.uid);
        block_on(self.storage.load()).unwrap();
        block_on(self.storage.complete()).unwrap();
        self.track();
    }

    fn track(&mut self) {
        let active = self.storage.active().map(|active| &active.content);
        self.tracker = active.map(|set| Tracker::new(&set.base, &set.jacks).unwrap());
    }

    fn status(&self) -> Status {
        Status {
            uptime_ms: self.uptime.as_millis() as u64,
            rate_hz: self.rate_hz,
            scans: self.scans,
            block: self.block,
            scans_lost: 0,
            first_lost_scan: None,
            events: Events::NONE,
            first_with_set_ms: None,
            path_cycles: PathCycles {
                min: 4_400,
                max: 4_800,
                last: 4_500,
            },
            analysers: self.analysers.each_ref().map(Analyser::state),
            crystal: self.crystal,
            supply: self.source.supply(),
            supply_readings: 16,
            temperature_c: 31.5,
            in_calibrated_range: self.storage.active().is_some(),
            tilt_approximate_rad: None,
            resets: Resets::default(),
            stack: StackUse {
                deepest: 6_000,
                size: 24_576,
            },
            provisioned: self.storage.is_provisioned(),
            panic: None,
        }
    }
}

fn harmonics(analyser: &Analyser, channel: u8) -> Response {
    let idle = (
        Drive {
            increment: 0,
            block: BlockSize::default(),
            settle_blocks: 0,
            blocks: 0,
        },
        0,
        ChannelSums::default(),
    );
    let (drive, first_scan, sums) = analyser.report(channel.into()).unwrap_or(idle);
    Response::Sums {
        state: analyser.state(),
        drive,
        first_scan,
        sums,
    }
}

/// Refuses what the link does not carry.
fn carried(content: StreamContent, rate_hz: u32, block: BlockSize) -> Result<(), Refusal> {
    let bits_per_s = telemetry::bits_per_second(content, rate_hz, block);
    let limit = telemetry::MAX_BITS_PER_S;
    if bits_per_s > limit {
        return Err(Refusal::LinkCapacity { bits_per_s, limit });
    }
    Ok(())
}
