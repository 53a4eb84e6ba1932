//! The sample path: from converter to harmonic sums, calibrated values and the link, block by block.
//!
//! It runs above everything else that waits. Each block takes the same work: sixteen scans are added to the
//! harmonic sums, the active set is applied, and the block goes to the link if that has room; if not, it is counted
//! as dropped, and the sums have it all the same. Commands take effect between blocks.
//!
//! The scan counter never goes back. It goes on over a change of rate; after a fault of the converters it leaps by
//! the scans that were lost, and the harmonic sums, which would have a hole, are given up.

use embassy_sync::{watch, zerocopy_channel};
use embassy_time::Instant;
use hexsense::channel::{CHANNELS, INERTIAL, Scan};
use hexsense::harmonics::{Analyser, ChannelSums};
use hexsense::sampling::{BLOCK, BlockSize, BlockSums, RATES_HZ, Values};
use hexsense::wire::Drive;
use hexsense::wire::message::{Response, StreamContent};
use hexsense::wire::telemetry::Header;

use super::acquisition::{Buffers, Fault, Run};
use super::exchange::{Active, Exchange, Guard, Progress};
use super::pins;
use super::supply::Reading;

/// Blocks that wait for the link: at 4 kHz four of them are 16 ms, more than three times its longest frame.
pub const QUEUED: usize = 4;

/// One block on its way to the link.
pub struct Block {
    /// What is common to its scans; the link adds the content.
    pub header: Header,
    /// Raw counts.
    pub counts: [Scan; BLOCK],
    /// Calibrated values; meaningless when `header.set` is `None`.
    pub values: [Values; BLOCK],
}

impl Block {
    /// Room for a block.
    pub const EMPTY: Self = Self {
        header: Header {
            first_scan: 0,
            scans: BLOCK as u8,
            rate_hz: 0,
            supply: 0.0,
            temperature_c: 0.0,
            set: None,
            dropped: 0,
            content: StreamContent {
                counts: false,
                values: false,
                pose: false,
            },
        },
        counts: [[0; CHANNELS]; BLOCK],
        values: [[0.0; INERTIAL]; BLOCK],
    };
}

/// The sample path's end of the queue of blocks.
pub type Blocks = zerocopy_channel::Sender<'static, Guard, Block>;

/// What the link may ask of the sample path. Each is answered once.
#[derive(Clone, Copy)]
pub enum Command {
    /// Scan at this rate, Hz, one of `RATES_HZ`; ends the estimation.
    Rate(u32),
    /// Estimate at this drive frequency, which is possible, from the next block on.
    Drive(Drive),
    /// Report the sums of this channel, 0 to 14.
    Harmonics(u8),
}

/// Why a run ended.
enum End {
    Rate(u32),
    Fault(Fault),
}

/// Samples for ever.
#[embassy_executor::task]
pub async fn sample(
    mut parts: pins::Acquisition,
    exchange: &'static Exchange,
    blocks: Blocks,
) -> ! {
    let mut buffers = Buffers::take();
    let mut path = Path::new(exchange, blocks).await;
    let mut broken_off: Option<Start> = None;
    loop {
        let mut run = Run::start(&mut parts, &mut buffers, path.progress.rate_hz);
        if let Some(before) = broken_off.take() {
            path.skip_lost(before, run.started());
        }
        let start = Start {
            at: run.started(),
            scan: path.progress.scans + path.progress.lost,
        };
        match path.follow(&mut run).await {
            End::Rate(rate_hz) => {
                path.progress.rate_hz = rate_hz;
                path.publish();
                exchange.answers.send(Response::Done).await;
            }
            End::Fault(fault) => {
                defmt::warn!("converters: {}, {}", fault, path.progress);
                broken_off = Some(start);
            }
        }
        path.analyser = Analyser::new();
    }
}

/// Where a run of the converters began.
#[derive(Clone, Copy)]
struct Start {
    at: Instant,
    /// Scan counter of its first scan.
    scan: u64,
}

