//! The firmware: takes the chip's parts, gives them to the tasks, and starts those in order of urgency.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("the firmware runs on the board only: build it with `cargo firmware`");
    std::process::exit(1);
}

#[cfg(target_os = "none")]
mod start {
    use cortex_m_rt::entry;
    use defmt_rtt as _;
    use embassy_executor::{Executor, InterruptExecutor};
    use embassy_stm32::interrupt::{self, InterruptExt};
    use static_cell::StaticCell;

    use crate::board::{clock, panic, pins, sampling};

    static SAMPLING: InterruptExecutor = InterruptExecutor::new();

    #[embassy_stm32::interrupt]
    unsafe fn I2C4_EV() {
        // SAFETY: this is the vector that the executor is started on.
        unsafe { SAMPLING.on_interrupt() }
    }

    #[entry]
    fn main() -> ! {
        static BACKGROUND: StaticCell<Executor> = StaticCell::new();
        let (config, source) = clock::configuration();
        let chip = embassy_stm32::init(config);
        defmt::info!("clock {}, last panic {}", source, panic::take().as_deref());
        let parts = pins::assign(chip);
        pins::SAMPLING_VECTOR.set_priority(pins::SAMPLING_PRIORITY);
        let spawner = SAMPLING.start(pins::SAMPLING_VECTOR);
        spawner.spawn(sampling::sample(parts.acquisition).unwrap());
        BACKGROUND.init(Executor::new()).run(|_| {})
    }
}
