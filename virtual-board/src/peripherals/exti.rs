//! Extended interrupts (RM0440 chapter 14): masks are stored, software events set the pending flags; edges of pins do
//! not occur, since the bench drives analog pins only.

use super::{NO_SUCH_REGISTER, Read, Write};

/// Registers of one of the two groups of 32 lines.
#[derive(Debug, Default, Clone, Copy)]
struct Group {
    interrupt_mask: u32,
    event_mask: u32,
    rising: u32,
    falling: u32,
    software: u32,
    pending: u32,
}

/// The controller.
#[derive(Debug)]
pub struct Exti {
    groups: [Group; 2],
}

impl Default for Exti {
    fn default() -> Self {
        let direct = |interrupt_mask| Group {
            interrupt_mask,
            ..Group::default()
        };
        // Direct lines are unmasked after reset.
        Self {
            groups: [direct(0x1F84_0000), direct(0x0000_079C)],
        }
    }
}

impl Exti {
    /// Reads a register.
    pub fn read(&self, offset: u32) -> Read {
        let group = self
            .groups
            .get(offset as usize / 0x20)
            .ok_or(NO_SUCH_REGISTER)?;
        Ok(match offset % 0x20 {
            0x00 => group.interrupt_mask,
            0x04 => group.event_mask,
            0x08 => group.rising,
            0x0C => group.falling,
            0x10 => group.software,
            0x14 => group.pending,
            _ => return Err(NO_SUCH_REGISTER),
        })
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32) -> Write {
        let group = self
            .groups
            .get_mut(offset as usize / 0x20)
            .ok_or(NO_SUCH_REGISTER)?;
        match offset % 0x20 {
            0x00 => group.interrupt_mask = value,
            0x04 => group.event_mask = value,
            0x08 => group.rising = value,
            0x0C => group.falling = value,
            0x10 => {
                group.pending |= value & !group.software & group.interrupt_mask;
                group.software |= value;
            }
            0x14 => {
                group.pending &= !value;
                group.software &= !value;
            }
            _ => return Err(NO_SUCH_REGISTER),
        }
        Ok(())
    }

    /// Pending lines of the first group (lines 0 to 31).
    pub fn pending(&self) -> u32 {
        self.groups[0].pending
    }
}
