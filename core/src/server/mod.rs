//! The desk behind the link: what each request gets for an answer.
//!
//! Questions are answered at once from the latest values, and analysers are set and read at once, between two blocks of
//! the sample path. Other commands go to the task that can carry them
//! out, sampling, storage or harmonics, and their answer follows when it comes; until then any other command is refused as
//! [`Refusal::Busy`], so that every answer belongs to the one command that is open.

use core::sync::atomic::Ordering;

use embassy_sync::channel::Channel;
use embassy_sync::watch::Receiver;
use embassy_time::Instant;
use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::{ANALYSERS, Analyser, ChannelSums};
use hexsense_core::sampling::{BlockSize, RATES_HZ};
use hexsense_core::storage;
use hexsense_core::wire::frame::{self, Closed};
use hexsense_core::wire::message::{self, Request, Response, StreamContent};
use hexsense_core::wire::status::{Events, Status};
use hexsense_core::wire::{Drive, Frame, FrameError, Kind, PoseReport, Refusal, telemetry};

use super::clock::Source;
use super::exchange::{Active, Exchange, Guard};
use super::harmonics;
use super::identity::Origin;
use super::path::{self, Progress};
use super::quick_look;
use super::sampling;
use super::stack;
use super::supply::Reading;
use super::tallies;
use super::telemetry::Telemetry;

/// Longest frame that a host sends: a chunk of a set with all that goes around it, rounded up.
pub const MAX_REQUEST_FRAME: usize = 256;
/// A set's coefficients hold this far from the temperature that they were found at, K.
const CALIBRATED_RANGE_K: f32 = 10.0;

/// What is reported when nothing is estimated.
const NO_DRIVE: Drive = Drive {
    increment: 0,
    block: BlockSize::One,
    settle_blocks: 0,
    blocks: 0,
};

/// What the link knows and answers from.
pub struct Desk {
    origin: Origin,
    exchange: &'static Exchange,
    supply: Receiver<'static, Guard, Reading, 3>,
    active: Receiver<'static, Guard, Option<Active>, 2>,
    telemetry: Telemetry,
    /// Sequence number of the command that another task is carrying out.
    open: Option<u16>,
}

/// Answer to a request; none when another task will answer.
type Outcome = Option<Response>;

impl Desk {
    /// A desk that streams nothing yet.
    pub fn new(origin: Origin, exchange: &'static Exchange) -> Self {
        // The exchange has one receiver of each for this task, which starts once.
        Self {
            origin,
            exchange,
            supply: exchange.supply.receiver().expect("a receiver is left"),
            active: exchange.active.receiver().expect("a receiver is left"),
            telemetry: Telemetry::default(),
            open: None,
        }
    }

    /// Takes in what the host sent; returns the length of the frame to send back, if there is one by now.
    pub fn take_in(&mut self, closed: Closed<'_>, out: &mut [u8]) -> Option<usize> {
        let Closed::Frame(bytes) = closed else {
            tallies::note(|events| &mut events.frames_of_wrong_length);
            return None;
        };
        let Frame {
            kind,
            sequence,
            payload,
        } = frame::decode(bytes).inspect_err(count_damaged).ok()?;
        match kind {
            Kind::Hello => tallies::sendable(self.origin.greeting().encode(sequence, out)),
            Kind::Request => {
                let outcome = match message::decode_request(payload) {
                    Some(request) => self.decide(request, sequence),
                    None => Err(Refusal::Malformed),
                };
                match outcome {
                    Ok(None) => None,
                    Ok(Some(answer)) => encode(&answer, sequence, out),
                    Err(refusal) => encode(&Response::Refused(refusal), sequence, out),
                }
            }
            Kind::Greeting | Kind::Response | Kind::Block | Kind::Pose => {
                tallies::note(|events| &mut events.frames_of_wrong_kind);
                None
            }
        }
    }

    /// Takes another task's answer; returns the length of the frame to send.
    pub fn hand_out(&mut self, answer: &Response, out: &mut [u8]) -> Option<usize> {
        let sequence = self.open.take()?;
        encode(answer, sequence, out)
    }

