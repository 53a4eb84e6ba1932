//! The recorder against a fake board: what its sinks get.

mod fake;

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::{Arc, Mutex};

use fake::key::KEY;
use fake::line::Line;
use fake::set::{encoded, set};
use fake::source::Still;
use fake::{FakeBoard, Fault};
use hexsense_client::Client;
use hexsense_core::authority::tag;
use hexsense_core::sampling::BlockSize;
use hexsense_core::storage::StorageCommand;
use hexsense_core::wire::change::{Act, Change};
use hexsense_core::wire::telemetry::Block;
use hexsense_core::wire::{Response, StreamContent};
use hexsense_probe::capture::Gap;
use hexsense_probe::files::FileError;
use hexsense_probe::interrupt::Interrupt;
use hexsense_probe::record::RecordError;
use hexsense_probe::record::board::Streaming;
use hexsense_probe::record::recorder::Recorder;
use hexsense_probe::record::sink::{Notes, Recorded, Sink};
use sha2::{Digest, Sha256};

/// What a sink got; blocks by their first scans, from the first block on.
#[derive(Debug, PartialEq)]
enum Got {
    Begin(Notes),
    Block(u64),
    Gap(Gap),
    End(Recorded),
}

#[derive(Clone, Default)]
struct Log(Rc<RefCell<Vec<Got>>>);

impl Log {
    fn note(&self, got: Got) -> Result<(), FileError> {
        self.0.borrow_mut().push(got);
        Ok(())
    }
}

impl Sink for Log {
    fn begin(&mut self, notes: &Notes) -> Result<(), FileError> {
        self.note(Got::Begin(notes.clone()))
    }

    fn block(&mut self, block: &Block) -> Result<(), FileError> {
        self.note(Got::Block(block.header.first_scan))
    }

    fn gap(&mut self, gap: Gap) -> Result<(), FileError> {
        self.note(Got::Gap(gap))
    }

    fn end(&mut self, recorded: &Recorded) -> Result<(), FileError> {
        self.note(Got::End(recorded.clone()))
    }
}

const STREAMING: Streaming = Streaming {
    rate_hz: 1_000,
    block: BlockSize::Sixteen,
    content: StreamContent {
        counts: true,
        values: false,
        pose: false,
    },
};

#[test]
fn every_sink_gets_the_notes_the_blocks_the_gap_and_the_end_in_order() {
    let board = Arc::new(Mutex::new(FakeBoard::new(Box::new(Still))));
    let mut client = Client::connect(Line::to(&board)).unwrap();
    let interrupt = Interrupt::default();
    let mut recorder = Recorder::start(&mut client, STREAMING, &interrupt).unwrap();
    let sinks = [Log::default(), Log::default()];
    let boxed = sinks.clone().map(|sink| Box::new(sink) as Box<dyn Sink>);
    recorder.begin(boxed.into()).unwrap();
    let first = recorder.next_block().unwrap().header.first_scan;
    recorder.begin_again().unwrap();
    let block = |number: u64| first + 16 * number;
    recorder.next_block().unwrap();
    let next = block(2) / 16 + 1;
    board.lock().unwrap().lose_blocks = next..next + 2;
    recorder.next_block().unwrap();
    assert_eq!(recorder.next_scan(), block(5));
    let notes = recorder.notes().clone();
    let recorded = recorder.end().unwrap();

    let gap = Gap {
        first_scan: block(2),
        scans: 32,
    };
    let expected = Recorded {
        scans: 32,
        lost: 32,
        gaps: vec![gap],
    };
    assert_eq!(recorded, expected);
    for Log(got) in sinks {
        let order = [
            Got::Begin(notes.clone()),
            Got::Block(first),
            Got::Begin(notes.clone()),
            Got::Block(block(1)),
            Got::Gap(gap),
            Got::Block(block(4)),
            Got::End(recorded.clone()),
        ];
        assert_eq!(*got.borrow(), order);
    }
}