/// State of the sample path that outlives a run of the converters.
struct Path {
    exchange: &'static Exchange,
    blocks: Blocks,
    supply: watch::Receiver<'static, Guard, Reading, 2>,
    active: watch::Receiver<'static, Guard, Active, 2>,
    set: Option<Active>,
    scans: [Scan; BLOCK],
    analyser: Analyser,
    progress: Progress,
}

impl Path {
    /// Waits for the first reading of the supply, without which a count means little.
    async fn new(exchange: &'static Exchange, blocks: Blocks) -> Self {
        // The exchange has a receiver for this task, which starts once.
        let supply = exchange.supply.receiver().expect("a receiver is left");
        let active = exchange.active.receiver().expect("a receiver is left");
        let mut path = Self {
            exchange,
            blocks,
            supply,
            active,
            set: None,
            scans: [[0; CHANNELS]; BLOCK],
            analyser: Analyser::new(),
            progress: Progress {
                rate_hz: RATES_HZ[0],
                ..Progress::default()
            },
        };
        path.publish();
        path.supply.get().await;
        path
    }

    /// Handles blocks and commands until the converters must be started anew.
    async fn follow(&mut self, run: &mut Run<'_>) -> End {
        loop {
            if let Err(fault) = run.next(&mut self.scans).await {
                return End::Fault(fault);
            }
            self.handle_block().await;
            self.exchange.alive.sampling.signal(());
            if let Ok(command) = self.exchange.to_sampling.try_receive() {
                let answer = match command {
                    Command::Rate(rate_hz) => return End::Rate(rate_hz),
                    Command::Drive(drive) => {
                        self.analyser.start(drive);
                        Response::Done
                    }
                    Command::Harmonics(channel) => self.report(channel),
                };
                self.exchange.answers.send(answer).await;
            }
        }
    }

    async fn handle_block(&mut self) {
        let first_scan = self.progress.scans + self.progress.lost;
        self.analyser
            .take(&BlockSums::of_scans(&self.scans, first_scan));
        if let Some(set) = self.active.try_changed() {
            self.set = Some(set);
        }
        let supply = self.supply.get().await;
        match self.blocks.try_send() {
            Some(block) => {
                block.header = Header {
                    first_scan,
                    scans: BLOCK as u8,
                    rate_hz: self.progress.rate_hz,
                    supply: supply.factor(),
                    temperature_c: supply.temperature_c,
                    set: self.set.as_ref().map(|active| active.set.id),
                    dropped: self.progress.dropped,
                    content: StreamContent::default(),
                };
                block.counts = self.scans;
                if let Some(active) = &self.set {
                    for (values, scan) in block.values.iter_mut().zip(&self.scans) {
                        *values = active.calibrator.apply(scan, supply.factor());
                    }
                }
                self.blocks.send_done();
            }
            None => self.progress.dropped = self.progress.dropped.saturating_add(1),
        }
        self.progress.scans += BLOCK as u64;
        self.publish();
    }

    fn publish(&self) {
        self.exchange.progress.sender().send(self.progress);
    }

    fn report(&self, channel: u8) -> Response {
        let idle = (NO_DRIVE, 0, ChannelSums::default());
        let (drive, first_scan, sums) = self.analyser.report(channel.into()).unwrap_or(idle);
        Response::Harmonics {
            state: self.analyser.state(),
            drive,
            first_scan,
            sums,
        }
    }

    /// Counts the scans that were due between the start of a run that broke off and the start of the next.
    fn skip_lost(&mut self, before: Start, now: Instant) {
        let micros = (now - before.at).as_micros();
        let due = micros * u64::from(self.progress.rate_hz) / 1_000_000;
        let taken = self.progress.scans + self.progress.lost - before.scan;
        self.progress.lost += due.saturating_sub(taken);
    }
}

/// What is reported when nothing is estimated.
const NO_DRIVE: Drive = Drive {
    increment: 0,
    block: BlockSize::Sixteen,
    settle_blocks: 0,
    blocks: 0,
};
