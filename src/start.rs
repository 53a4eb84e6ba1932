//! The start of the firmware, up to the point where the tasks run by themselves.

use cortex_m_rt::entry;
use defmt_rtt as _;
use embassy_executor::{Executor, InterruptExecutor};
use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::rcc;
use static_cell::StaticCell;

use crate::chip::identity::Origin;
use crate::chip::{clock, option_bytes, pins};
use crate::health::{flash_errors, panic, resets, watchdog};
use crate::sampling::{path, supply, task};
use crate::shared::Shared;
use crate::{harmonics, link, pose, storage};

static SAMPLING: InterruptExecutor = InterruptExecutor::new();
static LINK: InterruptExecutor = InterruptExecutor::new();

#[embassy_stm32::interrupt]
unsafe fn I2C4_EV() {
    path::announce();
    // SAFETY: this is the vector that the executor is started on.
    unsafe { SAMPLING.on_interrupt() }
}

#[embassy_stm32::interrupt]
unsafe fn I2C4_ER() {
    // SAFETY: this is the vector that the executor is started on.
    unsafe { LINK.on_interrupt() }
}

#[entry]
fn main() -> ! {
    // Made while running: as a static that is ready made its image would take a kilobyte of flash.
    static SHARED: StaticCell<Shared> = StaticCell::new();
    static BACKGROUND: StaticCell<Executor> = StaticCell::new();

    let dog = watchdog::unleash();
    let message = panic::take();
    let (reset, counts, memory) = resets::take(message.is_some());
    let (config, source) = clock::configuration(reset);
    let mut chip = embassy_stm32::init(config);
    clock::check(rcc::clocks(&chip.RCC.reborrow()));
    clock::go_full_speed();
    if source == clock::Source::Crystal && !clock::watch_crystal() {
        resets::without_crystal();
    }
    let origin = Origin {
        board: embassy_stm32::uid::uid(),
        reset,
        resets: counts,
        clock: source,
        panic: message,
        options: option_bytes::read(),
    };
    defmt::info!("clock {}, last panic {}", source, origin.panic.as_deref());

    let shared: &'static Shared = SHARED.init_with(Shared::new);
    let (board, options) = (origin.board, origin.options);
    let parts = pins::assign(chip);

    count_cycles();
    flash_errors::watch();
    pins::SAMPLE_VECTOR.set_priority(pins::SAMPLE_PRIORITY);
    for vector in pins::DRIVER_VECTORS {
        vector.set_priority(pins::DRIVER_PRIORITY);
    }
    pins::SAMPLING_VECTOR.set_priority(pins::SAMPLING_PRIORITY);
    pins::LINK_VECTOR.set_priority(pins::LINK_PRIORITY);
    // A task cannot be spawned twice, and each is spawned once here.
    let sampling = SAMPLING.start(pins::SAMPLING_VECTOR);
    sampling.spawn(task::sample(parts.acquisition, shared).unwrap());
    let link = LINK.start(pins::LINK_VECTOR);
    link.spawn(link::talk(parts.serial, origin, shared).unwrap());
    BACKGROUND.init(Executor::new()).run(|background| {
        background
            .spawn(storage::store(parts.flash, parts.random, board, options, shared).unwrap());
        background.spawn(pose::find(shared).unwrap());
        background.spawn(harmonics::solve(shared).unwrap());
        background.spawn(supply::measure(parts.supply, shared).unwrap());
        background.spawn(watchdog::supervise(dog, memory, shared).unwrap());
    })
}

/// Starts the core's cycle counter, which stands still until debugging is enabled.
fn count_cycles() {
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
}
