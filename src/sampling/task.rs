//! The task above the sample path: it starts the converters, gives the path what seldom changes, and starts them anew
//! when rate or block change or a fault stopped them.
//!
//! The samples themselves do not pass through it, see [`super::path`]. The scan counter never goes back. When the
//! converters start anew, it leaps by the scans of the pause, which count as lost. The analysers stop then, because their
//! sums would have a hole.

use embassy_futures::select::{Either, Either4, select, select4};
use embassy_sync::watch::Receiver;
use embassy_time::{Instant, Timer};
use hexsense::FACTS;
use hexsense_core::sample_path::Progress;
use hexsense_core::sample_path::queue::Context;
use hexsense_core::sampling::{BlockSize, Prepared, SupplyReading};
use hexsense_core::server::SamplingCommand;
use hexsense_core::wire::Response;

use super::acquisition::{self, Fault, Run};
use super::path;
use crate::chip::pins;
use crate::chip::timing::{FIRST_BLOCK_POLL, block_timeout};
use crate::health::counters;
use crate::shared::{Active, Guard, Shared, Task};

/// Why a run ended.
enum End {
    Command(SamplingCommand),
    Fault(Fault),
}

/// Samples for ever.
#[embassy_executor::task]
pub async fn sample(mut parts: pins::Acquisition, shared: &'static Shared) -> ! {
    let (mut rate_hz, mut block) = (FACTS.rates_hz[0], BlockSize::default());
    path::begin(rate_hz, block, 0);
    let mut conditions = Conditions::new(shared).await;
    let mut before: Option<Start> = None;
    let mut answer_due = false;
    loop {
        let mut run = Run::prepare(&mut parts, rate_hz, block);
        if let Some(fault) = path::take_fault() {
            count(fault);
        }
        let start = Start::new(before, rate_hz, block);
        run.start();
        let end = follow(shared, &mut conditions, &mut answer_due).await;
        path::end();
        match end {
            End::Command(command) => {
                answer_due = true;
                match command {
                    SamplingCommand::Rate(hz) => rate_hz = hz,
                    SamplingCommand::Block(size) => block = size,
                }
            }
            End::Fault(fault) => count(fault),
        }
        before = Some(start);
    }
}

/// Counts a fault, for the host.
fn count(fault: Fault) {
    let scans = path::with(|path| path.progress.scans());
    defmt::warn!("converters: {} after {} scans", fault, scans);
    counters::note(match fault {
        Fault::Overrun => |events| &mut events.overruns,
        Fault::Late => |events| &mut events.late_blocks,
        Fault::Stuck => |events| &mut events.stuck,
        Fault::Slipped => |events| &mut events.slips,
    });
}

/// Where a run of the converters began.
#[derive(Clone, Copy)]
struct Start {
    at: Instant,
    rate_hz: u32,
    /// Scan counter of its first scan.
    scan: u64,
}

impl Start {
    /// Begins a run on the path, with the scans that were due since the start `before` it and were not taken.
    fn new(before: Option<Self>, rate_hz: u32, block: BlockSize) -> Self {
        let at = Instant::now();
        let lost = before.map_or(0, |before| {
            let micros = (at - before.at).as_micros();
            let due = micros * u64::from(before.rate_hz) / 1_000_000;
            due.saturating_sub(path::with(|path| path.progress.next_scan) - before.scan)
        });
        path::begin(rate_hz, block, lost);
        Self {
            at,
            rate_hz,
            scan: path::with(|path| path.progress.next_scan),
        }
    }
}

/// Waits for the end of a run, and keeps what the path needs up to date until then.
///
/// Only blocks are a sign of life. A command is answered when the first block has come, so that no number of commands
/// can keep blocks from coming.
async fn follow(shared: &Shared, conditions: &mut Conditions, answer_due: &mut bool) -> End {
    let Progress {
        mut next_scan,
        rate_hz,
        block,
        ..
    } = path::with(|path| path.progress);
    let patience = block_timeout(rate_hz, block);
    let mut due = Instant::now() + patience;
    loop {
        let look = if *answer_due {
            due.min(Instant::now() + FIRST_BLOCK_POLL)
        } else {
            due
        };
        match select4(
            shared.to_sampling.receive(),
            path::fault(),
            conditions.change(),
            Timer::at(look),
        )
        .await
        {
            Either4::First(command) => return End::Command(command),
            Either4::Second(fault) => return End::Fault(fault),
            Either4::Third(()) => conditions.install().await,
            Either4::Fourth(()) => {}
        }
        let now = path::with(|path| path.progress.next_scan);
        if now != next_scan {
            next_scan = now;
            due = Instant::now() + patience;
            shared.alive.sign(Task::Sampling);
            if core::mem::take(answer_due) {
                shared.answers.send(Response::Done).await;
            }
        } else if Instant::now() >= due {
            return End::Fault(acquisition::why_no_block());
        }
    }
}

/// Supply, temperature and coefficients: what the path applies and seldom changes.
///
/// A bit of the coefficients that flips in RAM would spoil all values from then on. So the storage reads the active set
/// from flash again every second, and what is here is compared with it; what the path has is compared with what it was
/// given, whenever it is given anew. A difference is counted, and the set from flash goes to work.
struct Conditions {
    supply: Receiver<'static, Guard, SupplyReading, 3>,
    active: Receiver<'static, Guard, Option<Active>, 2>,
    reading: SupplyReading,
    set: Option<Active>,
    /// Checksum of what the path was given.
    given: u32,
}

impl Conditions {
    /// Waits for the first reading of the supply, without which a count means little.
    async fn new(shared: &'static Shared) -> Self {
        // There is a receiver of each for this task, which starts once.
        let mut supply = shared.supply.receiver().expect("a receiver is left");
        let active = shared.active.receiver().expect("a receiver is left");
        let reading = supply.get().await;
        let mut conditions = Self {
            supply,
            active,
            reading,
            set: None,
            given: Prepared::NONE.checksum(),
        };
        conditions.install().await;
        conditions
    }

    /// Waits until one of them changes.
    async fn change(&mut self) {
        match select(self.supply.changed(), self.active.changed()).await {
            Either::First(reading) => self.reading = reading,
            Either::Second(active) => {
                if let (Some(here), Some(stored)) = (&self.set, &active)
                    && here.id == stored.id
                    && here.calibrator != stored.calibrator
                {
                    counters::note(|events| &mut events.coefficients_restored);
                }
                self.set = active;
            }
        }
    }

    /// Gives them to the path. Here are the only divisions of the calibration.
    async fn install(&mut self) {
        let supply = self.reading.factor;
        let context = Context {
            supply,
            temperature_c: self.reading.temperature_c,
            set: self.set.as_ref().map(|active| active.id),
            supply_is_old: self.reading.is_old,
        };
        let prepared = self
            .set
            .as_ref()
            .map_or(Prepared::NONE, |active| active.calibrator.at_supply(supply));
        if path::with(|path| path.prepared().checksum()) != self.given {
            counters::note(|events| &mut events.coefficients_restored);
        }
        self.given = prepared.checksum();
        while !path::with(|path| path.set_context(context, &prepared)) {
            Timer::after_millis(1).await;
        }
    }
}
