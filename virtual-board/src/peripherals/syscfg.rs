//! System configuration (RM0440 chapter 10): stored and read back; remapping and the CCM's write protection have no
//! effect in the model.

use super::{NO_SUCH_REGISTER, Read, Unmodelled, Write};

const REGISTERS: usize = 10;

/// The system configuration controller.
#[derive(Debug)]
pub struct Syscfg {
    registers: [u32; REGISTERS],
}

impl Default for Syscfg {
    fn default() -> Self {
        let mut registers = [0; REGISTERS];
        registers[1] = 0x7C00_0001;
        Self { registers }
    }
}

impl Syscfg {
    /// Reads a register.
    pub fn read(&self, offset: u32) -> Read {
        self.registers
            .get(offset as usize / 4)
            .copied()
            .ok_or(NO_SUCH_REGISTER)
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32) -> Write {
        *self
            .registers
            .get_mut(offset as usize / 4)
            .ok_or(NO_SUCH_REGISTER)? = value;
        match offset {
            0x00 if value & 0x107 != 0 => Err(Unmodelled("memory remapping")),
            0x20 if value != 0 => Err(Unmodelled("write protection of the CCM")),
            _ => Ok(()),
        }
    }
}
