//! The sampling clock: TIM6, whose update event starts both converters in hardware.

use embassy_stm32::Peri;
use embassy_stm32::pac;
use embassy_stm32::peripherals::TIM6;
use embassy_stm32::timer::low_level::{MasterMode, Timer};

use hexsense::{CORE_HZ, RANK_TICKS, TRIGGER_PRESCALER, trigger_ticks};
use hexsense_core::channel::INERTIAL;

use super::timing::FIRST_TRIGGER_US;

/// TIM6 as a trigger; stopped when dropped.
pub struct Trigger<'d>(Timer<'d, TIM6>);

impl<'d> Trigger<'d> {
    /// Sets the timer up for `rate_hz`, one of those in [`hexsense::FACTS`], and leaves it stopped.
    pub fn new(timer: Peri<'d, TIM6>, rate_hz: u32) -> Self {
        let timer = Timer::new(timer);
        let regs = timer.regs_basic();
        regs.psc().write_value((TRIGGER_PRESCALER - 1) as u16);
        regs.arr()
            .write(|arr| arr.set_arr((trigger_ticks(rate_hz) - 1) as u16));
        // Loads prescaler and period, while the converters do not listen yet.
        timer.generate_update_event();
        let first = CORE_HZ / 1_000_000 * FIRST_TRIGGER_US / TRIGGER_PRESCALER;
        regs.cnt()
            .write(|count| count.set_cnt((trigger_ticks(rate_hz) - first) as u16));
        regs.cr2().modify(|cr2| cr2.set_mms(MasterMode::UPDATE));
        Self(timer)
    }

    /// Starts the clock: the first trigger comes [`FIRST_TRIGGER_US`] later.
    pub fn start(&self) {
        self.0.start();
    }
}

/// Whether a scan is under way at this moment, beyond its first rank.
#[inline(always)]
pub fn is_amid_scan() -> bool {
    let ticks = u32::from(pac::TIM6.cnt().read().cnt());
    (RANK_TICKS..RANK_TICKS * INERTIAL as u32).contains(&ticks)
}

impl Drop for Trigger<'_> {
    fn drop(&mut self) {
        self.0.stop();
    }
}
