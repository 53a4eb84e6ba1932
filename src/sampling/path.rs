//! The sample interrupt: takes the filled halves of the rings through the portable sample path
//! ([`hexsense_core::sample_path`]), in the interrupt of the converter that ends last.
//!
//! | symbol | what it is |
//! |---|---|
//! | `DMA1_CHANNEL1` | the sample interrupt, first instruction to last |
//! | `sample_path` | everything that is done with a block |
//! | `hexsense_core::…::sample_inertial` | the nine inertial channels: calibrated values, sums, analysers |
//! | `hexsense_core::…::Prepared::block` | values and sums of the block |
//! | `hexsense_core::…::Analyser::take_inertial` | the sums of one analyser, nine channels |
//! | `hexsense_core::…::add_up`, `Sums<6>::add` | the same for the jacks |
//!
//! Every block takes the same instructions. The interrupt wakes no task by itself: it pends the interrupt of the sampling
//! task's executor, which runs later and calls [`announce`].
//!
//! The state is one cell. The sample interrupt borrows it for a block; other tasks borrow it between two blocks, with
//! interrupts masked and for 20 µs at most, which `cargo xtask timing` checks for all of the firmware. So a command takes
//! effect between blocks, whole. What takes longer, such as making a frame, works on a copy.
//!
//! Core cycles are taken from the counter of DWT, at the begin of the interrupt and when all is done.

use core::cell::RefCell;
use core::future::poll_fn;
use core::task::Poll;

use cortex_m::peripheral::DWT;
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::InterruptExt;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::waitqueue::AtomicWaker;
use embassy_time::Instant;
use hexsense::FACTS;
use hexsense_core::sample_path::Path;
use hexsense_core::sampling::BlockSize;

use super::acquisition::{Fault, Filled};
use crate::chip::pins::SAMPLING_VECTOR;
use crate::shared::Guard;

static STATE: Mutex<Guard, RefCell<State>> = Mutex::new(RefCell::new(State::new()));
/// The link, when it waits for a block.
static LINK: AtomicWaker = AtomicWaker::new();
/// The sampling task, when it waits for a fault.
static SAMPLING: AtomicWaker = AtomicWaker::new();

/// The sample path and its run.
struct State {
    path: Path,
    running: bool,
    /// Why the run ended, until the sampling task takes it.
    fault: Option<Fault>,
}

impl State {
    /// All zero, so that it takes no flash.
    const fn new() -> Self {
        Self {
            path: Path::new(),
            running: false,
            fault: None,
        }
    }

    /// Takes the block whose interrupt this is, which began at cycle `begun`.
    #[inline(always)]
    fn interrupt(&mut self, begun: u32) {
        let block = self.path.progress.block;
        let Some(filled) = Filled::take(block).filter(|_| self.running) else {
            return;
        };
        let done = filled.and_then(|filled| {
            sample(&mut self.path, &filled);
            filled.is_whole().then_some(()).ok_or(Fault::Late)
        });
        match done {
            Ok(()) => self.path.finish(|| DWT::cycle_count().wrapping_sub(begun)),
            Err(fault) => {
                self.running = false;
                self.fault = Some(fault);
            }
        }
    }
}

// SAFETY: no other symbol of the program has this name.
#[unsafe(export_name = "sample_path")]
#[inline(never)]
fn sample(path: &mut Path, filled: &Filled) {
    path.sample(filled.inertial, filled.jacks);
}

#[interrupt]
unsafe fn DMA1_CHANNEL1() {
    let begun = DWT::cycle_count();
    STATE.lock(|state| {
        // Nothing else has it now; the panic that `borrow_mut` would end in is no part of the sample path.
        if let Ok(mut state) = state.try_borrow_mut() {
            state.interrupt(begun);
        }
    });
    SAMPLING_VECTOR.pend();
}

#[inline(always)]
fn with_state<R>(work: impl FnOnce(&mut State) -> R) -> R {
    STATE.lock(|state| work(&mut state.borrow_mut()))
}

/// Borrows the path between two blocks; interrupts are masked meanwhile, so be short.
#[inline(always)]
pub fn with<R>(work: impl FnOnce(&mut Path) -> R) -> R {
    with_state(|state| work(&mut state.path))
}

/// Begins a run after `lost` scans that were not taken; the analysers stop.
pub fn begin(rate_hz: u32, block: BlockSize, lost: u64) {
    with_state(|state| {
        state.path.begin(&FACTS, rate_hz, block, lost);
        state.running = true;
    });
}

/// Ends the run: blocks that still come are passed over.
pub fn end() {
    with_state(|state| state.running = false);
}

/// Wakes the tasks that the last block concerns, and notes times. Runs in the interrupt of the sampling task's executor.
pub fn announce() {
    let uptime_ms = Instant::now().as_millis();
    let (due, failed) = with_state(|state| {
        state.path.note_times(uptime_ms);
        (state.path.queue.is_due(), state.fault.is_some())
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
    wait(&LINK, |state| state.path.queue.is_due().then_some(())).await;
}

/// Waits for a fault of the run.
pub async fn fault() -> Fault {
    wait(&SAMPLING, |state| state.fault.take()).await
}

async fn wait<R>(waker: &AtomicWaker, mut look: impl FnMut(&mut State) -> Option<R>) -> R {
    poll_fn(|context| {
        waker.register(context.waker());
        with_state(&mut look).map_or(Poll::Pending, Poll::Ready)
    })
    .await
}

/// Takes a fault that came when the run was over already.
pub fn take_fault() -> Option<Fault> {
    with_state(|state| state.fault.take())
}
