//! The registers that converters share (RM0440 21.8): clock prescaler, internal channels, dual mode.

use crate::peripherals::{NO_SUCH_REGISTER, Read, Unmodelled, Write, bit, field};

/// Registers that two or three converters share: the clock prescaler and the internal channels.
#[derive(Debug, Default)]
pub struct AdcCommon {
    ccr: u32,
}

impl AdcCommon {
    /// Reads a register.
    pub fn read(&self, offset: u32) -> Read {
        match offset {
            0x08 => Ok(self.ccr),
            _ => Err(NO_SUCH_REGISTER),
        }
    }

    /// Writes a register; `any_enabled` says whether one of the converters is on, which locks dual mode and clock.
    pub fn write(&mut self, offset: u32, value: u32, any_enabled: bool) -> Write {
        const LOCKED: u32 = 0x003F_EF1F;
        match offset {
            0x08 if any_enabled && (value ^ self.ccr) & LOCKED != 0 => {
                self.ccr = (self.ccr & LOCKED) | (value & !LOCKED);
                Err(Unmodelled(
                    "ignored by hardware: dual mode or clock written while a converter is on",
                ))
            }
            0x08 => {
                self.ccr = value;
                if field(value, 0, 5) != 0 {
                    Err(Unmodelled("dual mode"))
                } else {
                    Ok(())
                }
            }
            _ => Err(NO_SUCH_REGISTER),
        }
    }

    /// The converters' clock, Hz, from their kernel clock and the bus clock (CCR.CKMODE, CCR.PRESC).
    pub fn clock(&self, kernel_hz: u32, bus_hz: u32) -> u32 {
        const PRESCALERS: [u32; 16] = [
            1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256, 256, 256, 256, 256,
        ];
        match field(self.ccr, 16, 2) {
            0 => kernel_hz / PRESCALERS[field(self.ccr, 18, 4) as usize],
            mode => bus_hz / [1, 1, 2, 4][mode as usize],
        }
    }

    /// Whether the reference voltage is switched to its input.
    pub fn vrefint_on(&self) -> bool {
        bit(self.ccr, 22)
    }

    /// Whether the temperature sensor is switched on.
    pub fn temperature_on(&self) -> bool {
        bit(self.ccr, 23)
    }

    /// Whether a third of the backup supply is switched to its input.
    pub fn vbat_on(&self) -> bool {
        bit(self.ccr, 24)
    }
}
