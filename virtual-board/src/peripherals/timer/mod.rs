//! Timers: TIM2 to TIM7 and TIM15 to TIM17 as up-counters (RM0440 chapters 28 to 31).
//!
//! The counter does not tick; it is computed from the instant at which it last was zero:
//!
//! ```text
//! CNT = (now − origin) / tick      tick = cycles of the core per timer clock × (PSC + 1)
//! update event at origin + (ARR + 1) · tick
//! ```
//!
//! PSC always, and ARR with ARPE, are preloaded: a write takes effect at the next update event (RM0440 29.3.1).
//! Modelled: update and compare flags with their interrupts, one-pulse mode, UG, trigger output on reset, enable and
//! update. Not modelled: down-counting, capture, outputs on pins, slave modes, DMA requests.

mod registers;

use super::{Cycles, NEVER, bit, field};

const CEN: u32 = 1 << 0;
const UDIS: u32 = 1 << 1;
const OPM: u32 = 1 << 3;
const UIF: u32 = 1 << 0;

/// The features of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Width of the counter in bits: 16 or 32.
    pub bits: u32,
    /// Compare channels: 0 (basic timers), 1, 2 or 4.
    pub channels: usize,
}

impl Shape {
    /// TIM6 and TIM7.
    pub const BASIC: Self = Self::new(16, 0);
    /// TIM16 and TIM17.
    pub const ONE_CHANNEL: Self = Self::new(16, 1);
    /// TIM15.
    pub const TWO_CHANNELS: Self = Self::new(16, 2);
    /// TIM3 and TIM4.
    pub const GENERAL_16: Self = Self::new(16, 4);
    /// TIM2 and TIM5.
    pub const GENERAL_32: Self = Self::new(32, 4);

    const fn new(bits: u32, channels: usize) -> Self {
        Self { bits, channels }
    }
}

/// One timer.
#[derive(Debug)]
pub struct Timer {
    shape: Shape,
    cycles_per_clock: u64,
    cr1: u32,
    cr2: u32,
    dier: u32,
    sr: u32,
    ccmr: [u32; 2],
    ccer: u32,
    ccr: [u32; 4],
    psc: u32,
    psc_active: u32,
    arr: u32,
    arr_active: u32,
    /// When the counter was zero; valid while it runs.
    origin: Cycles,
    /// The counter's value while it stands still.
    held: u32,
    /// Instant up to which compare matches have been noticed.
    seen: Cycles,
    /// A trigger pulse that has not been collected.
    trigger: bool,
    /// Times that the counter was started since power-on.
    starts: u32,
}

impl Timer {
    /// A timer after reset.
    pub fn new(shape: Shape) -> Self {
        let full = Self::mask(shape);
        Self {
            shape,
            cycles_per_clock: 1,
            cr1: 0,
            cr2: 0,
            dier: 0,
            sr: 0,
            ccmr: [0; 2],
            ccer: 0,
            ccr: [0; 4],
            psc: 0,
            psc_active: 0,
            arr: full,
            arr_active: full,
            origin: 0,
            held: 0,
            seen: 0,
            trigger: false,
            starts: 0,
        }
    }

    /// Back to the state after reset; the clock stays.
    pub fn reset(&mut self) {
        *self = Self {
            cycles_per_clock: self.cycles_per_clock,
            starts: self.starts,
            ..Self::new(self.shape)
        };
    }

    /// Sets how many core cycles one clock of the timer lasts. A running counter keeps its value.
    pub fn set_clock(&mut self, cycles_per_clock: u64, now: Cycles) {
        if self.running() {
            self.advance(now);
            let count = self.count(now);
            self.cycles_per_clock = cycles_per_clock;
            self.origin = now.saturating_sub(u64::from(count) * self.tick());
        } else {
            self.cycles_per_clock = cycles_per_clock;
        }
    }

    /// Times that the counter was started since power-on.
    pub fn starts(&self) -> u32 {
        self.starts
    }

