//! How answers find their questions, beside the blocks of samples that come by themselves.
//!
//! Every request carries a number that its answer repeats, so an answer that comes too late is not taken for another
//! one's. A request is asked again when its answer is lost: all but changes (see [`super::change`]) and the commit of an
//! upload (see [`super::upload`]) may safely be carried out twice.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use hexsense_core::wire::frame::{self, Closed, Deframer};
use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::message::{decode_response, encode_request};
use hexsense_core::wire::telemetry::{self, Block};
use hexsense_core::wire::{Kind, MAX_FRAME, PoseReport, Refusal, Request, Response, VERSION, pose};

use super::missing::Missing;
use super::{LinkError, ProtocolError, Transport};

/// How often a request is asked.
pub const ATTEMPTS: u32 = 3;
/// How long an answer may take.
const ANSWER: Duration = Duration::from_millis(1_000);
/// Pause before a busy board is asked again.
const BUSY_PAUSE: Duration = Duration::from_millis(20);
/// Blocks that wait at most; older ones are dropped when nobody takes them.
const MAX_BLOCKS: usize = 4_096;
/// Poses that wait at most, older ones being dropped: more than four minutes of them.
const MAX_POSES: usize = 16_384;

/// A transport with everything that has come through it and was not taken yet.
pub struct Conversation {
    transport: Box<dyn Transport>,
    deframer: Box<Deframer<MAX_FRAME>>,
    received: Vec<u8>,
    sequence: u16,
    greeting: Option<Greeting>,
    answers: VecDeque<(u16, Option<Response>)>,
    blocks: VecDeque<Block>,
    poses: VecDeque<PoseReport>,
    contact: Contact,
    missing: Missing,
}

/// When and where the board was heard last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contact {
    /// When bytes came last, by the host's clock.
    pub at: Instant,
    /// Counter of the scan that was due next.
    pub next_scan: u64,
}

impl Conversation {
    /// A conversation in which nothing has been said yet.
    pub fn new(transport: Box<dyn Transport>) -> Self {
        Self {
            transport,
            deframer: Box::default(),
            received: Vec::new(),
            sequence: 0,
            greeting: None,
            answers: VecDeque::new(),
            blocks: VecDeque::new(),
            poses: VecDeque::new(),
            contact: Contact {
                at: Instant::now(),
                next_scan: 0,
            },
            missing: Missing::default(),
        }
    }

    /// Telemetry frames that did not arrive.
    pub fn frames_missing(&self) -> u64 {
        self.missing.frames()
    }

    /// The port as it was asked for.
    pub fn port(&self) -> &str {
        self.transport.port()
    }

    /// Whether the board's clock goes on while nobody waits for it.
    pub fn is_real_time(&self) -> bool {
        self.transport.is_real_time()
    }

    /// When and where the board was heard last.
    pub fn contact(&self) -> Contact {
        self.contact
    }

    /// Makes sure that a board of our version is at the other end, and returns what it says of itself.
    pub fn greet(&mut self) -> Result<Greeting, LinkError> {
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
                    Some(greeting) if greeting.wire == VERSION => return Ok(greeting),
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

    /// Time by the clock of the transport.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.transport.now()
    }

    /// The next block of samples, waiting at most for `timeout`.
    ///
    /// # Errors
    /// [`ProtocolError::NoSamples`] when none comes, and what the line does.
    pub fn block(&mut self, timeout: Duration) -> Result<Block, LinkError> {
        self.wait_for(timeout, |waiting| waiting.blocks.pop_front())
    }

    /// The next pose, waiting at most for `timeout`.
    ///
    /// # Errors
    /// [`ProtocolError::NoSamples`] when none comes, and what the line does.
    pub fn pose(&mut self, timeout: Duration) -> Result<PoseReport, LinkError> {
        self.wait_for(timeout, |waiting| waiting.poses.pop_front())
    }

    fn wait_for<T>(
        &mut self,
        timeout: Duration,
        take: impl Fn(&mut Self) -> Option<T>,
    ) -> Result<T, LinkError> {
        let start = self.transport.now();
        let deadline = start + timeout;
        loop {
            if let Some(taken) = take(self) {
                return Ok(taken);
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

    /// Forgets the blocks and poses that wait.
    pub fn forget_blocks(&mut self) {
        self.blocks.clear();
        self.poses.clear();
    }

    /// The poses that wait.
    pub fn take_poses(&mut self) -> Vec<PoseReport> {
        self.poses.drain(..).collect()
    }

    /// Asks for something that is answered by [`Response::Done`].
    pub fn command(&mut self, request: &Request) -> Result<(), LinkError> {
        match self.ask(request)? {
            Response::Done => Ok(()),
            _ => Err(answer_error(request)),
        }
    }

    /// Asks up to [`ATTEMPTS`] times.
    pub fn ask(&mut self, request: &Request) -> Result<Response, LinkError> {
        let start = self.transport.now();
        for _ in 0..ATTEMPTS {
            if let Some(response) = self.ask_once(request, ANSWER)? {
                return Ok(response);
            }
        }
        Err(self.silent(request, ATTEMPTS, start).into())
    }

    /// Asks for something that the board may have to work on for so long, being busy meanwhile.
    pub fn ask_patiently(
        &mut self,
        request: &Request,
        timeout: Duration,
    ) -> Result<Response, LinkError> {
        let start = self.transport.now();
        let answer = self.ask_once(request, timeout)?;
        answer.ok_or_else(|| self.silent(request, 1, start).into())
    }

    /// Asks once and waits for `timeout`; `None` when no answer came.
    pub fn ask_once(
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

    pub fn silent(&self, request: &Request, attempts: u32, start: Duration) -> ProtocolError {
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
        if !self.received.is_empty() {
            self.contact.at = Instant::now();
        }
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
                Some((Kind::Block, frame)) => {
                    self.missing.take(frame.sequence);
                    let block = telemetry::decode(frame.payload);
                    if let Some(Block { header, .. }) = &block {
                        self.contact.next_scan = header.first_scan + u64::from(header.scans);
                    }
                    self.blocks.extend(block);
                }
                Some((Kind::Pose, frame)) => {
                    self.missing.take(frame.sequence);
                    self.poses.extend(pose::decode(frame.payload));
                }
                // What is damaged is asked for again, or is a gap in the scan counters.
                Some((Kind::Hello | Kind::Request, _)) | None => {}
            }
        }
        let excess = self.blocks.len().saturating_sub(MAX_BLOCKS);
        self.blocks.drain(..excess);
        let excess = self.poses.len().saturating_sub(MAX_POSES);
        self.poses.drain(..excess);
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

/// The answer to `request` is not one.
pub fn answer_error(request: &Request) -> LinkError {
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
        Request::Block(_) => "block",
        Request::Drive { .. } => "drive frequency",
        Request::Sums { .. } => "harmonic sums",
        Request::ActiveSet => "active set",
        Request::ReadSet { .. } => "bytes of the set",
        Request::History { .. } => "history of sets",
        Request::Log { .. } => "log of changes",
        Request::Challenge => "challenge",
        Request::Change { .. } => "change",
        Request::UploadChunk { .. } => "piece of an upload",
        Request::UploadCommit => "commit of an upload",
        Request::UploadAbort => "end of an upload",
        Request::Harmonics { .. } => "harmonics",
        Request::Motion { .. } => "motion",
    }
}
