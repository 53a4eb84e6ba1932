//! The effects of a change of the clock tree.

use super::Bus;
use super::map::TIMERS;
use crate::peripherals::rcc::Clocks;

impl Bus {
    /// Applies the clock tree if it has changed.
    pub(super) fn change_clocks(&mut self) {
        let clocks = self.rcc.clocks();
        if clocks != self.clocks {
            self.check_step(clocks);
            self.apply_clocks(clocks);
        }
    }

    /// Above 80 MHz the bus must run at half the system clock for a microsecond after the switch (RM0440 7.2.7).
    fn check_step(&mut self, to: Clocks) {
        const SLOW_HZ: u32 = 80_000_000;
        const WAIT_S: f64 = 1e-6;
        let from = self.clocks;
        let now_s = self.now_s();
        if to.system != from.system {
            self.switched_s = now_s;
        }
        let too_soon = now_s - self.switched_s < WAIT_S;
        if from.hclk <= SLOW_HZ && to.hclk > SLOW_HZ && too_soon {
            let detail = format!(
                "from {} to {} Hz, without half of it for 1 µs",
                from.hclk, to.hclk
            );
            self.remarks
                .state(now_s, "the core's clock rises in one step", &detail);
        }
    }

    /// Tells every peripheral the present clock tree.
    pub(super) fn apply_clocks(&mut self, clocks: Clocks) {
        let now = self.now;
        self.clocks = clocks;
        self.clock_changed = true;
        self.timebase.change(now, clocks.hclk, clocks.source);
        let core_hz = self.timebase.core_hz();
        self.rcc.set_core_clock(core_hz);
        self.iwdg.set_core_clock(core_hz, now);
        self.flash.set_core_clock(core_hz);
        self.rng.set_core_clock(u64::from(clocks.hclk));
        self.lpuart.set_clock(clocks.lpuart1, clocks.hclk);
        for (timer, place) in self.timers.iter_mut().zip(&TIMERS) {
            let clock = if place.base < 0x4001_0000 {
                clocks.apb1_timers
            } else {
                clocks.apb2_timers
            };
            timer.set_clock(u64::from((clocks.hclk / clock.max(1)).max(1)), now);
        }
        self.set_converter_clocks();
        self.refresh_all();
        self.check_limits();
    }

    pub(super) fn set_converter_clocks(&mut self) {
        let clocks = self.clocks;
        for (index, adc) in self.adc.iter_mut().enumerate() {
            let (common, kernel) = if index < 2 {
                (&self.adc_common[0], clocks.adc12)
            } else {
                (&self.adc_common[1], clocks.adc345)
            };
            adc.set_clock(common.clock(kernel, clocks.hclk), clocks.hclk);
        }
    }

    /// A chip outside of its limits may do anything; the model goes on and reports it.
    pub(super) fn check_limits(&mut self) {
        let hclk = self.clocks.hclk;
        let now_s = self.now_s();
        let limit = self.pwr.max_core_hz();
        if hclk > limit {
            let detail = format!("{hclk} Hz, but the voltage range of PWR_CR5 allows {limit} Hz");
            self.remarks.state(now_s, "the core is too fast", &detail);
        }
        let per_wait_state = if limit == 150_000_000 {
            30_000_000
        } else {
            34_000_000
        };
        let needed = hclk.div_ceil(per_wait_state).saturating_sub(1);
        if self.flash.wait_states() < needed {
            let detail = format!(
                "{} are set, {hclk} Hz need {needed}",
                self.flash.wait_states()
            );
            self.remarks
                .state(now_s, "too few wait states of the flash memory", &detail);
        }
    }
}
