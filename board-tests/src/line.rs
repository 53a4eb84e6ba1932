//! The serial line to a board, on which anything may be sent.
//!
//! Frames come from [`FrameLine`], which the host tool's client uses too. Unlike that client this end repeats nothing, counts
//! all times by the board's clock and keeps every block, so that a test sees exactly what the board did.

use std::collections::VecDeque;
use std::time::Duration;

use anyhow::bail;
use hexsense_client::TransportError;
use hexsense_client::line::{Content, FrameLine};
use hexsense_core::wire::telemetry::Block;
use hexsense_core::wire::{
    Identity, PoseReport, Refusal, Request, Response, Status, StreamContent,
};

/// Every answer comes within this time.
const ANSWER: Duration = Duration::from_millis(1_000);
/// Pause before a busy board is asked again.
const PAUSE: Duration = Duration::from_millis(5);

/// The host's end of the line.
pub struct Line {
    frames: FrameLine,
    answers: VecDeque<(u16, Option<Response>)>,
    /// Blocks that arrived, oldest first.
    pub blocks: VecDeque<ArrivedBlock>,
    /// Poses that arrived, oldest first.
    pub poses: VecDeque<PoseReport>,
}

/// A block of scans and the frame that it arrived in.
#[derive(Debug, Clone)]
pub struct ArrivedBlock {
    /// When the last bit of the frame had left the board, since power-on.
    pub at: Duration,
    /// Bytes of the frame on the line.
    pub bytes: usize,
    /// Number of the frame.
    pub sequence: u16,
    /// The block.
    pub block: Block,
}

impl Line {
    /// Connects to a virtual board; its time stands still until something is asked of this line.
    pub fn open(address: &str) -> anyhow::Result<Self> {
        Ok(Self {
            frames: FrameLine::open(address)?,
            answers: VecDeque::new(),
            blocks: VecDeque::new(),
            poses: VecDeque::new(),
        })
    }

    /// Time since power-on.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.frames.now()
    }

    /// Frames that arrived damaged.
    #[must_use]
    pub fn damaged(&self) -> u64 {
        self.frames.damaged()
    }

    /// Lets the board run until this time since power-on.
    pub fn run_until(&mut self, until: Duration) -> anyhow::Result<()> {
        while self.now() < until {
            self.receive(until - self.now())?;
        }
        Ok(())
    }

    /// Lets the board run for so long.
    pub fn run(&mut self, duration: Duration) -> anyhow::Result<()> {
        self.run_until(self.now() + duration)
    }

    /// Lets the board run for so many seconds.
    pub fn run_s(&mut self, seconds: f64) -> anyhow::Result<()> {
        self.run(Duration::from_secs_f64(seconds))
    }

    /// Sends bytes as they are; they leave when the board runs on.
    pub fn send_bytes(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        Ok(self.frames.send_bytes(bytes)?)
    }

    /// Sends a request and returns its number.
    pub fn send(&mut self, request: &Request) -> anyhow::Result<u16> {
        Ok(self.frames.send(request)?)
    }

    /// Asks, and waits for the answer. A board that is busy is asked again.
    pub fn ask(&mut self, request: &Request) -> anyhow::Result<Response> {
        let deadline = self.now() + ANSWER;
        loop {
            match self.ask_until(request, deadline)? {
                Response::Refused(Refusal::Busy) if self.now() < deadline => self.run(PAUSE)?,
                answer => return Ok(answer),
            }
        }
    }

    /// Asks, and waits for the answer, which may be that the board is busy.
    pub fn ask_once(&mut self, request: &Request) -> anyhow::Result<Response> {
        self.ask_until(request, self.now() + ANSWER)
    }

    fn ask_until(&mut self, request: &Request, deadline: Duration) -> anyhow::Result<Response> {
        let sequence = self.send(request)?;
        loop {
            match self.answer_to(sequence) {
                Some(answer) => return Ok(answer),
                None if self.now() < deadline => self.receive(deadline - self.now())?,
                None => bail!("no answer to {request:?} at {:?}", self.now()),
            }
        }
    }

    /// Asks for something that is simply done.
    pub fn order(&mut self, request: &Request) -> anyhow::Result<()> {
        match self.ask(request)? {
            Response::Done => Ok(()),
            other => bail!("{request:?} was answered by {other:?}"),
        }
    }

    /// How the board is.
    pub fn status(&mut self) -> anyhow::Result<Status> {
        match self.ask(&Request::Status)? {
            Response::Status(status) => Ok(status),
            other => bail!("no status but {other:?}"),
        }
    }

    /// How the board is, if it answers within this time: it may be in a reset.
    pub fn status_within(&mut self, time: Duration) -> anyhow::Result<Option<Status>> {
        let sequence = self.send(&Request::Status)?;
        self.run(time)?;
        Ok(match self.answer_to(sequence) {
            Some(Response::Status(status)) => Some(status),
            _ => None,
        })
    }

    /// Which board it is.
    pub fn identity(&mut self) -> anyhow::Result<Identity> {
        match self.ask(&Request::Identity)? {
            Response::Identity(identity) => Ok(identity),
            other => bail!("no identity but {other:?}"),
        }
    }

    /// Streams counts, and values and poses where they are wanted.
    pub fn stream(&mut self, values: bool, pose: bool) -> anyhow::Result<()> {
        self.order(&Request::Stream(StreamContent {
            counts: true,
            values,
            pose,
        }))
    }

    /// Streams the counts of all channels at 4 kHz; blocks that came before are forgotten.
    pub fn stream_everything(&mut self) -> anyhow::Result<()> {
        self.order(&Request::Rate(4_000))?;
        self.blocks.clear();
        self.stream(false, false)
    }

    /// The answer with this number, if it has come; earlier ones are forgotten.
    pub fn answer_to(&mut self, sequence: u16) -> Option<Response> {
        while let Some((number, answer)) = self.answers.pop_front() {
            if number == sequence {
                return answer;
            }
        }
        None
    }

    /// Forgets the answers that came.
    pub fn forget_answers(&mut self) {
        self.answers.clear();
    }

    fn receive(&mut self, timeout: Duration) -> anyhow::Result<()> {
        for frame in self.frames.receive(timeout)? {
            match frame.content {
                Content::Response(answer) => self.answers.push_back((frame.sequence, answer)),
                Content::Block(block) => self.blocks.push_back(ArrivedBlock {
                    at: frame.at,
                    bytes: frame.bytes,
                    sequence: frame.sequence,
                    block,
                }),
                Content::Pose(pose) => self.poses.push_back(pose),
                Content::Greeting(_) => {}
            }
        }
        Ok(())
    }
}

/// Whether the board has lost its power: nothing is at the other end of the line any more. When that happens before its first
/// byte, the client takes the port for one that is in use; no other process uses a board of these tests.
#[must_use]
pub fn is_gone(error: &anyhow::Error) -> bool {
    use TransportError::{Closed, Failed, InUse};
    matches!(
        error.downcast_ref(),
        Some(Closed { .. } | Failed { .. } | InUse { .. })
    )
}
