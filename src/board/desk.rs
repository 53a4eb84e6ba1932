//! The desk behind the link: what each request gets for an answer.
//!
//! Questions are answered at once from the latest values. Commands go to the task that can carry them out, the
//! sample path or the storage, and their answer follows when it comes; until then any other command is refused as
//! [`Refusal::Busy`], so that every answer belongs to the one command that is open.

use embassy_sync::channel::Channel;
use embassy_sync::watch::Receiver;
use embassy_time::Instant;
use hexsense::channel::CHANNELS;
use hexsense::live_pose::JackBlock;
use hexsense::sampling::{BlockSize, RATES_HZ};
use hexsense::wire::frame::{self, Closed};
use hexsense::wire::message::{
    self, PathCycles, Refusal, Request, Response, Status, StreamContent,
};
use hexsense::wire::telemetry::Header;
use hexsense::wire::{Drive, Frame, FrameError, HarmonicState, Kind, PoseReport, pose, telemetry};

use super::clock::Source;
use super::exchange::{Active, Exchange, Guard, Progress};
use super::identity::Origin;
use super::quick_look;
use super::sampling::{self, Block};
use super::storage;
use super::supply::Reading;

/// Longest frame that a host sends: a chunk of a set with all that goes around it, rounded up.
pub const MAX_REQUEST_FRAME: usize = 256;
/// A set's coefficients hold this far from the temperature that they were found at, K.
const CALIBRATED_RANGE_K: f32 = 10.0;

/// What the link knows and answers from.
pub struct Desk {
    origin: Origin,
    exchange: &'static Exchange,
    supply: Receiver<'static, Guard, Reading, 2>,
    active: Receiver<'static, Guard, Active, 2>,
    progress: Receiver<'static, Guard, Progress, 1>,
    stream: StreamContent,
    tilt: Option<[f32; 2]>,
    /// Sequence number of the command that another task is carrying out.
    open: Option<u16>,
    frames_damaged: u32,
    telemetry_sequence: u16,
}

/// What becomes of a request.
enum Outcome {
    Answer(Response),
    /// Another task will answer.
    Later,
}

impl Desk {
    /// A desk that streams nothing yet.
    pub fn new(origin: Origin, exchange: &'static Exchange) -> Self {
        // The exchange has one receiver of each for this task, which starts once.
        Self {
            origin,
            exchange,
            supply: exchange.supply.receiver().expect("a receiver is left"),
            active: exchange.active.receiver().expect("a receiver is left"),
            progress: exchange.progress.receiver().expect("a receiver is left"),
            stream: StreamContent::default(),
            tilt: None,
            open: None,
            frames_damaged: 0,
            telemetry_sequence: 0,
        }
    }

    /// Counts a damaged frame or a fault of the receiver.
    pub fn count_damaged(&mut self) {
        self.frames_damaged = self.frames_damaged.saturating_add(1);
    }

    /// Takes in what the host sent; returns the length of the frame to send back, if there is one by now.
    pub fn take_in(&mut self, closed: Closed<'_>, out: &mut [u8]) -> Option<usize> {
        let Closed::Frame(bytes) = closed else {
            self.count_damaged();
            return None;
        };
        let Ok(Frame {
            kind,
            sequence,
            payload,
        }) = frame::decode(bytes)
        else {
            self.count_damaged();
            return None;
        };
        match kind {
            Kind::Hello => sendable(self.origin.greeting().encode(sequence, out)),
            Kind::Request => {
                let outcome = match message::decode_request(payload) {
                    Some(request) => self.decide(request, sequence),
                    None => Err(Refusal::Malformed),
                };
                match outcome {
                    Ok(Outcome::Later) => None,
                    Ok(Outcome::Answer(answer)) => encode(&answer, sequence, out),
                    Err(refusal) => encode(&Response::Refused(refusal), sequence, out),
                }
            }
            Kind::Greeting | Kind::Response | Kind::Block | Kind::Pose => {
                self.count_damaged();
                None
            }
        }
    }

    /// Takes another task's answer; returns the length of the frame to send.
    pub fn hand_out(&mut self, answer: &Response, out: &mut [u8]) -> Option<usize> {
        let sequence = self.open.take()?;
        encode(answer, sequence, out)
    }

    /// Looks at a block, and hands over its jacks when the host wants poses; returns the length of the frame to send
    /// when it wants blocks.
    pub fn pass_on(&mut self, block: &Block, out: &mut [u8]) -> Option<usize> {
        self.tilt = block.header.set.map(|_| quick_look::tilt(&block.values));
        if self.stream.pose {
            let Header {
                first_scan, supply, ..
            } = block.header;
            if let Some(jacks) = JackBlock::new(first_scan, supply, &block.counts) {
                self.exchange.jacks.signal(jacks);
            }
        }
        if !self.stream.has_blocks() {
            return None;
        }
        let header = Header {
            content: self.stream,
            ..block.header
        };
        let sequence = self.next_telemetry();
        let samples = telemetry::Samples {
            inertial: &block.counts.map(|scan| core::array::from_fn(|n| scan[n])),
            jacks: &block
                .counts
                .map(|scan| core::array::from_fn(|n| scan[9 + n])),
            values: &block.values,
        };
        sendable(telemetry::encode(&header, samples, sequence, out))
    }

    /// Takes a pose; returns the length of the frame to send, when the host still wants poses.
    pub fn pass_on_pose(&mut self, report: &PoseReport, out: &mut [u8]) -> Option<usize> {
        if !self.stream.pose {
            return None;
        }
        sendable(pose::encode(report, self.next_telemetry(), out))
    }

