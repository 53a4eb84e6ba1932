//! The host against a board that says anything: commands end with a text or a typed error, no value that is not finite is
//! recorded, and nothing is printed that a terminal obeys.
//!
//! The first byte chooses a command, the others steer what the board sends: good answers, changed ones, those of other
//! requests, blocks and poses, and bytes that are nothing.

use std::time::Duration;

use hexsense_client::{Client, Transport, TransportError};
use hexsense_core::records::SetId;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::telemetry::Block;
use hexsense_core::wire::{Kind, MAX_PAYLOAD, Request, StreamContent, frame};
use hexsense_probe::capture::Gap;
use hexsense_probe::cli::{harmonics, history, info, log, show, status};
use hexsense_probe::files::FileError;
use hexsense_probe::interrupt::Interrupt;
use hexsense_probe::record::board::Streaming;
use hexsense_probe::record::recorder::Recorder;
use hexsense_probe::record::sink::{Notes, Recorded, Sink};
use hexsense_probe::terminal::{escaped, one_line};

use crate::frames::encoded;
use crate::input::Input;
use crate::key_holder::KEY;
use crate::liar::{self, Ear, Heard};
use crate::sets;

/// Blocks of a recording.
const BLOCKS: usize = 32;
const CONTENT: StreamContent = StreamContent {
    counts: true,
    values: true,
    pose: true,
};

/// Runs one command against one board.
///
/// # Panics
/// When a promise is broken.
pub fn run(data: &[u8]) {
    let Some((command, input)) = data.split_first() else {
        return;
    };
    let mut client = match Client::connect(Box::new(Line::new(input))) {
        Ok(client) => client,
        Err(error) => return shown(&error.to_string()),
    };
    let text = match command % 16 {
        0 => info::text(&mut client),
        1 => status::text(&mut client, false),
        2 => status::text(&mut client, true).inspect(|text| document(text)),
        3 => show::text(&mut client, false),
        4 => show::text(&mut client, true).inspect(|text| document(text)),
        5 => log::text(&mut client, false),
        6 => log::text(&mut client, true).inspect(|text| document(text)),
        7 => history::text(&mut client, false),
        8 => history::text(&mut client, true).inspect(|text| document(text)),
        9 => harmonics::text(&mut client, 0, false),
        10 => harmonics::text(&mut client, 0, true).inspect(|text| document(text)),
        11 => {
            let uploaded = client.upload(&sets::encoded(&sets::numbered(1)), &KEY);
            uploaded
                .map(|active| active.id.to_string())
                .map_err(Into::into)
        }
        12 => {
            let rolled_back = client.roll_back(&KEY, SetId([3; 8]));
            rolled_back
                .map(|active| active.id.to_string())
                .map_err(Into::into)
        }
        13 => {
            let erased = client.factory_reset(&KEY);
            erased
                .map(|sets| sets.len().to_string())
                .map_err(Into::into)
        }
        _ => record(&mut client),
    };
    match text {
        Ok(text) => shown(&text),
        Err(error) => shown(&error.to_string()),
    }
}

/// What is printed is not obeyed.
fn shown(text: &str) {
    let printed = escaped(text);
    let is_obeyed = |letter: char| letter.is_control() && !matches!(letter, '\n' | '\t');
    assert!(
        !printed.is_empty() && !printed.chars().any(is_obeyed),
        "{printed:?}"
    );
    assert!(!one_line(text).to_string().contains(char::is_control));
}

/// What is printed of a document is one, and the same.
fn document(text: &str) {
    let read = |text: &str| serde_json::from_str::<serde_json::Value>(text).expect("a document");
    assert_eq!(read(&escaped(text)), read(text));
}

/// Records some blocks.
fn record(client: &mut Client) -> anyhow::Result<String> {
    let interrupt = Interrupt::default();
    let streaming = Streaming {
        rate_hz: liar::RATE_HZ,
        block: BlockSize::One,
        content: CONTENT,
    };
    let mut recorder = Recorder::start(client, streaming, &interrupt)?;
    recorder.begin(vec![Box::new(Judge::default())])?;
    for _ in 0..BLOCKS {
        recorder.next_block()?;
    }
    let recorded = recorder.end()?;
    Ok(format!("{} scans", recorded.scans))
}

/// A sink that nothing impossible reaches.
#[derive(Default)]
struct Judge {
    next_scan: u64,
}

impl Sink for Judge {
    fn begin(&mut self, _: &Notes) -> Result<(), FileError> {
        Ok(())
    }

    fn block(&mut self, block: &Block) -> Result<(), FileError> {
        let header = &block.header;
        let values = block.values.iter().flatten().flatten();
        let mut numbers = values.chain([&header.supply, &header.temperature_c]);
        assert!(numbers.all(|number| number.is_finite()), "{block:?}");
        assert!(header.first_scan >= self.next_scan && header.first_scan <= 1 << 53);
        self.next_scan = header.first_scan + u64::from(header.scans);
        Ok(())
    }

    fn gap(&mut self, gap: Gap) -> Result<(), FileError> {
        assert!(gap.scans > 0 && gap.first_scan == self.next_scan);
        Ok(())
    }

    fn end(&mut self, _: &Recorded) -> Result<(), FileError> {
        Ok(())
    }
}

/// The line to the board. It ends with the input.
struct Line {
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
    fn new(input: &[u8]) -> Self {
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
