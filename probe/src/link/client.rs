//! Questions and answers with the board, and the blocks of samples that come beside them.
//!
//! Every request carries a number that its answer repeats, so an answer that comes too late is not taken for another
//! one's. A request is asked again when its answer is lost: all but the commit of an upload (see [`super::upload`])
//! may safely be carried out twice.

use std::collections::VecDeque;
use std::time::Duration;

use hexsense::harmonics::ChannelSums;
use hexsense::store::MAX_ENCODED;
use hexsense::wire::frame::{self, Closed, Deframer};
use hexsense::wire::hello::Greeting;
use hexsense::wire::message::{ActiveSet, decode_response, encode_request};
use hexsense::wire::telemetry::{self, Block};
use hexsense::wire::{
    Drive, HarmonicState, Identity, Kind, MAX_FRAME, Refusal, Request, Response, Status,
    StreamContent, VERSION,
};

use super::{LinkError, ProtocolError, Transport, transport};

/// How often a request is asked.
pub(super) const ATTEMPTS: u32 = 3;
/// How long an answer may take.
pub(super) const ANSWER: Duration = Duration::from_millis(1_000);
/// Pause before a busy board is asked again.
const BUSY_PAUSE: Duration = Duration::from_millis(20);
/// Blocks that wait at most; older ones are dropped when nobody takes them.
const MOST_BLOCKS: usize = 4_096;

/// A board that has greeted and speaks our version.
pub struct Client {
    transport: Box<dyn Transport>,
    deframer: Box<Deframer<MAX_FRAME>>,
    received: Vec<u8>,
    sequence: u16,
    greeting: Option<Greeting>,
    answers: VecDeque<(u16, Option<Response>)>,
    blocks: VecDeque<Block>,
    damaged: u64,
}

/// Harmonic sums of one channel with what they belong to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HarmonicReport {
    /// How far the sums are.
    pub state: HarmonicState,
    /// What is being estimated.
    pub drive: Drive,
    /// Scan counter of the first scan in the sums.
    pub first_scan: u64,
    /// The sums.
    pub sums: ChannelSums,
}

impl Client {
    /// Opens `port` and makes sure that a board of our version is behind it; it does not stream afterwards.
    ///
    /// # Errors
    /// [`LinkError`], among them another wire version.
    pub fn open(port: &str) -> Result<Self, LinkError> {
        Self::connect(transport::open(port)?)
    }

