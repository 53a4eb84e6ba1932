//! A board made of the core's own parts, on this side of a socket: frames, messages, sums, calibration and archive
//! are the core's; what is written here is only what answers which request, and what goes wrong on purpose.

#![allow(dead_code, reason = "every test takes what it needs")]

pub mod flash;
pub mod line;
pub mod set;
pub mod source;

use embassy_futures::block_on;
use hexsense::channel::Scan;
use hexsense::harmonics::{Analyser, ChannelSums};
use hexsense::live_pose::{JackBlock, Tracker};
use hexsense::sampling::{BLOCK, BlockSize, BlockSums, Calibrator};
use hexsense::store::{Archive, CoefficientSet, MAX_ENCODED, SetId};
use hexsense::wire::frame::{self, Closed, Deframer};
use hexsense::wire::hello::Greeting;
use hexsense::wire::message::{
    ActiveSet, CHUNK, PathCycles, ResetCause, decode_request, encode_response,
};
use hexsense::wire::telemetry::{self, Header, Samples};
use hexsense::wire::{
    BoardPose, Drive, HarmonicState, Identity, Kind, MAX_FRAME, PoseReport, Refusal, Request,
    Response, Status, StreamContent, VERSION, pose,
};

use flash::Flash;
use source::Source;

/// Scans of one second.
pub const RATE_HZ: u32 = 1_000;

/// What goes wrong, counted in requests from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// Nothing.
    None,
    /// The request is carried out, and its answer is lost.
    LoseAnswer(u32),
    /// The request is carried out, and its answer comes only with that of the next one.
    DelayAnswer(u32),
    /// The request is carried out, and its answer arrives with a bit changed.
    DamageAnswer(u32),
    /// The line is cut when this request comes.
    CutAt(u32),
    /// The board falls silent with this request: no answer, no sample any more.
    SilentFrom(u32),
    /// The flash gives back a changed set.
    WornFlash,
    /// The line is cut after so many blocks.
    CutAfterBlocks(u64),
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
    pub archive: Archive<Flash>,
    /// Loses the frames of these blocks, counted from the start of the board.
    pub lose_blocks: std::ops::Range<u64>,
    source: Box<dyn Source>,
    requests: u32,
    late: Vec<u8>,
    deframer: Deframer<MAX_FRAME>,
    active: Option<(ActiveSet, CoefficientSet, Vec<u8>)>,
    tracker: Option<Tracker<f32>>,
    upload: Option<(u16, SetId, Vec<u8>)>,
    analyser: Analyser,
    stream: StreamContent,
    blocks: u64,
}

impl FakeBoard {
    /// A board that measures what `source` has, with coefficients as `flash` has them.
    pub fn new(source: Box<dyn Source>, flash: Flash) -> Self {
        let archive = Archive::new(flash, 0..flash::SIZE as u32).unwrap();
        let mut board = Self {
            wire: VERSION,
            uid: source.uid(),
            fault: Fault::None,
            cut: false,
            crystal: true,
            archive,
            lose_blocks: 0..0,
            source,
            requests: 0,
            late: Vec::new(),
            deframer: Deframer::default(),
            active: None,
            tracker: None,
            upload: None,
            analyser: Analyser::new(),
            stream: StreamContent::default(),
            blocks: 0,
        };
        board.load();
        board
    }

    /// Switches a board on whose power was cut: its flash is as it was, everything else starts anew.
    pub fn switch_on(&mut self) {
        self.fault = Fault::None;
        self.cut = false;
        self.stream = StreamContent::default();
        self.upload = None;
        self.analyser = Analyser::new();
        self.blocks = 0;
        self.load();
    }