    /// Collects a trigger pulse (TRGO) that was sent since the last call.
    pub fn take_trigger(&mut self) -> bool {
        std::mem::take(&mut self.trigger)
    }

    /// When [`Self::advance`] must be called next: at every event with an effect outside of the timer.
    pub fn next_event(&self) -> Cycles {
        if !self.running() {
            return NEVER;
        }
        let update_matters = bit(self.dier, 0) || self.trigger_mode() == 2 || self.cr1 & OPM != 0;
        let update = if update_matters {
            self.next_update()
        } else {
            NEVER
        };
        (0..self.shape.channels)
            .filter(|&channel| bit(self.dier, channel as u32 + 1))
            .map(|channel| self.next_match(channel))
            .fold(update, Cycles::min)
    }

    /// Carries out all events up to and including `now`.
    pub fn advance(&mut self, now: Cycles) {
        while self.running() && self.next_update() <= now {
            let at = self.next_update();
            self.note_matches(at - 1);
            self.origin = at;
            self.seen = at - 1;
            if self.cr1 & OPM != 0 {
                self.cr1 &= !CEN;
                self.held = 0;
            }
            self.update(true);
        }
        self.note_matches(now);
    }

    fn mask(shape: Shape) -> u32 {
        if shape.bits == 32 {
            u32::MAX
        } else {
            (1 << shape.bits) - 1
        }
    }

    /// The counter stands still while ARR is zero (RM0440 29.4.8).
    fn running(&self) -> bool {
        self.cr1 & CEN != 0 && self.arr_active != 0
    }

    fn trigger_mode(&self) -> u32 {
        field(self.cr2, 4, 3)
    }

    fn tick(&self) -> u64 {
        self.cycles_per_clock * (u64::from(self.psc_active) + 1)
    }

    fn count(&self, now: Cycles) -> u32 {
        if self.running() {
            (now.saturating_sub(self.origin) / self.tick()) as u32 & Self::mask(self.shape)
        } else {
            self.held
        }
    }

    /// The counter wraps after ARR, or after its full range if ARR was lowered beneath it.
    fn next_update(&self) -> Cycles {
        let after_arr = self.origin + (u64::from(self.arr_active) + 1) * self.tick();
        if after_arr > self.seen {
            after_arr
        } else {
            self.origin + (u64::from(Self::mask(self.shape)) + 1) * self.tick()
        }
    }

    /// When the counter next comes to equal the channel's compare value.
    fn next_match(&self, channel: usize) -> Cycles {
        let value = u64::from(self.ccr[channel]);
        if value > u64::from(self.arr_active) {
            return NEVER;
        }
        let this_period = self.origin + value * self.tick();
        if this_period > self.seen {
            this_period
        } else {
            self.next_update() + value * self.tick()
        }
    }

    fn note_matches(&mut self, now: Cycles) {
        if self.running() {
            for channel in 0..self.shape.channels {
                let at = self.origin + u64::from(self.ccr[channel]) * self.tick();
                if self.ccr[channel] <= self.arr_active && at > self.seen && at <= now {
                    self.sr |= 2 << channel;
                }
            }
        }
        self.seen = now;
    }

    fn update(&mut self, sets_flag: bool) {
        if self.cr1 & UDIS != 0 {
            return;
        }
        self.psc_active = self.psc;
        self.arr_active = self.arr;
        if sets_flag {
            self.sr |= UIF;
        }
        if self.trigger_mode() == 2 {
            self.trigger = true;
        }
    }

    fn set_count(&mut self, value: u32, now: Cycles) {
        self.held = value & Self::mask(self.shape);
        self.restart_at(self.held, now);
    }

    fn restart_at(&mut self, count: u32, now: Cycles) {
        let elapsed = u64::from(count) * self.tick();
        // A counter that is set forward early after power-on would have been zero before time began.
        self.origin = now.saturating_sub(elapsed);
        self.seen = now;
    }
}
