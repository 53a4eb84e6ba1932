//! Power control (RM0440 chapter 6), as far as the core voltage range goes.
//!
//! The regulator settles at once. Low-power modes other than sleep are not modelled.

use super::{NO_SUCH_REGISTER, Read, Unmodelled, Write, bit, field};

const REGISTERS: usize = 0x84 / 4;
const CR1: usize = 0;
const CR3: usize = 2;
const CR5: usize = 0x80 / 4;
const R1MODE: u32 = 8;

/// The power controller.
#[derive(Debug)]
pub struct Pwr {
    registers: [u32; REGISTERS],
}

impl Default for Pwr {
    fn default() -> Self {
        let mut registers = [0; REGISTERS];
        registers[CR1] = 0x0000_0200; // range 1
        registers[CR3] = 0x0000_8000;
        registers[CR5] = 1 << R1MODE; // normal mode, not boost
        Self { registers }
    }
}

impl Pwr {
    /// Reads a register.
    pub fn read(&self, offset: u32) -> Read {
        match offset {
            0x10 | 0x14 => Ok(0), // no wake-up flags; regulator ready, voltages above their thresholds
            0x00..=0x0C | 0x18..=0x5C | 0x80 => Ok(self.registers[offset as usize / 4]),
            _ => Err(NO_SUCH_REGISTER),
        }
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32) -> Write {
        match offset {
            0x18 => {}
            0x00..=0x0C | 0x20..=0x5C | 0x80 => self.registers[offset as usize / 4] = value,
            _ => return Err(NO_SUCH_REGISTER),
        }
        match offset {
            0x00 if bit(value, 14) => Err(Unmodelled("low-power run")),
            0x00 if field(value, 9, 2) != 1 => Err(Unmodelled("voltage range 2")),
            _ => Ok(()),
        }
    }

    /// The fastest core clock that the regulator's range allows, Hz (RM0440 6.1.5).
    pub fn max_core_hz(&self) -> u32 {
        if bit(self.registers[CR5], R1MODE) {
            150_000_000
        } else {
            170_000_000
        }
    }
}
