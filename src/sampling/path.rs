//! The sample path: from the filled halves of the rings to calibrated values, harmonic sums and the link's queue, in
//! the interrupt of the converter that ends last.
//!
//! | symbol | what it is |
//! |---|---|
//! | `DMA1_CHANNEL1` | the sample interrupt, first instruction to last |
//! | `sample_path` | everything that is done with a block |
//! | `sample_inertial` | the nine inertial channels: calibrated values, sums, analysers |
//! | `hexsense_core::…::Prepared::block` | values and sums of the block |
//! | `hexsense_core::…::Analyser::take_inertial` | the sums of one analyser, nine channels |
//! | `hexsense_core::…::add_up`, `Sums<6>::add` | the same for the jacks |
//!
//! For one size of block, and as many analysers that are not idle, every block takes the same instructions: nothing
//! branches on a count, nobody waits and nobody is woken. What the others must know they learn in the interrupt of the
//! sampling task's executor, which is pended here and runs later, see [`announce`].
//!
//! The state is one cell that is borrowed with interrupts masked: by the sample interrupt for a block, by the others
//! between two blocks and for some microseconds. So a command takes effect between blocks, whole.
//!
//! Core cycles are taken from DWT's counter, at the interrupt's begin and when all is done.

use core::cell::RefCell;
use core::future::poll_fn;
use core::sync::atomic::{Ordering, compiler_fence};
use core::task::Poll;

use cortex_m::peripheral::DWT;
use embassy_stm32::interrupt::InterruptExt;
use embassy_stm32::interrupt::typelevel::{DMA1_CHANNEL1, Handler};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::waitqueue::AtomicWaker;
use embassy_time::Instant;
use hexsense_core::channel::{INERTIAL, JACKS, unrolled};
use hexsense_core::harmonics::{ANALYSERS, Analyser, Step};
use hexsense_core::sampling::{BlockSize, Prepared, Values, add_up};
use hexsense_core::wire::status::{PathCycles, EventCount};
use hexsense_core::wire::{StreamContent, telemetry};

use super::acquisition::{Fault, Filled};
use super::exchange::Guard;
use super::pins::SAMPLING_VECTOR;
use super::queue::{Context, Queue};

static PATH: Mutex<Guard, RefCell<Path>> = Mutex::new(RefCell::new(Path::new()));
/// The link, when it waits for a block.
static LINK: AtomicWaker = AtomicWaker::new();
/// The sampling task, when it waits for a fault.
static SAMPLING: AtomicWaker = AtomicWaker::new();

/// How far the sample path has come since the start.
#[derive(Clone, Copy)]
pub struct Progress {
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Scans of a block.
    pub block: BlockSize,
    /// Scans taken.
    pub scans: u64,
    /// Scans lost in the converters or their rings, or while those were started anew.
    pub lost: u64,
    /// Scan counter of the first that was lost.
    pub first_lost: Option<u64>,
    /// Blocks that the link had no room for.
    pub dropped: u32,
}

/// State of the sample path.
pub struct Path {
    /// How far it has come.
    pub progress: Progress,
    /// The analysers.
    pub analysers: [Analyser; ANALYSERS],
    /// Blocks for the link.
    pub queue: Queue,
    stream: StreamContent,
    /// Whether the link wants blocks.
    wanted: bool,
    /// Blocks that the link had no room for, with their time.
    pub dropped: EventCount,
    /// Uptime at the first block with a set, ms.
    pub first_with_set_ms: Option<u64>,
    prepared: Prepared,
    /// What the analysers do with the block at hand; here because to make room for it every time would take longer.
    steps: [Step; ANALYSERS],
    running: bool,
    /// Why the run ended, until the sampling task takes it.
    fault: Option<Fault>,
    cycles: PathCycles,
}

impl Path {
    /// All zero, so that it takes no flash.
    const fn new() -> Self {
        Self {
            progress: Progress {
                rate_hz: 0,
                block: BlockSize::One,
                scans: 0,
                lost: 0,
                first_lost: None,
                dropped: 0,
            },
            analysers: [const { Analyser::new() }; ANALYSERS],
            queue: Queue::new(),
            stream: StreamContent {
                counts: false,
                values: false,
                pose: false,
            },
            wanted: false,
            dropped: EventCount::NONE,
            first_with_set_ms: None,
            prepared: Prepared::NONE,
            steps: [Step::NONE; ANALYSERS],
            running: false,
            fault: None,
            cycles: PathCycles {
                min: 0,
                max: 0,
                last: 0,
            },
        }
    }

