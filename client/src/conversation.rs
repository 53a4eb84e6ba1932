//! Requests and their answers, beside the blocks of samples that come by themselves.
//!
//! Every request carries a number that its answer repeats, so a late answer is not taken for that of another request. A
//! request is sent again when its answer is lost. Changes (see [`super::change`]) and the commit of an upload (see
//! [`super::upload`]) must not be carried out twice and are sent once.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::telemetry::Block;
use hexsense_core::wire::{PoseReport, Refusal, Request, Response, VERSION};

use super::error::{LinkError, ProtocolError};
use super::line::{Content, FrameLine};
use super::transport::Transport;

/// How often a request is asked.
pub const ATTEMPTS: u32 = 3;
/// How long an answer may take.
const ANSWER: Duration = Duration::from_millis(1_000);
/// Pause before a busy board is asked again.
const BUSY_PAUSE: Duration = Duration::from_millis(20);
/// Blocks that wait at most; the oldest are dropped when no caller takes them.
const MAX_BLOCKS: usize = 4_096;
/// Poses that wait at most, older ones being dropped: more than four minutes of them.
const MAX_POSES: usize = 16_384;

/// A line with everything that has come through it and was not taken yet.
pub struct Conversation {
    line: FrameLine,
    greeting: Option<Greeting>,
    answers: VecDeque<(u16, Option<Response>)>,
    blocks: VecDeque<Block>,
    poses: VecDeque<PoseReport>,
    contact: Contact,
}

/// When and where the board was heard last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contact {
    /// When a frame came last, by the host's clock.
    pub at: Instant,
    /// Counter of the scan that was due next.
    pub next_scan: u64,
}

impl Conversation {
    /// A conversation in which nothing has been said yet.
    pub fn new(transport: Box<dyn Transport>) -> Self {
        Self {
            line: FrameLine::new(transport),
            greeting: None,
            answers: VecDeque::new(),
            blocks: VecDeque::new(),
            poses: VecDeque::new(),
            contact: Contact {
                at: Instant::now(),
                next_scan: 0,
            },
        }
    }

    /// Telemetry frames that did not arrive.
    pub fn frames_missing(&self) -> u64 {
        self.line.missing()
    }

    /// The port as it was asked for.
    pub fn port(&self) -> &str {
        self.line.port()
    }

    /// Whether the board's clock goes on while no host waits for it.
    pub fn is_real_time(&self) -> bool {
        self.line.is_real_time()
    }

    /// When and where the board was heard last.
    pub fn contact(&self) -> Contact {
        self.contact
    }

    /// Makes sure that a board of our version is at the other end, and returns what it says of itself.
    pub fn greet(&mut self) -> Result<Greeting, LinkError> {
        let start = self.line.now();
        for _ in 0..ATTEMPTS {
            self.line.send_hello()?;
            let deadline = self.line.now() + ANSWER;
            while self.line.now() < deadline {
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
            port: self.line.port().to_owned(),
            waited_ms: self.waited_ms(start),
        }
        .into())
    }

    /// Time by the clock of the transport.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.line.now()
    }

    /// The next block of samples, waiting at most for `timeout`.
    ///
    /// # Errors
    /// [`ProtocolError::NoSamples`] when nothing comes in time, and the errors of the line.
    pub fn block(&mut self, timeout: Duration) -> Result<Block, LinkError> {
        self.wait_for(timeout, |waiting| waiting.blocks.pop_front())
    }

    /// The next pose, waiting at most for `timeout`.
    ///
    /// # Errors
    /// [`ProtocolError::NoSamples`] when nothing comes in time, and the errors of the line.
    pub fn pose(&mut self, timeout: Duration) -> Result<PoseReport, LinkError> {
        self.wait_for(timeout, |waiting| waiting.poses.pop_front())
    }

    fn wait_for<T>(
        &mut self,
        timeout: Duration,
        take: impl Fn(&mut Self) -> Option<T>,
    ) -> Result<T, LinkError> {
        let start = self.line.now();
        let deadline = start + timeout;
        loop {
            if let Some(taken) = take(self) {
                return Ok(taken);
            }
            if self.line.now() >= deadline {
                let port = self.line.port().to_owned();
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
        let start = self.line.now();
        for _ in 0..ATTEMPTS {
            if let Some(response) = self.ask_once(request, ANSWER)? {
                return Ok(response);
            }
        }
        Err(self.silent(request, ATTEMPTS, start).into())
    }

    /// Asks for something that takes the board up to `timeout`; it is busy for that time.
    pub fn ask_patiently(
        &mut self,
        request: &Request,
        timeout: Duration,
    ) -> Result<Response, LinkError> {
        let start = self.line.now();
        let answer = self.ask_once(request, timeout)?;
        answer.ok_or_else(|| self.silent(request, 1, start).into())
    }

    /// Asks once and waits for `timeout`; `None` when no answer came.
    pub fn ask_once(
        &mut self,
        request: &Request,
        timeout: Duration,
    ) -> Result<Option<Response>, LinkError> {
        let deadline = self.line.now() + timeout;
        let mut sequence = self.line.send(request)?;
        while self.line.now() < deadline {
            match self.answer_to(sequence, request)? {
                Some(Response::Refused(Refusal::Busy)) => {
                    let resume = self.line.now() + BUSY_PAUSE;
                    while self.line.now() < resume {
                        self.receive(resume)?;
                    }
                    sequence = self.line.send(request)?;
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
            port: self.line.port().to_owned(),
            request: name(request),
            attempts,
            waited_ms: self.waited_ms(start),
        }
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

    /// Waits for bytes until `deadline` at most and sorts the frames that end in them.
    fn receive(&mut self, deadline: Duration) -> Result<(), LinkError> {
        let timeout = deadline.saturating_sub(self.line.now());
        for arrived in self.line.receive(timeout)? {
            self.contact.at = Instant::now();
            match arrived.content {
                Content::Greeting(greeting) => self.greeting = Some(greeting),
                Content::Response(response) => {
                    self.answers.push_back((arrived.sequence, response));
                }
                Content::Block(block) => {
                    self.contact.next_scan =
                        block.header.first_scan + u64::from(block.header.scans);
                    self.blocks.push_back(block);
                }
                Content::Pose(pose) => self.poses.push_back(pose),
            }
        }
        let excess = self.blocks.len().saturating_sub(MAX_BLOCKS);
        self.blocks.drain(..excess);
        let excess = self.poses.len().saturating_sub(MAX_POSES);
        self.poses.drain(..excess);
        Ok(())
    }

    fn waited_ms(&self, start: Duration) -> u64 {
        (self.line.now() - start).as_millis() as u64
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
        Request::LogProof { .. } => "log proof",
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
