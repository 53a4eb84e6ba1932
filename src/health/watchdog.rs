//! The watchdog, fed only when every part of the board makes progress.
//!
//! Every task but this one reports its turns, and waits for nothing much longer than a tenth of a second without a report.
//! The watchdog is fed after all have reported; if one stops, it bites, and the board starts again with
//! [`ResetCause::Watchdog`]. It starts before the clock, so that no start can hang for good. It stands still while a
//! debugger halts the core.
//!
//! [`ResetCause::Watchdog`]: hexsense_core::wire::status::ResetCause::Watchdog

use embassy_stm32::pac;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::{Instant, Timer};

use super::resets::Memory;
use crate::chip::timing::{SUPERVISOR_LOOK, SUPERVISOR_PERIOD, WATCHDOG_US};
use crate::shared::Shared;

/// Starts the watchdog.
pub fn unleash() -> IndependentWatchdog<'static, IWDG> {
    pac::DBGMCU
        .apb1lfzr()
        .modify(|freeze| freeze.set_iwdg(true));
    // SAFETY: called once, at the start, and no other code asks for the watchdog.
    let mut watchdog = IndependentWatchdog::new(unsafe { IWDG::steal() }, WATCHDOG_US);
    watchdog.unleash();
    watchdog
}

/// Feeds the watchdog whenever all tasks have reported.
#[embassy_executor::task]
pub async fn supervise(
    mut watchdog: IndependentWatchdog<'static, IWDG>,
    mut memory: Memory,
    shared: &'static Shared,
) -> ! {
    loop {
        while !shared.alive.all() {
            Timer::after(SUPERVISOR_LOOK).await;
        }
        watchdog.pet();
        memory.keep_uptime(Instant::now().as_millis());
        Timer::after(SUPERVISOR_PERIOD).await;
    }
}