    /// Takes bytes from the host; what the board answers.
    pub fn take(&mut self, bytes: &[u8]) -> Vec<u8> {
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

    /// Lets 16 scans pass; the frame that is sent, if the board streams.
    pub fn block(&mut self) -> Option<Vec<u8>> {
        let first_scan = self.blocks * BLOCK as u64;
        self.blocks += 1;
        self.cut |= matches!(self.fault, Fault::CutAfterBlocks(blocks) if self.blocks > blocks);
        let scans: [Scan; BLOCK] = std::array::from_fn(|_| self.source.scan());
        self.analyser.take(&BlockSums::of_scans(&scans, first_scan));
        let silent = matches!(self.fault, Fault::SilentFrom(from) if self.requests >= from);
        let lost = self.lose_blocks.contains(&self.blocks);
        if silent || lost {
            return None;
        }
        let supply = self.source.supply();
        let mut frames = Vec::new();
        if self.stream.has_blocks() {
            frames.extend(self.block_frame(&scans, first_scan, supply));
        }
        if self.stream.pose {
            frames.extend(self.pose_frame(&JackBlock::new(first_scan, supply, &scans).unwrap()));
        }
        (!frames.is_empty()).then_some(frames)
    }

    fn block_frame(&self, scans: &[Scan; BLOCK], first_scan: u64, supply: f32) -> Vec<u8> {
        let values = match &self.active {
            Some((_, set, _)) => scans.map(|scan| Calibrator::new(set).apply(&scan, supply)),
            None => [[0.0; 9]; BLOCK],
        };
        let header = Header {
            first_scan,
            scans: BLOCK as u8,
            rate_hz: RATE_HZ,
            supply,
            temperature_c: 31.5,
            set: self.active.as_ref().map(|(active, ..)| active.id),
            dropped: 0,
            content: self.stream,
        };
        let mut buffer = [0; MAX_FRAME];
        let samples = Samples {
            inertial: &scans.map(|scan| *scan.first_chunk().unwrap()),
            jacks: &scans.map(|scan| *scan.last_chunk().unwrap()),
            values: &values,
        };
        let length = telemetry::encode(&header, samples, self.blocks as u16, &mut buffer);
        buffer[..length.unwrap()].to_vec()
    }

    fn pose_frame(&mut self, jacks: &JackBlock) -> Vec<u8> {
        let Some((active, ..)) = &self.active else {
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
        let response = match decode_request(payload) {
            Some(request) => match self.carry_out(request) {
                Ok(response) => response,
                Err(refusal) => Response::Refused(refusal),
            },
            None => Response::Refused(Refusal::Malformed),
        };
        match self.fault {
            Fault::CutAt(at) if self.requests >= at => self.cut = true,
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
                if (content.values || content.pose) && self.active.is_none() =>
            {
                return Err(Refusal::NoSet);
            }
            Request::Stream(content) => self.stream = content,
            Request::Rate(RATE_HZ) => self.analyser = Analyser::new(),
            Request::Rate(hz) => return Err(Refusal::Rate { hz }),
            Request::Block(_) => self.analyser = Analyser::new(),
            Request::Drive { drive, .. } => {
                drive.check().map_err(Refusal::Drive)?;
                self.analyser.start(drive);
            }
            Request::Harmonics { channel, .. } => return Ok(self.harmonics(channel)),
            Request::ActiveSet => {
                return Ok(Response::ActiveSet(
                    self.active.as_ref().map(|(active, ..)| *active),
                ));
            }
            Request::ReadSet { offset } => {
                let (_, _, encoded) = self.active.as_ref().ok_or(Refusal::NoSet)?;
                let bytes = encoded[usize::from(offset)..].iter().copied().take(CHUNK);
                let worn = u8::from(self.fault == Fault::WornFlash);
                let bytes = bytes.map(|byte| byte ^ worn).collect();
                return Ok(Response::SetBytes { offset, bytes });
            }
            Request::UploadBegin { length, id } => self.upload = Some((length, id, Vec::new())),
            Request::UploadChunk { offset, bytes } => {
                let (_, _, arrived) = self.upload.as_mut().ok_or(Refusal::NoUpload)?;
                if usize::from(offset) != arrived.len() {
                    return Err(Refusal::OutOfOrder {
                        expected: arrived.len() as u16,
                    });
                }
                arrived.extend_from_slice(&bytes);
            }
            Request::UploadCommit => return self.commit(),
            Request::UploadAbort => self.upload = None,
        }
        Ok(Response::Done)
    }

    fn commit(&mut self) -> Result<Response, Refusal> {
        let (length, id, bytes) = self.upload.take().ok_or(Refusal::NoUpload)?;
        if bytes.len() != usize::from(length) || CoefficientSet::id_of(&bytes) != id {
            return Err(Refusal::WrongIdentity);
        }
        let set = CoefficientSet::decode(&bytes).map_err(Refusal::Record)?;
        if set.board != self.uid {
            return Err(Refusal::OtherBoard);
        }
        block_on(self.archive.append(&bytes)).map_err(|_| Refusal::Flash)?;
        self.load();
        self.active
            .as_ref()
            .map(|(active, ..)| Response::Committed(*active))
            .ok_or(Refusal::Flash)
    }

    fn load(&mut self) {
        let stored = block_on(self.archive.newest()).unwrap();
        self.active = stored.map(|stored| {
            let mut buffer = [0; MAX_ENCODED];
            let encoded = stored.set.encode(&mut buffer).unwrap().to_vec();
            let length = encoded.len() as u16;
            let active = ActiveSet {
                id: stored.id,
                sequence: stored.sequence,
                length,
            };
            (active, stored.set, encoded)
        });
        let sets = self.active.as_ref().map(|(_, set, _)| set);
        self.tracker = sets.map(|set| Tracker::new(&set.base, &set.jacks).unwrap());
    }

    fn harmonics(&self, channel: u8) -> Response {
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
        let (drive, first_scan, sums) = self.analyser.report(channel.into()).unwrap_or(idle);
        Response::Harmonics {
            state: self.analyser.state(),
            drive,
            first_scan,
            sums,
        }
    }

    fn status(&self) -> Status {
        Status {
            uptime_ms: self.blocks * 16,
            rate_hz: RATE_HZ,
            scans: self.blocks * BLOCK as u64,
            block: BlockSize::default(),
            scans_lost: 0,
            first_lost_scan: None,
            faults: 0,
            path_cycles: PathCycles::default(),
            analysers: [
                self.analyser.state(),
                HarmonicState::Idle,
                HarmonicState::Idle,
            ],
            blocks_dropped: 0,
            frames_damaged: 0,
            crystal: self.crystal,
            supply: self.source.supply(),
            temperature_c: 31.5,
            in_calibrated_range: self.active.is_some(),
            tilt_approximate_rad: None,
            panic: None,
        }
    }
}