    /// Passes on what the sample path has, see [`Telemetry::block`].
    pub fn pass_on(&mut self, out: &mut [u8]) -> Option<usize> {
        let (length, jacks) = self.telemetry.block(out);
        if let Some(jacks) = jacks {
            self.exchange.jacks.signal(jacks);
        }
        length
    }

    /// Takes a pose; returns the length of the frame to send, when the host still wants poses.
    pub fn pass_on_pose(&mut self, report: &PoseReport, out: &mut [u8]) -> Option<usize> {
        self.telemetry.pose(report, out)
    }

    fn decide(&mut self, request: Request, sequence: u16) -> Result<Outcome, Refusal> {
        let command = match request {
            Request::Identity => {
                return Ok(Some(Response::Identity(self.origin.identity())));
            }
            Request::Status => return Ok(Some(Response::Status(self.status()))),
            Request::Stream(content) => return self.set_stream(content),
            Request::Rate(hz) => return self.set_rate(hz, sequence),
            Request::Block(block) => return self.set_block(block, sequence),
            Request::Drive { analyser, drive } => return self.set_drive(analyser, drive),
            Request::Sums { analyser, channel } => return sums(analyser, channel),
            Request::Harmonics { analyser, channel } => {
                check(analyser, channel)?;
                let command = harmonics::Command::Harmonics(analyser, channel);
                return self.order(&self.exchange.to_harmonics, command, sequence);
            }
            Request::Motion { analyser } => {
                check(analyser, 0)?;
                let command = harmonics::Command::Motion(analyser);
                return self.order(&self.exchange.to_harmonics, command, sequence);
            }
            Request::ActiveSet => storage::Command::ActiveSet,
            Request::ReadSet { offset } => storage::Command::Read(offset),
            Request::History { age } => storage::Command::History(age),
            Request::Log { counter } => storage::Command::Log(counter),
            Request::Challenge => storage::Command::Challenge,
            Request::Change { change, tag } => storage::Command::Change(change, tag),
            Request::UploadChunk { offset, bytes } => storage::Command::Chunk(offset, bytes),
            Request::UploadCommit => storage::Command::Commit,
            Request::UploadAbort => storage::Command::Abort,
        };
        self.order(&self.exchange.to_storage, command, sequence)
    }

    fn active(&mut self) -> Option<Active> {
        self.active.try_get().flatten()
    }

    fn set_stream(&mut self, content: StreamContent) -> Result<Outcome, Refusal> {
        if (content.values || content.pose) && self.active().is_none() {
            return Err(Refusal::NoSet);
        }
        let Progress { rate_hz, block, .. } = path::with(|path| path.progress);
        check_capacity(content, rate_hz, block)?;
        self.telemetry.content = content;
        path::with(|path| path.set_stream(content));
        Ok(Some(Response::Done))
    }

    fn set_rate(&mut self, hz: u32, sequence: u16) -> Result<Outcome, Refusal> {
        if !RATES_HZ.contains(&hz) {
            return Err(Refusal::Rate { hz });
        }
        let block = path::with(|path| path.progress.block);
        check_capacity(self.telemetry.content, hz, block)?;
        let command = sampling::Command::Rate(hz);
        self.order(&self.exchange.to_sampling, command, sequence)
    }

    fn set_block(&mut self, block: BlockSize, sequence: u16) -> Result<Outcome, Refusal> {
        let rate_hz = path::with(|path| path.progress.rate_hz);
        check_capacity(self.telemetry.content, rate_hz, block)?;
        let command = sampling::Command::Block(block);
        self.order(&self.exchange.to_sampling, command, sequence)
    }

    fn set_drive(&mut self, analyser: u8, drive: Drive) -> Result<Outcome, Refusal> {
        if self.origin.clock != Source::Crystal {
            return Err(Refusal::NoCrystal);
        }
        drive.check().map_err(Refusal::Drive)?;
        path::with(|path| {
            let board = path.progress.block;
            if drive.block != board {
                return Err(Refusal::OtherBlock {
                    drive: drive.block.scans() as u8,
                    board: board.scans() as u8,
                });
            }
            path.analysers
                .get_mut(usize::from(analyser))
                .ok_or(Refusal::Analyser { analyser })?
                .start(drive);
            Ok(Some(Response::Done))
        })
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
        Ok(None)
    }

