//! Independent watchdog (RM0440 chapter 42): a down-counter on the 32 kHz oscillator that resets the chip at zero.
//!
//! ```text
//! timeout = (RLR + 1) · 4 · 2^PR / f_LSI
//! ```
//!
//! Only a reset stops it once it has started.

use super::{Cycles, NEVER, NO_SUCH_REGISTER, Read, Write};

/// Frequency of the low-speed internal oscillator, Hz (data sheet: 32 kHz ± 5 %; the model has the typical value).
pub const LSI_HZ: f64 = 32_000.0;
/// A written prescaler or reload value needs up to five cycles of the oscillator to arrive.
const UPDATE_LSI_CYCLES: f64 = 5.0;

/// The watchdog.
#[derive(Debug)]
pub struct Iwdg {
    core_hz: f64,
    unlocked: bool,
    prescaler: u32,
    reload: u32,
    window: u32,
    updating_until: Cycles,
    updating: u32,
    /// When the counter reaches zero; [`NEVER`] before the watchdog was started.
    bites_at: Cycles,
    bitten: bool,
}

impl Iwdg {
    /// The watchdog after reset: stopped.
    pub fn new(core_hz: f64) -> Self {
        Self {
            core_hz,
            unlocked: false,
            prescaler: 0,
            reload: 0xFFF,
            window: 0xFFF,
            updating_until: 0,
            updating: 0,
            bites_at: NEVER,
            bitten: false,
        }
    }

    /// Sets the frequency of the core; the remaining time stays the same.
    pub fn set_core_clock(&mut self, core_hz: f64, now: Cycles) {
        if self.bites_at != NEVER {
            let left = self.bites_at.saturating_sub(now) as f64;
            self.bites_at = now + (left * core_hz / self.core_hz) as u64;
        }
        self.core_hz = core_hz;
    }

    /// A debugger that halts the core stops the counter for so long, if the firmware has asked for that (DBGMCU).
    pub fn stand_still(&mut self, duration: Cycles) {
        if self.running() {
            self.bites_at += duration;
        }
    }

    /// Reads a register.
    pub fn read(&mut self, offset: u32, now: Cycles) -> Read {
        Ok(match offset {
            0x00 => 0,
            0x04 => self.prescaler,
            0x08 => self.reload,
            0x0C if now < self.updating_until => self.updating,
            0x0C => 0,
            0x10 => self.window,
            _ => return Err(NO_SUCH_REGISTER),
        })
    }

    /// Writes a register. Prescaler, reload and window are protected until the key 0x5555 was written.
    pub fn write(&mut self, offset: u32, value: u32, now: Cycles) -> Write {
        match offset {
            0x00 => self.key(value & 0xFFFF, now),
            0x04 | 0x08 | 0x10 if !self.unlocked => {}
            0x04 => {
                self.prescaler = value & 7;
                self.begin_update(1, now);
            }
            0x08 => {
                self.reload = value & 0xFFF;
                self.begin_update(2, now);
            }
            0x10 => {
                self.window = value & 0xFFF;
                self.begin_update(4, now);
                self.refresh(now);
            }
            _ => return Err(NO_SUCH_REGISTER),
        }
        Ok(())
    }

    /// The instant of the reset, unless the watchdog is refreshed.
    pub fn next_event(&self) -> Cycles {
        self.bites_at
    }

    /// Whether the chip must be reset at `now`.
    pub fn bites(&self, now: Cycles) -> bool {
        self.bitten || now >= self.bites_at
    }

    /// Whether the watchdog was started.
    pub fn running(&self) -> bool {
        self.bites_at != NEVER
    }

    fn key(&mut self, key: u32, now: Cycles) {
        self.unlocked = key == 0x5555;
        match key {
            0xCCCC => self.refresh(now),
            0xAAAA if self.running() => {
                self.bitten |= self.counter(now) > self.window;
                self.refresh(now);
            }
            _ => {}
        }
    }

    fn begin_update(&mut self, flag: u32, now: Cycles) {
        if now >= self.updating_until {
            self.updating = 0;
        }
        self.updating |= flag;
        self.updating_until = now + self.lsi_cycles(UPDATE_LSI_CYCLES);
    }

    fn refresh(&mut self, now: Cycles) {
        self.bites_at = now + self.lsi_cycles(f64::from(self.reload + 1) * self.divider());
    }

    /// The divider saturates at 256 (PR = 6 and 7).
    fn divider(&self) -> f64 {
        f64::from(4u32 << self.prescaler.min(6))
    }

    fn counter(&self, now: Cycles) -> u32 {
        let left = self.bites_at.saturating_sub(now) as f64;
        (left / self.core_hz * LSI_HZ / self.divider()) as u32
    }

    fn lsi_cycles(&self, count: f64) -> Cycles {
        (count / LSI_HZ * self.core_hz) as Cycles
    }
}
