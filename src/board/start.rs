//! The start of the firmware, up to the point where the tasks run by themselves.

use cortex_m_rt::entry;
use defmt_rtt as _;
use embassy_executor::{Executor, InterruptExecutor};
use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::rcc;
use embassy_sync::zerocopy_channel;
use static_cell::{ConstStaticCell, StaticCell};

use super::exchange::{Exchange, Guard};
use super::identity::Origin;
use super::sampling::{Block, QUEUED};
use super::{clock, link, pins, pose, sampling, storage, supervisor, supply};

static SAMPLING: InterruptExecutor = InterruptExecutor::new();
static LINK: InterruptExecutor = InterruptExecutor::new();

#[embassy_stm32::interrupt]
unsafe fn I2C4_EV() {
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
    static EXCHANGE: ConstStaticCell<Exchange> = ConstStaticCell::new(Exchange::new());
    static BLOCKS: ConstStaticCell<[Block; QUEUED]> = ConstStaticCell::new([Block::EMPTY; QUEUED]);
    static QUEUE: StaticCell<zerocopy_channel::Channel<'static, Guard, Block>> = StaticCell::new();
    static BACKGROUND: StaticCell<Executor> = StaticCell::new();

    let (config, source) = clock::configuration();
    let mut chip = embassy_stm32::init(config);
    clock::check(rcc::clocks(&chip.RCC.reborrow()));
    let origin = Origin::take(source);
    defmt::info!("clock {}, last panic {}", source, origin.panic.as_deref());

    let exchange: &'static Exchange = EXCHANGE.take();
    let (blocks_in, blocks_out) = QUEUE
        .init(zerocopy_channel::Channel::new(BLOCKS.take()))
        .split();
    let board = origin.board;
    let parts = pins::assign(chip);

    pins::SAMPLING_VECTOR.set_priority(pins::SAMPLING_PRIORITY);
    pins::LINK_VECTOR.set_priority(pins::LINK_PRIORITY);
    // A task cannot be spawned twice, and each is spawned once here.
    let sampling = SAMPLING.start(pins::SAMPLING_VECTOR);
    sampling.spawn(sampling::sample(parts.acquisition, exchange, blocks_in).unwrap());
    let link = LINK.start(pins::LINK_VECTOR);
    link.spawn(link::talk(parts.serial, origin, exchange, blocks_out).unwrap());
    BACKGROUND.init(Executor::new()).run(|background| {
        background.spawn(storage::store(parts.flash, board, exchange).unwrap());
        background.spawn(pose::find(exchange).unwrap());
        background.spawn(supply::measure(parts.supply, exchange).unwrap());
        background.spawn(supervisor::supervise(parts.watchdog, exchange).unwrap());
    })
}