#[test]
fn a_request_to_stop_and_a_restart_end_the_recording() {
    let board = Arc::new(Mutex::new(FakeBoard::new(Box::new(Still))));
    let mut client = Client::connect(Line::to(&board)).unwrap();
    let interrupt = Interrupt::default();
    let mut recorder = Recorder::start(&mut client, STREAMING, &interrupt).unwrap();
    for _ in 0..3 {
        recorder.next_block().unwrap();
    }
    board.lock().unwrap().switch_on();
    recorder.client().stream(STREAMING.content).unwrap();
    let error = recorder.next_block().unwrap_err();
    assert!(matches!(error, RecordError::Restarted { .. }), "{error}");
    interrupt.raise();
    let error = recorder.next_block().unwrap_err();
    assert!(matches!(error, RecordError::Interrupted(_)), "{error}");
}

/// Stores a set on the board by itself.
fn store(board: &mut FakeBoard, unix_s: u64) {
    let bytes = encoded(&set(unix_s));
    let Ok(Response::Challenge(challenge)) = board.keep(StorageCommand::Challenge) else {
        panic!("a challenge is always given");
    };
    let act = Act::Upload {
        length: bytes.len() as u16,
        digest: Sha256::digest(&bytes).into(),
    };
    let change = Change { unix_s, act };
    let tag = tag(&KEY, &challenge, b"fake board 1", &change);
    board.keep(StorageCommand::Change(change, tag)).unwrap();
    for (index, piece) in bytes.chunks(100).enumerate() {
        let piece = piece.iter().copied().collect();
        let command = StorageCommand::Chunk(index as u16 * 100, piece);
        board.keep(command).unwrap();
    }
    board.keep(StorageCommand::Commit).unwrap();
}

#[test]
fn a_set_that_comes_or_is_replaced_ends_the_recording_and_one_that_stays_does_not() {
    for before in [None, Some(1)] {
        let mut board = FakeBoard::new(Box::new(Still));
        before
            .into_iter()
            .for_each(|unix_s| store(&mut board, unix_s));
        let board = Arc::new(Mutex::new(board));
        let mut client = Client::connect(Line::to(&board)).unwrap();
        let interrupt = Interrupt::default();
        let mut recorder = Recorder::start(&mut client, STREAMING, &interrupt).unwrap();
        recorder.begin(Vec::new()).unwrap();
        for _ in 0..3 {
            recorder.next_block().unwrap();
        }
        store(&mut board.lock().unwrap(), 2);
        let next_scan = recorder.next_scan();
        let error = recorder.next_block().unwrap_err();
        let RecordError::OtherSet { scan } = error else {
            panic!("{error}");
        };
        assert!(scan >= next_scan, "{scan}");
    }
}

#[test]
fn blocks_whose_counts_have_no_known_scale_and_numbers_that_are_none_are_in_no_recording() {
    let streaming = Streaming {
        content: StreamContent {
            values: true,
            ..STREAMING.content
        },
        ..STREAMING
    };
    for (fault, named) in [
        (Fault::OldSupply, None),
        (Fault::NoSupplyFactor, Some("the supply factor")),
        (Fault::NoTemperature, Some("the temperature")),
        (Fault::NoValues, Some("ax")),
    ] {
        let mut board = FakeBoard::new(Box::new(Still));
        store(&mut board, 1);
        let board = Arc::new(Mutex::new(board));
        let mut client = Client::connect(Line::to(&board)).unwrap();
        let interrupt = Interrupt::default();
        let mut recorder = Recorder::start(&mut client, streaming, &interrupt).unwrap();
        let log = Log::default();
        recorder.begin(vec![Box::new(log.clone())]).unwrap();
        let mut good = vec![recorder.next_block().unwrap().header.first_scan];
        board.lock().unwrap().fault = fault;
        let next = recorder.next_scan();
        let error = loop {
            match recorder.next_block() {
                // One that was on its way.
                Ok(block) => {
                    let scan = block.header.first_scan;
                    assert!(scan < next + 32, "{fault:?} is recorded");
                    good.push(scan);
                }
                Err(error) => break error,
            }
        };
        let found = match &error {
            RecordError::OldSupply { scan } => (*scan >= next).then_some(None),
            RecordError::NotFinite { scan, what, .. } => (*scan >= next).then_some(Some(*what)),
            _ => None,
        };
        assert_eq!(found, Some(named), "{error}");
        let log = log.0.borrow();
        let blocks = log.iter().filter_map(|got| match got {
            Got::Block(scan) => Some(*scan),
            _ => None,
        });
        assert!(blocks.eq(good), "{fault:?}: {log:?}");
    }
}
