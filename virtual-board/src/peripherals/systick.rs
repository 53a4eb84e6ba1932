//! SysTick timer of the core (ARMv7-M B3.3): a 24-bit down-counter on the core clock or an eighth of it.

use super::{Cycles, NEVER, NO_SUCH_REGISTER, Read, Write, bit};

const ENABLE: u32 = 0;
const TICKINT: u32 = 1;
const CLKSOURCE: u32 = 2;

/// The timer.
#[derive(Debug, Default)]
pub struct SysTick {
    csr: u32,
    reload: u32,
    count_flag: bool,
    /// When the counter next reaches zero; valid while it runs.
    zero_at: Cycles,
    held: u32,
    pends: bool,
}

impl SysTick {
    /// Reads a register.
    pub fn read(&mut self, offset: u32, now: Cycles) -> Read {
        Ok(match offset {
            0x00 => self.csr | u32::from(std::mem::take(&mut self.count_flag)) << 16,
            0x04 => self.reload,
            0x08 => self.count(now),
            // No reference clock apart from the core's, no calibration for 10 ms.
            0x0C => 0x4000_0000,
            _ => return Err(NO_SUCH_REGISTER),
        })
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, now: Cycles) -> Write {
        match offset {
            0x00 => {
                let was_running = self.running();
                self.held = self.count(now);
                self.csr = value & 7;
                if self.running() {
                    let from = if was_running || self.held != 0 {
                        self.held
                    } else {
                        self.reload + 1
                    };
                    self.zero_at = now + u64::from(from) * self.tick();
                }
            }
            0x04 => self.reload = value & 0x00FF_FFFF,
            0x08 => {
                self.held = 0;
                self.count_flag = false;
                self.zero_at = now + (u64::from(self.reload) + 1) * self.tick();
            }
            _ => return Err(NO_SUCH_REGISTER),
        }
        Ok(())
    }

    /// Collects a tick: whether the exception became pending since the last call.
    pub fn take_tick(&mut self) -> bool {
        std::mem::take(&mut self.pends)
    }

    /// When [`Self::advance`] must be called next.
    pub fn next_event(&self) -> Cycles {
        if self.running() { self.zero_at } else { NEVER }
    }

    /// Carries out what happens up to `now`.
    pub fn advance(&mut self, now: Cycles) {
        while self.running() && self.zero_at <= now {
            self.count_flag = true;
            self.pends |= bit(self.csr, TICKINT);
            self.zero_at += (u64::from(self.reload) + 1) * self.tick();
        }
    }

    fn running(&self) -> bool {
        bit(self.csr, ENABLE) && self.reload > 0
    }

    fn tick(&self) -> u64 {
        if bit(self.csr, CLKSOURCE) { 1 } else { 8 }
    }

    fn count(&self, now: Cycles) -> u32 {
        if self.running() {
            (self.zero_at.saturating_sub(now) / self.tick()) as u32 & 0x00FF_FFFF
        } else {
            self.held
        }
    }
}