    /// The same on an open transport.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn connect(transport: Box<dyn Transport>) -> Result<Self, LinkError> {
        let mut client = Self {
            transport,
            deframer: Box::default(),
            received: Vec::new(),
            sequence: 0,
            greeting: None,
            answers: VecDeque::new(),
            blocks: VecDeque::new(),
            damaged: 0,
        };
        client.greet()?;
        client.stream(StreamContent::default())?;
        client.blocks.clear();
        Ok(client)
    }

    fn greet(&mut self) -> Result<(), LinkError> {
        let start = self.transport.now();
        for _ in 0..ATTEMPTS {
            let mut bytes = [0; MAX_FRAME];
            let sequence = self.next_sequence();
            let length = frame::encode(Kind::Hello, sequence, &mut bytes, |_| Some(0)).unwrap_or(0);
            // The zero closes whatever half a frame the board may still hold.
            self.transport.write(&[0])?;
            self.transport.write(&bytes[..length])?;
            let deadline = self.transport.now() + ANSWER;
            while self.transport.now() < deadline {
                self.receive(deadline)?;
                match self.greeting {
                    Some(greeting) if greeting.wire == VERSION => return Ok(()),
                    Some(Greeting {
                        wire: board,
                        firmware,
                    }) => {
                        return Err(ProtocolError::Version { board, firmware }.into());
                    }
                    None => {}
                }
            }
        }
        Err(ProtocolError::NoGreeting {
            port: self.transport.port().to_owned(),
            waited_ms: self.waited_ms(start),
        }
        .into())
    }

    /// Version of the board's firmware: major, minor, patch.
    #[must_use]
    pub fn firmware(&self) -> [u8; 3] {
        self.greeting.map_or([0; 3], |greeting| greeting.firmware)
    }

    /// The port as it was asked for.
    #[must_use]
    pub fn port(&self) -> &str {
        self.transport.port()
    }

    /// Time by the clock of the transport.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.transport.now()
    }

    /// Frames that arrived damaged, so far.
    #[must_use]
    pub fn damaged(&self) -> u64 {
        self.damaged
    }

    /// Who the board is.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn identity(&mut self) -> Result<Identity, LinkError> {
        match self.ask(&Request::Identity)? {
            Response::Identity(identity) => Ok(identity),
            _ => Err(answer_error(&Request::Identity)),
        }
    }

    /// How the board is.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn status(&mut self) -> Result<Status, LinkError> {
        match self.ask(&Request::Status)? {
            Response::Status(status) => Ok(status),
            _ => Err(answer_error(&Request::Status)),
        }
    }

    /// Starts, changes or stops the stream of blocks.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn stream(&mut self, content: StreamContent) -> Result<(), LinkError> {
        self.command(&Request::Stream(content))
    }

    /// Sets the scan rate, Hz.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn rate(&mut self, hz: u32) -> Result<(), LinkError> {
        self.command(&Request::Rate(hz))
    }

    /// Starts harmonic sums from the next block on.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn drive(&mut self, drive: Drive) -> Result<(), LinkError> {
        self.command(&Request::Drive(drive))
    }

    /// Harmonic sums of one channel, 0 to 14.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn harmonics(&mut self, channel: u8) -> Result<HarmonicReport, LinkError> {
        let request = Request::Harmonics { channel };
        match self.ask(&request)? {
            Response::Harmonics {
                state,
                drive,
                first_scan,
                sums,
            } => Ok(HarmonicReport {
                state,
                drive,
                first_scan,
                sums,
            }),
            _ => Err(answer_error(&request)),
        }
    }

    /// Which set is active; `None` without one.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn active_set(&mut self) -> Result<Option<ActiveSet>, LinkError> {
        match self.ask(&Request::ActiveSet)? {
            Response::ActiveSet(active) => Ok(active),
            _ => Err(answer_error(&Request::ActiveSet)),
        }
    }

    /// The active set and its encoded bytes; `None` without one.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn read_set(&mut self) -> Result<Option<(ActiveSet, Vec<u8>)>, LinkError> {
        let Some(active) = self.active_set()? else {
            return Ok(None);
        };
        let mut encoded = Vec::with_capacity(MAX_ENCODED);
        while encoded.len() < usize::from(active.length) {
            let request = Request::ReadSet {
                offset: encoded.len() as u16,
            };
            match self.ask(&request)? {
                Response::SetBytes { offset, bytes }
                    if usize::from(offset) == encoded.len() && !bytes.is_empty() =>
                {
                    encoded.extend_from_slice(&bytes);
                }
                _ => return Err(answer_error(&request)),
            }
        }
        Ok(Some((active, encoded)))
    }

    /// The next block of samples, waiting at most for `timeout`.
    ///
    /// # Errors
    /// [`ProtocolError::NoSamples`] when none comes, and what the line does.
    pub fn block(&mut self, timeout: Duration) -> Result<Block, LinkError> {
        let start = self.transport.now();
        let deadline = start + timeout;
        loop {
            if let Some(block) = self.blocks.pop_front() {
                return Ok(block);
            }
            if self.transport.now() >= deadline {
                let port = self.transport.port().to_owned();
                return Err(ProtocolError::NoSamples {
                    port,
                    waited_ms: self.waited_ms(start),
                }
                .into());
            }
            self.receive(deadline)?;
        }
    }

    /// Forgets the blocks that wait.
    pub fn forget_blocks(&mut self) {
        self.blocks.clear();
    }

    /// Asks for something that is answered by [`Response::Done`].
    pub(super) fn command(&mut self, request: &Request) -> Result<(), LinkError> {
        match self.ask(request)? {
            Response::Done => Ok(()),
            _ => Err(answer_error(request)),
        }
    }

    /// Asks up to [`ATTEMPTS`] times.
    pub(super) fn ask(&mut self, request: &Request) -> Result<Response, LinkError> {
        let start = self.transport.now();
        for _ in 0..ATTEMPTS {
            if let Some(response) = self.ask_once(request, ANSWER)? {
                return Ok(response);
            }
        }
        Err(self.silent(request, ATTEMPTS, start).into())
    }

    /// Asks once and waits for `timeout`; `None` when no answer came.
    pub(super) fn ask_once(
        &mut self,
        request: &Request,
        timeout: Duration,
    ) -> Result<Option<Response>, LinkError> {
        let deadline = self.transport.now() + timeout;
        let mut sequence = self.send(request)?;
        while self.transport.now() < deadline {
            match self.answer_to(sequence, request)? {
                Some(Response::Refused(Refusal::Busy)) => {
                    let resume = self.transport.now() + BUSY_PAUSE;
                    while self.transport.now() < resume {
                        self.receive(resume)?;
                    }
                    sequence = self.send(request)?;
                }
                Some(Response::Refused(refusal)) => return Err(refusal.into()),
                Some(response) => return Ok(Some(response)),
                None => self.receive(deadline)?,
            }
        }
        Ok(None)
    }

    pub(super) fn silent(
        &self,
        request: &Request,
        attempts: u32,
        start: Duration,
    ) -> ProtocolError {
        ProtocolError::Silent {
            port: self.transport.port().to_owned(),
            request: name(request),
            attempts,
            waited_ms: self.waited_ms(start),
        }
    }

    fn send(&mut self, request: &Request) -> Result<u16, LinkError> {
        let sequence = self.next_sequence();
        let mut bytes = [0; MAX_FRAME];
        // Every request is far shorter than the longest frame.
        let length = encode_request(request, sequence, &mut bytes).unwrap_or(0);
        self.transport.write(&bytes[..length])?;
        Ok(sequence)
    }

    /// The answer with this number, if it has come; others are forgotten.
    fn answer_to(
        &mut self,
        sequence: u16,
        request: &Request,
    ) -> Result<Option<Response>, LinkError> {
        while let Some((number, response)) = self.answers.pop_front() {
            if number == sequence {
                return response.map(Some).ok_or_else(|| answer_error(request));
            }
        }
        Ok(None)
    }

    /// Waits for bytes until `deadline` at most and sorts the frames in them.
    fn receive(&mut self, deadline: Duration) -> Result<(), LinkError> {
        let timeout = deadline.saturating_sub(self.transport.now());
        self.received.clear();
        self.transport.read(&mut self.received, timeout)?;
        for byte in &self.received {
            let frame = match self.deframer.push(*byte) {
                None => continue,
                Some(Closed::Overlong) => None,
                Some(Closed::Frame(bytes)) => frame::decode(bytes).ok(),
            };
            match frame.map(|frame| (frame.kind, frame)) {
                Some((Kind::Greeting, frame)) => {
                    self.greeting = Greeting::decode(frame.payload).or(self.greeting);
                }
                Some((Kind::Response, frame)) => {
                    self.answers
                        .push_back((frame.sequence, decode_response(frame.payload)));
                }
                Some((Kind::Block, frame)) => match telemetry::decode(frame.payload) {
                    Some(block) => self.blocks.push_back(block),
                    None => self.damaged += 1,
                },
                Some((Kind::Hello | Kind::Request, _)) | None => self.damaged += 1,
            }
        }
        let excess = self.blocks.len().saturating_sub(MOST_BLOCKS);
        self.blocks.drain(..excess);
        Ok(())
    }

    fn next_sequence(&mut self) -> u16 {
        self.sequence = self.sequence.wrapping_add(1);
        self.sequence
    }

    fn waited_ms(&self, start: Duration) -> u64 {
        (self.transport.now() - start).as_millis() as u64
    }
}

pub(super) fn answer_error(request: &Request) -> LinkError {
    ProtocolError::Answer {
        request: name(request),
    }
    .into()
}

/// What a request is called in messages.
fn name(request: &Request) -> &'static str {
    match request {
        Request::Identity => "identity",
        Request::Status => "status",
        Request::Stream(_) => "stream",
        Request::Rate(_) => "scan rate",
        Request::Drive(_) => "drive frequency",
        Request::Harmonics { .. } => "harmonic sums",
        Request::ActiveSet => "active set",
        Request::ReadSet { .. } => "bytes of the set",
        Request::UploadBegin { .. } => "begin of an upload",
        Request::UploadChunk { .. } => "piece of an upload",
        Request::UploadCommit => "commit of an upload",
        Request::UploadAbort => "end of an upload",
    }
}