    /// Scan counter of the next block.
    pub fn next_scan(&self) -> u64 {
        self.progress.scans + self.progress.lost
    }

    /// Begins a run after `lost` scans that were not taken; the analysers stop.
    pub fn begin(&mut self, rate_hz: u32, block: BlockSize, lost: u64) {
        if lost > 0 {
            self.progress.first_lost.get_or_insert(self.next_scan());
        }
        self.progress.lost += lost;
        (self.progress.rate_hz, self.progress.block) = (rate_hz, block);
        self.queue.restart(block);
        self.gather();
        self.analysers
            .iter_mut()
            .for_each(|analyser| *analyser = Analyser::new());
        self.cycles = PathCycles {
            min: u32::MAX,
            max: 0,
            last: 0,
        };
        self.running = true;
    }

    /// What the link streams from the next block on; without blocks and poses what waits is forgotten.
    pub fn set_stream(&mut self, content: StreamContent) {
        self.stream = content;
        self.wanted = content.has_blocks() || content.pose;
        if !self.wanted {
            self.queue.forget();
        }
        self.gather();
    }

    fn gather(&mut self) {
        let Progress { rate_hz, block, .. } = self.progress;
        let scans = telemetry::scans_of_frame(self.stream, rate_hz, block);
        self.queue.gather(scans);
    }

    /// Ends the run: blocks that still come are passed over.
    pub fn end(&mut self) {
        self.running = false;
    }

    /// The supply and set of the next blocks; `false` when they must be offered again later.
    pub fn set_context(&mut self, context: Context, prepared: &Prepared) -> bool {
        let taken = self.queue.set_context(context);
        if taken {
            self.prepared.clone_from(prepared);
        }
        taken
    }

    /// Notes the time of what has happened since it was called last. That is no work for the sample interrupt, which
    /// takes the same time for every block.
    fn note_times(&mut self) {
        let dropped = self.progress.dropped;
        if dropped != self.dropped.count {
            self.dropped = EventCount {
                count: dropped,
                last_ms: Instant::now().as_millis(),
            };
        }
        if self.first_with_set_ms.is_none() && self.queue.latest_values().is_some() {
            self.first_with_set_ms = Some(Instant::now().as_millis());
        }
    }

    /// Core cycles of the blocks of this run.
    pub fn cycles(&self) -> PathCycles {
        if self.cycles.max == 0 {
            PathCycles::default()
        } else {
            self.cycles
        }
    }

    /// Takes the block whose interrupt this is, which began at cycle `begun`.
    #[inline(always)]
    fn interrupt(&mut self, begun: u32) {
        let Some(filled) = Filled::take(self.progress.block).filter(|_| self.running) else {
            return;
        };
        let done = filled.and_then(|filled| {
            self.sample(&filled);
            filled.is_whole().then_some(()).ok_or(Fault::Late)
        });
        match done {
            Ok(()) => self.finish(begun),
            Err(fault) => {
                self.running = false;
                self.fault = Some(fault);
            }
        }
    }

    // SAFETY: no other symbol of the program has this name.
    #[unsafe(export_name = "sample_path")]
    #[inline(never)]
    fn sample(&mut self, filled: &Filled) {
        let first_scan = self.next_scan();
        let slot = self.queue.slot();
        sample_inertial(
            &self.prepared,
            &mut self.analysers,
            first_scan,
            filled.inertial,
            slot.values,
            &mut self.steps,
        );
        let mut jacks = [0; JACKS];
        add_up(filled.jacks, &mut jacks);
        for (analyser, step) in self.analysers.iter_mut().zip(&self.steps) {
            analyser.take_jacks(step, &jacks);
        }
        copy(filled.inertial, slot.inertial);
        copy(filled.jacks, slot.jacks);
    }

