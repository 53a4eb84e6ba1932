//! Debug blocks that firmware may use: DWT's cycle counter (ARMv7-M C1.8), DEMCR, and DBGMCU (RM0440 chapter 47).
//!
//! CYCCNT counts core cycles, but not while the core sleeps, unless DBGMCU_CR.DBG_SLEEP keeps the clock on.

use super::{Cycles, NO_SUCH_REGISTER, Read, Write, bit};

/// Device and revision of DBGMCU_IDCODE: STM32G47x/G48x, revision Y.
const IDCODE: u32 = 0x2003_6469;
/// DWT_CTRL: four comparators, cycle counter present.
const DWT_CONFIGURATION: u32 = 0x4000_0000;
const TRCENA: u32 = 24;
const DBG_SLEEP: u32 = 0;
/// Register DBGMCU_APB1FZR1 and its bit DBG_IWDG_STOP.
const APB1FZR1: usize = 0x08 / 4;
const DBG_IWDG_STOP: u32 = 12;

/// The debug blocks.
#[derive(Debug, Default)]
pub struct Debug {
    demcr: u32,
    dbgmcu: [u32; 6],
    counting: bool,
    /// CYCCNT is this plus the cycles since `counted_from`.
    counted: u32,
    counted_from: Cycles,
}

impl Debug {
    /// Reads a DWT register.
    pub fn read_dwt(&self, offset: u32, now: Cycles) -> Read {
        match offset {
            0x00 => Ok(DWT_CONFIGURATION | u32::from(self.counting)),
            0x04 => Ok(self.cycle_count(now)),
            0x08..=0x18 => Ok(0),
            _ => Err(NO_SUCH_REGISTER),
        }
    }

    /// Writes a DWT register.
    pub fn write_dwt(&mut self, offset: u32, value: u32, now: Cycles) -> Write {
        match offset {
            0x00 => {
                self.counted = self.cycle_count(now);
                self.counted_from = now;
                self.counting = bit(value, 0) && bit(self.demcr, TRCENA);
                Ok(())
            }
            0x04 => {
                self.counted = value;
                self.counted_from = now;
                Ok(())
            }
            0xFB0 => Ok(()), // lock access: nothing to unlock on this core
            _ => Err(NO_SUCH_REGISTER),
        }
    }

    /// The core slept for `duration` cycles: its cycle counter did not see them, unless debugging in sleep is on.
    pub fn slept(&mut self, duration: Cycles) {
        if self.counting && !bit(self.dbgmcu[1], DBG_SLEEP) {
            self.counted = self.counted.wrapping_sub(duration as u32);
        }
    }

    /// Whether the watchdog stands still while a debugger halts the core.
    pub fn watchdog_stops_in_halt(&self) -> bool {
        bit(self.dbgmcu[APB1FZR1], DBG_IWDG_STOP)
    }

    /// DEMCR.
    pub fn demcr(&self) -> u32 {
        self.demcr
    }

    /// Writes DEMCR; without TRCENA the cycle counter stands still.
    pub fn write_demcr(&mut self, value: u32, now: Cycles) {
        self.demcr = value;
        if !bit(value, TRCENA) {
            self.counted = self.cycle_count(now);
            self.counting = false;
        }
    }

    /// Reads a DBGMCU register.
    pub fn read_dbgmcu(&self, offset: u32) -> Read {
        match offset {
            0x00 => Ok(IDCODE),
            _ => self
                .dbgmcu
                .get(offset as usize / 4)
                .copied()
                .ok_or(NO_SUCH_REGISTER),
        }
    }

    /// Writes a DBGMCU register.
    pub fn write_dbgmcu(&mut self, offset: u32, value: u32) -> Write {
        *self
            .dbgmcu
            .get_mut(offset as usize / 4)
            .ok_or(NO_SUCH_REGISTER)? = value;
        Ok(())
    }

    fn cycle_count(&self, now: Cycles) -> u32 {
        if self.counting {
            self.counted.wrapping_add((now - self.counted_from) as u32)
        } else {
            self.counted
        }
    }
}
