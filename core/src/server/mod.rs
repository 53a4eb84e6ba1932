//! The server: what each request of the host gets for an answer, and the stream of blocks and poses.
//!
//! Firmware, host tests and the fake board of the host tool link the same server. What differs is the [`Board`] behind it.
//!
//! ```text
//!                   ┌── questions: answered at once from the latest values
//! frame ─▶ Server ──┼── analysers and stream: set at once, between two blocks
//!                   └── commands ─▶ Board::order ─▶ sampling, storage, harmonics ─▶ Server::hand_out ─▶ frame
//! sample path ─▶ queue ─▶ Stream ─▶ frame
//! ```
//!
//! While a command is open, the server refuses any other command as [`Refusal::Busy`]. So every answer belongs to the one
//! command that is open.
//!
//! | file | what |
//! |---|---|
//! | [`board`] | what the server needs of the board |
//! | [`stream`] | blocks and poses on their way to the host |
//! | [`solving`] | harmonics and motion from complete sums, in slices |
//! | [`tilt`] | the approximate tilt of the status |

pub mod board;
pub mod solving;
pub mod stream;
pub mod tilt;

pub use board::{Board, Command, HarmonicsCommand, Health, SamplingCommand};

use crate::channel::CHANNELS;
use crate::harmonics::{ANALYSERS, Analyser, ChannelSums};
use crate::sample_path::Progress;
use crate::sampling::BlockSize;
use crate::storage::StorageCommand;
use crate::wire::frame::{self, Closed};
use crate::wire::message::{self, Request, Response, StreamContent};
use crate::wire::status::{EventCount, Events, Status};
use crate::wire::{Drive, Frame, FrameError, Kind, PoseReport, Refusal, telemetry};

use self::board::sendable;
use self::stream::Stream;

/// Longest frame that a host sends: a chunk of a set with all that goes around it, rounded up.
pub const MAX_REQUEST_FRAME: usize = 256;
/// The coefficients of a set hold this far from the temperature of its calibration, K.
const CALIBRATED_RANGE_K: f32 = 10.0;

/// What is reported when nothing is estimated.
const NO_DRIVE: Drive = Drive {
    increment: 0,
    block: BlockSize::One,
    settle_blocks: 0,
    blocks: 0,
};

/// Answers the host in the name of a board.
pub struct Server<B> {
    /// The board.
    pub board: B,
    stream: Stream,
    /// The command that a task is carrying out: its sequence number, and where its refusal counts.
    open: Option<(u16, Pick)>,
}

/// Chooses a count.
type Pick = fn(&mut Events) -> &mut EventCount;

/// Answer to a request; `None` when it follows later.
type Outcome = Option<Response>;

impl<B: Board> Server<B> {
    /// A server that streams nothing yet.
    pub fn new(board: B) -> Self {
        Self {
            board,
            stream: Stream::default(),
            open: None,
        }
    }

    /// Takes in what the host sent; returns the length of the frame to send back, if there is one by now.
    pub fn take_in(&mut self, closed: Closed<'_>, out: &mut [u8]) -> Option<usize> {
        let Closed::Frame(bytes) = closed else {
            self.board
                .count(|events| &mut events.frames_of_wrong_length);
            return None;
        };
        let Frame {
            kind,
            sequence,
            payload,
        } = frame::decode(bytes)
            .inspect_err(|error| self.board.count(damaged(error)))
            .ok()?;
        match kind {
            Kind::Hello => {
                let encoded = self.board.greeting().encode(sequence, out);
                sendable(&mut self.board, encoded)
            }
            Kind::Request => {
                let outcome = match message::decode_request(payload) {
                    Some(request) => self.decide(request, sequence),
                    None => Err(Refusal::Malformed),
                };
                // By reference: the compiler moves an answer field by field.
                match &outcome {
                    Ok(None) => None,
                    Ok(Some(answer)) => self.encode(answer, sequence, out),
                    Err(refusal) => {
                        let answer = Response::Refused(*refusal);
                        self.count_refusal(&answer, |events| &mut events.requests_refused);
                        self.encode(&answer, sequence, out)
                    }
                }
            }
            Kind::Greeting | Kind::Response | Kind::Block | Kind::Pose => {
                self.board.count(|events| &mut events.frames_of_wrong_kind);
                None
            }
        }
    }

