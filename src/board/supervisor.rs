//! The watchdog, fed only when every part of the board makes progress.
//!
//! Sample path, link and storage each report that they took a turn. The watchdog is fed after all three have done
//! so; if one stops, it bites, and the board starts again with [`ResetCause::Watchdog`].
//!
//! [`ResetCause::Watchdog`]: hexsense::wire::status::ResetCause::Watchdog

use embassy_futures::join::join3;
use embassy_stm32::Peri;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::Timer;

use super::exchange::Exchange;
use super::timing::{SUPERVISOR_PERIOD, WATCHDOG_US};

/// Starts the watchdog and feeds it for ever, as long as it is earned.
#[embassy_executor::task]
pub async fn supervise(watchdog: Peri<'static, IWDG>, exchange: &'static Exchange) -> ! {
    let mut watchdog = IndependentWatchdog::new(watchdog, WATCHDOG_US);
    watchdog.unleash();
    let alive = &exchange.alive;
    loop {
        join3(
            alive.sampling.wait(),
            alive.link.wait(),
            alive.storage.wait(),
        )
        .await;
        watchdog.pet();
        Timer::after(SUPERVISOR_PERIOD).await;
    }
}