    /// Counts the block and hands it to the link.
    #[inline(always)]
    fn finish(&mut self, begun: u32) {
        let kept = self.queue.close(self.next_scan(), self.wanted);
        self.progress.dropped += u32::from(self.wanted & !kept);
        self.progress.scans += self.progress.block.scans() as u64;
        let last = DWT::cycle_count().wrapping_sub(begun);
        self.cycles = PathCycles {
            min: self.cycles.min.min(last),
            max: self.cycles.max.max(last),
            last,
        };
    }
}

/// Copies scans, by the same instructions wherever they lie; a copy of the whole would depend on that. Two scans at a
/// time are whole words.
#[inline(always)]
fn copy<const N: usize>(from: &[[u16; N]], to: &mut [[u16; N]]) {
    let (from_pairs, from_rest) = from.as_chunks::<2>();
    let (to_pairs, to_rest) = to.as_chunks_mut::<2>();
    for (to, from) in to_pairs.iter_mut().zip(from_pairs) {
        let to = bytemuck::cast_slice_mut::<u16, u8>(to.as_flattened_mut());
        let from = bytemuck::cast_slice::<u16, u8>(from.as_flattened());
        let (to, from) = (to.as_chunks_mut::<4>().0, from.as_chunks::<4>().0);
        unrolled::<N>(
            #[inline(always)]
            |word| to[word] = from[word],
        );
        // Otherwise the compiler makes a call of it.
        compiler_fence(Ordering::SeqCst);
    }
    if let ([to], [from]) = (to_rest, from_rest) {
        unrolled::<N>(
            #[inline(always)]
            |channel| to[channel] = from[channel],
        );
        compiler_fence(Ordering::SeqCst);
    }
}

/// The nine inertial channels of a block: values and sums; `steps` are what the jacks go on with.
// SAFETY: no other symbol of the program has this name.
#[unsafe(export_name = "sample_inertial")]
#[inline(never)]
fn sample_inertial(
    prepared: &Prepared,
    analysers: &mut [Analyser; ANALYSERS],
    first_scan: u64,
    counts: &[[u16; INERTIAL]],
    values: &mut [Values],
    steps: &mut [Step; ANALYSERS],
) {
    let mut sums = [0; INERTIAL];
    prepared.block(counts, values, &mut sums);
    for (analyser, step) in analysers.iter_mut().zip(steps) {
        analyser.take_inertial(first_scan, &sums, step);
    }
}

/// The sample interrupt.
pub struct SampleInterrupt;

impl Handler<DMA1_CHANNEL1> for SampleInterrupt {
    unsafe fn on_interrupt() {
        let begun = DWT::cycle_count();
        PATH.lock(|path| {
            // Nobody else has it now; the panic that `borrow_mut` would end in is no part of the sample path.
            if let Ok(mut path) = path.try_borrow_mut() {
                path.interrupt(begun);
            }
        });
        SAMPLING_VECTOR.pend();
    }
}

/// Borrows the path between two blocks; interrupts are masked meanwhile, so be short.
#[inline(always)]
pub fn with<R>(work: impl FnOnce(&mut Path) -> R) -> R {
    PATH.lock(|path| work(&mut path.borrow_mut()))
}

/// Wakes whom the last block concerns, and notes times. Runs in the interrupt of the sampling task's executor.
pub fn announce() {
    let (due, failed) = with(|path| {
        path.note_times();
        (path.queue.is_due(), path.fault.is_some())
    });
    if due {
        LINK.wake();
    }
    if failed {
        SAMPLING.wake();
    }
}

/// Waits until a piece is due.
pub async fn block_waits() {
    wait(&LINK, |path| path.queue.is_due().then_some(())).await;
}

/// Waits for a fault of the run.
pub async fn fault() -> Fault {
    wait(&SAMPLING, |path| path.fault.take()).await
}

async fn wait<R>(waker: &AtomicWaker, mut look: impl FnMut(&mut Path) -> Option<R>) -> R {
    poll_fn(|context| {
        waker.register(context.waker());
        with(&mut look).map_or(Poll::Pending, Poll::Ready)
    })
    .await
}

/// Takes a fault that came when the run was over already.
pub fn take_fault() -> Option<Fault> {
    with(|path| path.fault.take())
}