    /// Takes the answer to the open command; returns the length of the frame to send.
    pub fn hand_out(&mut self, answer: &Response, out: &mut [u8]) -> Option<usize> {
        let (sequence, refused) = self.open.take()?;
        self.count_refusal(answer, refused);
        self.encode(answer, sequence, out)
    }

    /// Takes the next piece of the queue; returns the length of the frame to send, see [`Stream::block`].
    pub fn pass_on(&mut self, out: &mut [u8]) -> Option<usize> {
        self.stream.block(&mut self.board, out)
    }

    /// Takes a pose; returns the length of the frame to send, when the host still wants poses.
    pub fn pass_on_pose(&mut self, report: &PoseReport, out: &mut [u8]) -> Option<usize> {
        self.stream.pose(&mut self.board, report, out)
    }

    /// What the host wants streamed.
    pub fn content(&self) -> StreamContent {
        self.stream.content
    }

    fn decide(&mut self, request: Request, sequence: u16) -> Result<Outcome, Refusal> {
        let command = match request {
            Request::Identity => return Ok(Some(Response::Identity(self.board.identity()))),
            Request::Status => return Ok(Some(Response::Status(self.status()))),
            Request::Stream(content) => return self.set_stream(content),
            Request::Drive { analyser, drive } => return self.set_drive(analyser, drive),
            Request::Sums { analyser, channel } => return self.sums(analyser, channel),
            Request::Rate(hz) => self.rate(hz)?,
            Request::Block(block) => self.block(block)?,
            Request::Harmonics { analyser, channel } => {
                check(analyser, channel)?;
                Command::Harmonics(HarmonicsCommand::Channel { analyser, channel })
            }
            Request::Motion { analyser } => {
                check(analyser, 0)?;
                Command::Harmonics(HarmonicsCommand::Motion { analyser })
            }
            Request::ActiveSet => Command::Storage(StorageCommand::ActiveSet),
            Request::ReadSet { offset } => Command::Storage(StorageCommand::Read(offset)),
            Request::History { age } => Command::Storage(StorageCommand::History(age)),
            Request::Log { counter } => Command::Storage(StorageCommand::Log(counter)),
            Request::LogProof { nonce } => Command::Storage(StorageCommand::LogProof(nonce)),
            Request::Challenge => Command::Storage(StorageCommand::Challenge),
            Request::Change { change, tag } => {
                Command::Storage(StorageCommand::Change(change, tag))
            }
            Request::UploadChunk { offset, bytes } => {
                Command::Storage(StorageCommand::Chunk(offset, bytes))
            }
            Request::UploadCommit => Command::Storage(StorageCommand::Commit),
            Request::UploadAbort => Command::Storage(StorageCommand::Abort),
            Request::Prove { challenge } => Command::Storage(StorageCommand::Prove(challenge)),
        };
        let refused: Pick = match &command {
            Command::Storage(command) if command.is_change() => {
                |events| &mut events.changes_refused
            }
            _ => |events| &mut events.requests_refused,
        };
        if self.open.is_some() || !self.board.order(command) {
            return Err(Refusal::Busy);
        }
        self.open = Some((sequence, refused));
        Ok(None)
    }

    /// Counts a refusal. A board that is busy has refused nothing: the host asks again.
    fn count_refusal(&mut self, answer: &Response, refused: Pick) {
        match answer {
            Response::Refused(Refusal::Busy) => {}
            Response::Refused(Refusal::WrongTag) => {
                self.board.count(|events| &mut events.wrong_tags);
            }
            Response::Refused(_) => self.board.count(refused),
            _ => {}
        }
    }

    fn progress(&mut self) -> Progress {
        self.board.path(|path| path.progress)
    }

    fn set_stream(&mut self, content: StreamContent) -> Result<Outcome, Refusal> {
        if (content.values || content.pose) && self.board.calibrated_at_c().is_none() {
            return Err(Refusal::NoSet);
        }
        let Progress { rate_hz, block, .. } = self.progress();
        self.check_capacity(content, rate_hz, block)?;
        self.stream.content = content;
        self.board.path(|path| path.set_stream(content));
        Ok(Some(Response::Done))
    }

    fn rate(&mut self, hz: u32) -> Result<Command, Refusal> {
        if !self.board.facts().rates_hz.contains(&hz) {
            return Err(Refusal::Rate { hz });
        }
        let block = self.progress().block;
        self.check_capacity(self.stream.content, hz, block)?;
        Ok(Command::Sampling(SamplingCommand::Rate(hz)))
    }

