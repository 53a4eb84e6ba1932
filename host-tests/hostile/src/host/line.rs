//! The line to a board that says anything, steered by the input.

use std::time::Duration;

use hexsense_client::{Transport, TransportError};
use hexsense_core::wire::{Kind, MAX_PAYLOAD, Request, frame};

use crate::frames::encoded;
use crate::input::Input;
use crate::liar::{self, CONTENT, Ear, Heard};

/// The line to the board. It ends with the input.
pub struct Line {
    input: Vec<u8>,
    at: usize,
    now: Duration,
    ear: Ear,
    waiting: Option<Heard>,
    /// Good answers that come before the input is looked at again.
    good: u8,
    scan: u64,
    frames: u16,
}

impl Line {
    /// A line of which the board knows nothing yet.
    pub fn new(input: &[u8]) -> Self {
        Self {
            input: input.to_vec(),
            at: 0,
            now: Duration::ZERO,
            ear: Ear::default(),
            waiting: None,
            good: 1,
            scan: 0,
            frames: 0,
        }
    }

    /// Takes bytes of the input with `take`.
    fn steer<T>(&mut self, take: impl FnOnce(&mut Input) -> T) -> T {
        let mut rest = Input(&self.input[self.at..]);
        let taken = take(&mut rest);
        self.at = self.input.len() - rest.0.len();
        taken
    }

    /// A payload of the input's own.
    fn payload(&mut self) -> Vec<u8> {
        self.steer(|input| {
            let length = usize::from(input.byte());
            input.bytes(length).to_vec()
        })
    }

    /// The frame that a good board sends now.
    fn good_frame(&mut self) -> Vec<u8> {
        match self.waiting.take() {
            Some(Heard::Hello) => liar::greeting_frame(),
            Some(Heard::Request(sequence, request)) => {
                liar::answer_frame(&liar::answer(&request), sequence)
            }
            None => self.block(),
        }
    }

    /// The number of the request that waits, which is then answered.
    fn awaited(&mut self) -> u16 {
        match self.waiting.take() {
            Some(Heard::Request(sequence, _)) => sequence,
            _ => 0,
        }
    }

    fn block(&mut self) -> Vec<u8> {
        let header = liar::header(self.scan, CONTENT);
        (self.scan, self.frames) = (self.scan + 1, self.frames.wrapping_add(1));
        liar::block_frame(&header, 1.5, self.frames)
    }

    fn pose(&mut self) -> Vec<u8> {
        self.frames = self.frames.wrapping_add(1);
        liar::pose_frame(&liar::pose_report(), self.frames)
    }

    /// A frame with other bytes in its payload.
    fn changed(&mut self, mut bytes: Vec<u8>, changes: u8) -> Vec<u8> {
        let length = bytes.len() - 1;
        let whole = frame::decode(&mut bytes[..length]).expect("an own frame");
        let (kind, sequence, mut payload) = (whole.kind, whole.sequence, whole.payload.to_vec());
        for _ in 0..changes {
            let (place, value) = self.steer(|input| (input.short(), input.byte()));
            let place = usize::from(place) % (payload.len() + 1);
            if place < payload.len() {
                payload[place] = value;
            } else if place < MAX_PAYLOAD {
                payload.push(value);
            }
        }
        encoded(kind, sequence, &payload)
    }

    /// The answer to another request than the one that was asked.
    fn other_answer(&mut self) -> Vec<u8> {
        let sequence = self.awaited();
        let other = self.steer(|input| {
            input.pick(&[
                || Request::Identity,
                || Request::Status,
                || Request::ActiveSet,
                || Request::History { age: 0 },
                || Request::Log { counter: 0 },
                || Request::ReadSet { offset: 1 },
                || Request::UploadAbort,
                || Request::UploadCommit,
            ] as &[fn() -> Request])
        });
        liar::answer_frame(&liar::answer(&other()), sequence)
    }

    /// What the board sends next.
    fn bytes(&mut self, timeout: Duration) -> Vec<u8> {
        if self.good > 0 {
            self.good -= 1;
            return self.good_frame();
        }
        let step = self.steer(|input| input.byte());
        let changes = 1 + (step >> 4) % 4;
        match step & 15 {
            0 => {
                self.now += timeout;
                Vec::new()
            }
            1 => self.payload(),
            2 => {
                let sequence = self.awaited();
                let payload = self.payload();
                encoded(Kind::Response, sequence, &payload)
            }
            3 => self.good_frame(),
            4..=6 => {
                let good = self.good_frame();
                self.changed(good, changes)
            }
            7 => self.other_answer(),
            8 => {
                let payload = self.payload();
                encoded(Kind::Greeting, 0, &payload)
            }
            9 => self.block(),
            10 | 11 => {
                let good = self.block();
                self.changed(good, changes)
            }
            12 => self.pose(),
            13 => {
                let good = self.pose();
                self.changed(good, changes)
            }
            _ => {
                self.good = step >> 4;
                self.good_frame()
            }
        }
    }
}

impl Transport for Line {
    fn write(&mut self, bytes: &[u8]) -> Result<(), TransportError> {
        self.waiting = self.ear.hear(bytes).pop().or(self.waiting.take());
        Ok(())
    }

    fn read(&mut self, into: &mut Vec<u8>, timeout: Duration) -> Result<(), TransportError> {
        if self.at >= self.input.len() && self.good == 0 {
            let port = self.port().to_owned();
            return Err(TransportError::Closed { port });
        }
        self.now += Duration::from_millis(1);
        let bytes = self.bytes(timeout);
        into.extend(bytes);
        Ok(())
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn port(&self) -> &str {
        "liar"
    }
}
