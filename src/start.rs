//! The start of the firmware, up to the point where the tasks run by themselves.

use cortex_m_rt::entry;
use defmt_rtt as _;
use embassy_executor::{Executor, InterruptExecutor};
use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::rcc;
use static_cell::StaticCell;

use super::exchange::Exchange;
use super::identity::Origin;
use super::{clock, ecc, harmonics, link, path, pins, pose, sampling, storage, supervisor, supply};

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
    static EXCHANGE: StaticCell<Exchange> = StaticCell::new();
    static BACKGROUND: StaticCell<Executor> = StaticCell::new();

    let watchdog = supervisor::unleash();
    let (config, source) = clock::configuration();
    let mut chip = embassy_stm32::init(config);
    clock::check(rcc::clocks(&chip.RCC.reborrow()));
    let (origin, memory) = Origin::take(source);
    defmt::info!("clock {}, last panic {}", source, origin.panic.as_deref());

    let exchange: &'static Exchange = EXCHANGE.init_with(Exchange::new);
    let board = origin.board;
    let parts = pins::assign(chip);

    count_cycles();
    ecc::watch();
    pins::SAMPLE_VECTOR.set_priority(pins::SAMPLE_PRIORITY);
    for vector in pins::DRIVER_VECTORS {
        vector.set_priority(pins::DRIVER_PRIORITY);
    }
    pins::SAMPLING_VECTOR.set_priority(pins::SAMPLING_PRIORITY);
    pins::LINK_VECTOR.set_priority(pins::LINK_PRIORITY);
    // A task cannot be spawned twice, and each is spawned once here.
    let sampling = SAMPLING.start(pins::SAMPLING_VECTOR);
    sampling.spawn(sampling::sample(parts.acquisition, exchange).unwrap());
    let link = LINK.start(pins::LINK_VECTOR);
    link.spawn(link::talk(parts.serial, origin, exchange).unwrap());
    BACKGROUND.init(Executor::new()).run(|background| {
        background.spawn(storage::store(parts.flash, parts.random, board, exchange).unwrap());
        background.spawn(pose::find(exchange).unwrap());
        background.spawn(harmonics::solve(exchange).unwrap());
        background.spawn(supply::measure(parts.supply, exchange).unwrap());
        background.spawn(supervisor::supervise(watchdog, memory, exchange).unwrap());
    })
}

/// Starts the core's cycle counter, which stands still until debugging is enabled.
fn count_cycles() {
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
}