    fn next_telemetry(&mut self) -> u16 {
        let sequence = self.telemetry_sequence;
        self.telemetry_sequence = sequence.wrapping_add(1);
        sequence
    }

    fn decide(&mut self, request: Request, sequence: u16) -> Result<Outcome, Refusal> {
        let command = match request {
            Request::Identity => {
                return Ok(Outcome::Answer(Response::Identity(self.origin.identity())));
            }
            Request::Status => return Ok(Outcome::Answer(Response::Status(self.status()))),
            Request::Stream(content) => return self.set_stream(content),
            Request::Rate(hz) => return self.set_rate(hz, sequence),
            Request::Block(_) => return Err(Refusal::Busy),
            Request::Drive { drive, .. } => return self.set_drive(drive, sequence),
            Request::Harmonics { channel, .. } => return self.report_harmonics(channel, sequence),
            Request::ActiveSet => storage::Command::ActiveSet,
            Request::ReadSet { offset } => storage::Command::Read(offset),
            Request::UploadBegin { length, id } => storage::Command::Begin(length, id),
            Request::UploadChunk { offset, bytes } => storage::Command::Chunk(offset, bytes),
            Request::UploadCommit => storage::Command::Commit,
            Request::UploadAbort => storage::Command::Abort,
        };
        self.order(&self.exchange.to_storage, command, sequence)
    }

    fn set_stream(&mut self, content: StreamContent) -> Result<Outcome, Refusal> {
        if (content.values || content.pose) && !self.active.contains_value() {
            return Err(Refusal::NoSet);
        }
        check_capacity(content, self.rate_hz())?;
        self.stream = content;
        Ok(Outcome::Answer(Response::Done))
    }

    fn set_rate(&mut self, hz: u32, sequence: u16) -> Result<Outcome, Refusal> {
        if !RATES_HZ.contains(&hz) {
            return Err(Refusal::Rate { hz });
        }
        check_capacity(self.stream, hz)?;
        self.order(
            &self.exchange.to_sampling,
            sampling::Command::Rate(hz),
            sequence,
        )
    }

    fn set_drive(&mut self, drive: Drive, sequence: u16) -> Result<Outcome, Refusal> {
        if self.origin.clock != Source::Crystal {
            return Err(Refusal::NoCrystal);
        }
        drive.check().map_err(Refusal::Drive)?;
        self.order(
            &self.exchange.to_sampling,
            sampling::Command::Drive(drive),
            sequence,
        )
    }

    fn report_harmonics(&mut self, channel: u8, sequence: u16) -> Result<Outcome, Refusal> {
        if usize::from(channel) >= CHANNELS {
            return Err(Refusal::Channel { channel });
        }
        let command = sampling::Command::Harmonics(channel);
        self.order(&self.exchange.to_sampling, command, sequence)
    }

    /// Gives a command to another task, if none is open.
    fn order<T>(
        &mut self,
        to: &'static Channel<Guard, T, 1>,
        command: T,
        sequence: u16,
    ) -> Result<Outcome, Refusal> {
        if self.open.is_some() || to.try_send(command).is_err() {
            return Err(Refusal::Busy);
        }
        self.open = Some(sequence);
        Ok(Outcome::Later)
    }

    fn rate_hz(&mut self) -> u32 {
        self.progress.try_get().unwrap_or_default().rate_hz
    }

    fn status(&mut self) -> Status {
        let progress = self.progress.try_get().unwrap_or_default();
        let supply = self.supply.try_get();
        let calibrated_c = self.active.try_get().map(|active| active.temperature_c);
        let in_calibrated_range = supply
            .zip(calibrated_c)
            .is_some_and(|(now, then)| (now.temperature_c - then).abs() <= CALIBRATED_RANGE_K);
        Status {
            uptime_ms: Instant::now().as_millis(),
            rate_hz: progress.rate_hz,
            scans: progress.scans,
            block: BlockSize::default(),
            first_lost_scan: None,
            faults: 0,
            path_cycles: PathCycles::default(),
            analysers: [HarmonicState::Idle; 3],
            scans_lost: progress.lost,
            blocks_dropped: progress.dropped,
            frames_damaged: self.frames_damaged,
            crystal: self.origin.clock == Source::Crystal,
            supply: supply.map_or(f32::NAN, Reading::factor),
            temperature_c: supply.map_or(f32::NAN, |reading| reading.temperature_c),
            in_calibrated_range,
            tilt_approximate_rad: self.tilt,
            panic: self.origin.panic.clone(),
        }
    }
}

fn check_capacity(content: StreamContent, rate_hz: u32) -> Result<(), Refusal> {
    let bits_per_s = telemetry::bits_per_second(content, rate_hz, BlockSize::default());
    if bits_per_s > telemetry::LIMIT_BITS_PER_S {
        return Err(Refusal::LinkCapacity {
            bits_per_s,
            limit: telemetry::LIMIT_BITS_PER_S,
        });
    }
    Ok(())
}

fn encode(answer: &Response, sequence: u16, out: &mut [u8]) -> Option<usize> {
    sendable(message::encode_response(answer, sequence, out))
}

/// Every answer fits a frame, so an error here is a mistake of the build; the host will ask again.
fn sendable(encoded: Result<usize, FrameError>) -> Option<usize> {
    encoded
        .inspect_err(|_| defmt::error!("an answer does not fit a frame"))
        .ok()
}
