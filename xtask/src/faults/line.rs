//! The serial line to a board, on which anything may be sent.
//!
//! Unlike the host tool's client this end repeats nothing, times nothing out but by the board's clock, and keeps every
//! block that comes, so that a campaign sees exactly what the board did.

use std::collections::VecDeque;
use std::time::Duration;

use anyhow::bail;
use hexsense_client::{Transport, TransportError, port};
use hexsense_core::wire::frame::{self, Closed, Deframer};
use hexsense_core::wire::message::{decode_response, encode_request};
use hexsense_core::wire::telemetry::{self, Block};
use hexsense_core::wire::{Identity, Kind, MAX_FRAME, Request, Response, Status, StreamContent};

/// Every answer comes within this time.
const ANSWER: Duration = Duration::from_millis(1_000);
/// So long a busy board is left alone.
const PAUSE: Duration = Duration::from_millis(5);

/// The host's end of the line.
pub struct Line {
    transport: Box<dyn Transport>,
    deframer: Box<Deframer<MAX_FRAME>>,
    sequence: u16,
    answers: VecDeque<(u16, Option<Response>)>,
    /// Blocks that came, oldest first, with the numbers of their frames.
    pub blocks: VecDeque<(u16, Block)>,
    /// Frames that came damaged.
    pub damaged: u32,
}

impl Line {
    /// Connects to a virtual board; its time stands still until something is asked of this line.
    pub fn open(address: &str) -> anyhow::Result<Self> {
        Ok(Self {
            transport: port::open(address)?,
            deframer: Box::default(),
            sequence: 0,
            answers: VecDeque::new(),
            blocks: VecDeque::new(),
            damaged: 0,
        })
    }

    /// Time since power-on.
    pub fn now(&self) -> Duration {
        self.transport.now()
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

    /// Sends bytes, whatever they are; they leave when the board runs on.
    pub fn send_bytes(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        Ok(self.transport.write(bytes)?)
    }

    /// Sends a request and returns its number. A zero before it closes whatever was left open.
    pub fn send(&mut self, request: &Request) -> anyhow::Result<u16> {
        self.sequence = self.sequence.wrapping_add(1);
        let mut bytes = [0; 1 + MAX_FRAME];
        let length = encode_request(request, self.sequence, &mut bytes[1..])?;
        self.send_bytes(&bytes[..=length])?;
        Ok(self.sequence)
    }

    /// Asks, and waits for the answer. A board that is busy is asked again.
    pub fn ask(&mut self, request: &Request) -> anyhow::Result<Response> {
        let deadline = self.now() + ANSWER;
        let mut sequence = self.send(request)?;
        loop {
            match self.answer_to(sequence) {
                Some(Response::Refused(hexsense_core::wire::Refusal::Busy)) => {
                    self.run(PAUSE)?;
                    sequence = self.send(request)?;
                }
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

    /// Who the board is.
    pub fn identity(&mut self) -> anyhow::Result<Identity> {
        match self.ask(&Request::Identity)? {
            Response::Identity(identity) => Ok(identity),
            other => bail!("no identity but {other:?}"),
        }
    }

    /// Streams the counts of all channels at 4 kHz.
    pub fn stream_everything(&mut self) -> anyhow::Result<()> {
        self.order(&Request::Rate(4_000))?;
        self.blocks.clear();
        self.order(&Request::Stream(StreamContent {
            counts: true,
            ..StreamContent::default()
        }))
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

    /// All answers that came.
    pub fn take_answers(&mut self) -> Vec<(u16, Option<Response>)> {
        self.answers.drain(..).collect()
    }

    fn receive(&mut self, timeout: Duration) -> anyhow::Result<()> {
        let mut received = Vec::new();
        self.transport.read(&mut received, timeout)?;
        for byte in received {
            match self.deframer.push(byte) {
                None => {}
                Some(Closed::Overlong) => self.damaged += 1,
                Some(Closed::Frame(bytes)) => match frame::decode(bytes) {
                    Err(_) => self.damaged += 1,
                    Ok(frame) if frame.kind == Kind::Response => {
                        let answer = decode_response(frame.payload);
                        self.answers.push_back((frame.sequence, answer));
                    }
                    Ok(frame) if frame.kind == Kind::Block => {
                        let block = telemetry::decode(frame.payload);
                        self.blocks
                            .extend(block.map(|block| (frame.sequence, block)));
                    }
                    Ok(_) => {}
                },
            }
        }
        Ok(())
    }
}

/// Whether the board has lost its power: nothing is at the other end of the line any more.
pub fn is_gone(error: &anyhow::Error) -> bool {
    matches!(
        error.downcast_ref(),
        Some(TransportError::Closed { .. } | TransportError::Failed { .. })
    )
}
