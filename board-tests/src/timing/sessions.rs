//! The firmware on the virtual board, busy: streaming, estimating, solving poses, with coefficients that come and go.

use std::time::Duration;

use anyhow::{Context, ensure};
use hexsense_client::Client;
use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::{ANALYSERS, Drive, increment};
use hexsense_core::records::MAX_ENCODED;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::change::Key;
use hexsense_core::wire::{AnalyserState, Request, StreamContent};

use crate::counts::{Counts, Masked};
use crate::line::Line;
use crate::process::Beside;
use crate::trial_set::Random;

/// Blocks between one drive and the next.
const BLOCKS_OF_A_DRIVE: u64 = 250;
/// Blocks that an analyser settles, and blocks that it sums; for the rest of a drive it is complete.
const BLOCKS_OF_A_STATE: u32 = 100;
/// Blocks of a drive after which the analyser must be in each state.
const STATES: [(u64, AnalyserState); 3] = [
    (50, AnalyserState::Settling),
    (150, AnalyserState::Summing),
    (240, AnalyserState::Complete),
];
/// Drives between one set of coefficients and the next.
const DRIVES_OF_A_SET: u64 = 10;
/// Requests of a flood, and the time in which the board answers them.
const FLOOD: u32 = 200;
const FLOOD_LASTS: Duration = Duration::from_millis(600);
/// The key of a board that has no secrets.
const KEY: Key = Key([0; 32]);
/// Longer than any block lasts.
const PATIENCE: Duration = Duration::from_secs(1);

/// What one session did.
pub struct Session {
    /// What was counted.
    pub counts: Counts,
    /// Virtual time that it lasted, s.
    pub lasted_s: f64,
}

/// A board and the chances that it is given.
pub struct Sessions {
    board: Beside,
    random: Random,
    now_s: f64,
    /// The longest stretch with masked interrupts since the board has started.
    pub masked: Masked,
}

impl Sessions {
    /// Sessions on a board that has just been switched on. What it does before it first answers is not counted.
    pub fn new(board: Beside) -> anyhow::Result<Self> {
        let mut sessions = Self {
            board,
            random: Random(0x9E37_79B9),
            now_s: 0.0,
            masked: Masked::default(),
        };
        let client = sessions.connect()?;
        sessions.leave(client)?;
        sessions.masked = Masked::default();
        Ok(sessions)
    }

    /// Scans at `rate_hz` in blocks of sixteen until `blocks` have been streamed beside poses; one analyser settles, sums
    /// and is complete, over and over.
    pub fn run(&mut self, rate_hz: u32, blocks: u64) -> anyhow::Result<Session> {
        let mut client = self.connect()?;
        if !client.status()?.provisioned {
            client.provision(&KEY, &KEY)?;
        }
        client.rate(rate_hz)?;
        client.block_size(BlockSize::Sixteen)?;
        self.upload(&mut client)?;
        client.drive(0, drive(&mut self.random))?;
        // The line carries counts and values together up to 1 kHz.
        let content = StreamContent {
            counts: true,
            values: rate_hz == 1_000,
            pose: true,
        };
        client.stream(content)?;
        // The first poses start from home; they are not counted.
        client.pose(PATIENCE)?;
        client.pose(PATIENCE)?;
        self.leave(client)?;
        let began_s = self.now_s;
        let mut client = self.connect()?;
        client.stream(content)?;
        for block in 1..=blocks {
            client.block(PATIENCE)?;
            client.take_poses();
            for (at, expected) in STATES {
                if block % BLOCKS_OF_A_DRIVE == at {
                    let state = client.status()?.analysers[0];
                    ensure!(state == expected, "after {at} blocks of a drive: {state:?}");
                }
            }
            if block % BLOCKS_OF_A_DRIVE == 0 {
                client.drive(0, drive(&mut self.random))?;
            }
            if block % (BLOCKS_OF_A_DRIVE * DRIVES_OF_A_SET) == 0 {
                self.upload(&mut client)?;
            }
        }
        let counts = self.leave(client)?;
        Ok(Session {
            counts,
            lasted_s: self.now_s - began_s,
        })
    }

    /// Has the board solve all channels of a window of three periods, and counts.
    pub fn fits(&mut self) -> anyhow::Result<Counts> {
        let mut client = self.connect()?;
        client.rate(1_000)?;
        let drive = Drive {
            increment: increment(0.9, 1_000).context("a drive that the board takes")?,
            block: BlockSize::Sixteen,
            settle_blocks: 0,
            blocks: 208,
        };
        client.drive(0, drive)?;
        client.stream(StreamContent {
            counts: true,
            ..StreamContent::default()
        })?;
        for _ in 0..=drive.blocks {
            client.block(PATIENCE)?;
        }
        for channel in 0..CHANNELS as u8 {
            client.harmonics(0, channel)?;
        }
        // What comes out depends on the voltages; what it takes to ask does not.
        let _ = client.motion(0)?;
        self.leave(client)
    }

    /// Streams in blocks of every size, while all analysers sum and the host floods the line with requests.
    pub fn floods(&mut self) -> anyhow::Result<()> {
        for block in BlockSize::ALL {
            let mut client = self.connect()?;
            client.rate(4_000)?;
            client.block_size(block)?;
            let drive = Drive {
                increment: increment(2.0, 4_000).context("a drive that the board takes")?,
                block,
                settle_blocks: 0,
                blocks: 1 << 20,
            };
            for analyser in 0..ANALYSERS as u8 {
                client.drive(analyser, drive)?;
            }
            self.leave(client)?;
            let mut line = Line::open(self.board.address("link")?)?;
            line.stream(false, true)?;
            for number in 0..FLOOD {
                line.send(&match number % 4 {
                    0 => Request::Identity,
                    1 => Request::Sums {
                        analyser: 1,
                        channel: 3,
                    },
                    2 => Request::History { age: 0 },
                    _ => Request::Status,
                })?;
            }
            line.run(FLOOD_LASTS)?;
            drop(line);
            let counts = Counts::read(&mut self.board)?;
            self.note(&counts);
        }
        Ok(())
    }

    fn connect(&self) -> anyhow::Result<Client> {
        let client = Client::open(self.board.address("link")?);
        let mut client = client.context("the firmware on the virtual board")?;
        // The last session left its stream on.
        client.stream(StreamContent::default())?;
        client.forget_blocks();
        Ok(client)
    }

    fn leave(&mut self, client: Client) -> anyhow::Result<Counts> {
        self.now_s = client.now().as_secs_f64();
        drop(client);
        let counts = Counts::read(&mut self.board)?;
        self.note(&counts);
        Ok(counts)
    }

    fn note(&mut self, counts: &Counts) {
        if counts.masked.cycles > self.masked.cycles {
            self.masked = counts.masked.clone();
        }
    }

    fn upload(&mut self, client: &mut Client) -> anyhow::Result<()> {
        let set = self.random.set(client.identity()?.board);
        let mut room = [0; MAX_ENCODED];
        client.upload(set.encode(&mut room)?, &KEY)?;
        Ok(())
    }
}

/// Any frequency that blocks of sixteen allow, so phases are random too; the analyser goes through all its states.
fn drive(random: &mut Random) -> Drive {
    Drive {
        increment: u64::from(random.bits()) << 24 | 1,
        block: BlockSize::Sixteen,
        settle_blocks: BLOCKS_OF_A_STATE,
        blocks: BLOCKS_OF_A_STATE,
    }
}