    fn block(&mut self, block: BlockSize) -> Result<Command, Refusal> {
        let rate_hz = self.progress().rate_hz;
        self.check_capacity(self.stream.content, rate_hz, block)?;
        Ok(Command::Sampling(SamplingCommand::Block(block)))
    }

    fn check_capacity(
        &self,
        content: StreamContent,
        rate_hz: u32,
        block: BlockSize,
    ) -> Result<(), Refusal> {
        let limit = self.board.facts().max_telemetry_bits_per_s();
        let bits_per_s = telemetry::bits_per_second(content, rate_hz, block, limit);
        if bits_per_s > limit {
            return Err(Refusal::LinkCapacity { bits_per_s, limit });
        }
        Ok(())
    }

    fn set_drive(&mut self, analyser: u8, drive: Drive) -> Result<Outcome, Refusal> {
        if !self.board.has_crystal() {
            return Err(Refusal::NoCrystal);
        }
        drive.check().map_err(Refusal::Drive)?;
        self.board.path(|path| {
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

    /// Sums of one channel at the drive frequency of one analyser, complete or not.
    fn sums(&mut self, analyser: u8, channel: u8) -> Result<Outcome, Refusal> {
        check(analyser, channel)?;
        let found = self.board.path(|path| {
            let found = path.analysers.get(usize::from(analyser))?;
            Some((found.state(), found.report(channel.into())))
        });
        let (state, report) = found.ok_or(Refusal::Analyser { analyser })?;
        let (drive, first_scan, sums) = report.unwrap_or((NO_DRIVE, 0, ChannelSums::default()));
        Ok(Some(Response::Sums {
            state,
            drive,
            first_scan,
            sums,
        }))
    }

    fn status(&mut self) -> Status {
        let (progress, path_cycles, dropped, first_with_set_ms) = self.board.path(|path| {
            let (cycles, first_ms) = (path.cycles(), path.first_with_set_ms);
            (path.progress, cycles, path.dropped, first_ms)
        });
        let analysers = self
            .board
            .path(|path| path.analysers.each_ref().map(Analyser::state));
        let tilt = self
            .board
            .path(|path| path.queue.latest_values().map(tilt::sums));
        let mut health = self.board.health();
        // Not with the rest of the struct behind `..`: the compiler copies that field by field.
        health.events.blocks_dropped = dropped;
        let supply = health.supply;
        let calibrated_c = self.board.calibrated_at_c();
        let in_calibrated_range = calibrated_c.is_some_and(|then| {
            supply.readings > 0 && (supply.temperature_c - then).abs() <= CALIBRATED_RANGE_K
        });
        Status {
            uptime_ms: health.uptime_ms,
            rate_hz: progress.rate_hz,
            scans: progress.scans(),
            block: progress.block,
            first_lost_scan: progress.first_lost,
            events: health.events,
            first_with_set_ms,
            path_cycles,
            analysers,
            scans_lost: progress.lost,
            crystal: self.board.has_crystal(),
            supply: supply.factor,
            supply_readings: supply.readings,
            temperature_c: supply.temperature_c,
            in_calibrated_range,
            tilt_approximate_rad: tilt.and_then(tilt::tilt),
            provisioned: health.provisioned,
            resets: health.resets,
            stack: health.stack,
            panic: health.panic,
            option_bytes: health.option_bytes,
            supply_is_old: supply.is_old,
            key_damaged: health.key_damaged,
            log_used: health.log_used,
        }
    }

    fn encode(&mut self, answer: &Response, sequence: u16, out: &mut [u8]) -> Option<usize> {
        let encoded = message::encode_response(answer, sequence, out);
        sendable(&mut self.board, encoded)
    }
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

/// Which count a frame goes to that does not decode.
fn damaged(error: &FrameError) -> fn(&mut Events) -> &mut EventCount {
    match error {
        FrameError::Encoding => |events| &mut events.frames_not_cobs,
        FrameError::Short { .. } | FrameError::Long { .. } => {
            |events| &mut events.frames_of_wrong_length
        }
        FrameError::Checksum => |events| &mut events.frames_of_wrong_checksum,
        FrameError::Kind { .. } => |events| &mut events.frames_of_wrong_kind,
    }
}
