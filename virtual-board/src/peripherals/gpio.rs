//! General-purpose ports (RM0440 chapter 9), seen from the registers only: an output pin reads back what it drives, an
//! input pin reads its pull resistor. The bench drives no digital pin, and analog voltages bypass the port.

use super::{NO_SUCH_REGISTER, Read, Unmodelled, Write, bit, field};

/// One port.
#[derive(Debug)]
pub struct Gpio {
    mode: u32,
    output_type: u32,
    speed: u32,
    pull: u32,
    output: u32,
    alternate: [u32; 2],
}

impl Gpio {
    /// Port `index` (0 is A) after reset: debug pins on ports A and B, everything else analog.
    pub fn new(index: usize) -> Self {
        let (mode, speed, pull) = match index {
            0 => (0xABFF_FFFF, 0x0C00_0000, 0x6400_0000),
            1 => (0xFFFF_FEBF, 0x0000_00C0, 0x0000_0100),
            _ => (0xFFFF_FFFF, 0, 0),
        };
        Self {
            mode,
            output_type: 0,
            speed,
            pull,
            output: 0,
            alternate: [0; 2],
        }
    }

    /// Reads a register.
    pub fn read(&self, offset: u32) -> Read {
        Ok(match offset {
            0x00 => self.mode,
            0x04 => self.output_type,
            0x08 => self.speed,
            0x0C => self.pull,
            0x10 => (0..16)
                .filter(|&pin| self.level(pin))
                .map(|pin| 1 << pin)
                .sum(),
            0x14 => self.output,
            0x18 | 0x28 => 0,
            0x20 | 0x24 => self.alternate[(offset as usize - 0x20) / 4],
            _ => return Err(NO_SUCH_REGISTER),
        })
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32) -> Write {
        match offset {
            0x00 => self.mode = value,
            0x04 => self.output_type = value & 0xFFFF,
            0x08 => self.speed = value,
            0x0C => self.pull = value,
            0x10 => {}
            0x14 => self.output = value & 0xFFFF,
            // Where a pin is both set and reset, set wins (RM0440 9.4.7).
            0x18 => self.output = (self.output & !(value >> 16)) | (value & 0xFFFF),
            0x1C => return Err(Unmodelled("locking of pins")),
            0x20 | 0x24 => self.alternate[(offset as usize - 0x20) / 4] = value,
            0x28 => self.output &= !value,
            _ => return Err(NO_SUCH_REGISTER),
        }
        Ok(())
    }

    fn level(&self, pin: u32) -> bool {
        match field(self.mode, 2 * pin, 2) {
            1 => bit(self.output, pin),
            3 => false, // analog: the input stage is off
            _ => field(self.pull, 2 * pin, 2) == 1,
        }
    }
}