    fn status(&mut self) -> Status {
        let (progress, path_cycles) = path::with(|path| (path.progress, path.cycles()));
        let (dropped, first_with_set_ms) =
            path::with(|path| (path.dropped, path.first_with_set_ms));
        let analysers = path::with(|path| path.analysers.each_ref().map(Analyser::state));
        let tilt = path::with(|path| path.queue.latest_values().map(quick_look::sums));
        let supply = self.supply.try_get();
        let calibrated_c = self.active().map(|active| active.temperature_c);
        let in_calibrated_range = supply
            .zip(calibrated_c)
            .is_some_and(|(now, then)| (now.temperature_c - then).abs() <= CALIBRATED_RANGE_K);
        Status {
            uptime_ms: Instant::now().as_millis(),
            rate_hz: progress.rate_hz,
            scans: progress.scans,
            block: progress.block,
            first_lost_scan: progress.first_lost,
            events: Events {
                blocks_dropped: dropped,
                ..tallies::all()
            },
            first_with_set_ms,
            path_cycles,
            analysers,
            scans_lost: progress.lost,
            crystal: self.origin.clock == Source::Crystal,
            supply: supply.map_or(f32::NAN, Reading::factor),
            supply_readings: supply.map_or(0, |reading| reading.readings),
            temperature_c: supply.map_or(f32::NAN, |reading| reading.temperature_c),
            in_calibrated_range,
            tilt_approximate_rad: tilt.map(quick_look::tilt),
            provisioned: self.exchange.provisioned.load(Ordering::Relaxed),
            resets: self.origin.resets,
            stack: stack::usage(),
            panic: self.origin.panic.clone(),
        }
    }
}

/// Sums of one channel at the drive frequency of one analyser.
fn sums(analyser: u8, channel: u8) -> Result<Outcome, Refusal> {
    check(analyser, channel)?;
    let (state, report) = path::with(|path| {
        let found = path.analysers.get(usize::from(analyser))?;
        Some((found.state(), found.report(channel.into())))
    })
    .ok_or(Refusal::Analyser { analyser })?;
    let (drive, first_scan, sums) = report.unwrap_or((NO_DRIVE, 0, ChannelSums::default()));
    Ok(Some(Response::Sums {
        state,
        drive,
        first_scan,
        sums,
    }))
}

fn check(analyser: u8, channel: u8) -> Result<(), Refusal> {
    if usize::from(analyser) >= ANALYSERS {
        return Err(Refusal::Analyser { analyser });
    }
    if usize::from(channel) >= CHANNELS {
        return Err(Refusal::Channel { channel });
    }
    Ok(())
}

fn check_capacity(content: StreamContent, rate_hz: u32, block: BlockSize) -> Result<(), Refusal> {
    let bits_per_s = telemetry::bits_per_second(content, rate_hz, block);
    if bits_per_s > telemetry::MAX_BITS_PER_S {
        return Err(Refusal::LinkCapacity {
            bits_per_s,
            limit: telemetry::MAX_BITS_PER_S,
        });
    }
    Ok(())
}

fn encode(answer: &Response, sequence: u16, out: &mut [u8]) -> Option<usize> {
    tallies::sendable(message::encode_response(answer, sequence, out))
}

/// Counts a frame that could not be taken apart.
fn count_damaged(error: &FrameError) {
    tallies::note(match error {
        FrameError::Encoding => |events| &mut events.frames_not_cobs,
        FrameError::Short { .. } | FrameError::Long { .. } => {
            |events| &mut events.frames_of_wrong_length
        }
        FrameError::Checksum => |events| &mut events.frames_of_wrong_checksum,
        FrameError::Kind { .. } => |events| &mut events.frames_of_wrong_kind,
    });
}
