//! The registers of a timer.

use super::{CEN, Timer};
use crate::peripherals::{Cycles, NO_SUCH_REGISTER, Read, Unmodelled, Write, bit, field};

const ARPE: u32 = 1 << 7;
const URS: u32 = 1 << 2;

impl Timer {
    /// Reads a register; events up to `now` must have been advanced through.
    pub fn read(&mut self, offset: u32, now: Cycles) -> Read {
        Ok(match offset {
            0x00 => self.cr1,
            0x04 => self.cr2,
            0x08 => 0,
            0x0C => self.dier,
            0x10 => self.sr,
            0x14 => 0,
            0x18 | 0x1C if self.shape.channels > 0 => self.ccmr[(offset as usize - 0x18) / 4],
            0x20 if self.shape.channels > 0 => self.ccer,
            0x24 => self.count(now),
            0x28 => self.psc,
            0x2C => self.arr,
            0x34..=0x40 if self.channel_of(offset).is_some() => {
                self.ccr[(offset as usize - 0x34) / 4]
            }
            _ => return Err(NO_SUCH_REGISTER),
        })
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, now: Cycles) -> Write {
        match offset {
            0x00 => return self.write_control(value, now),
            0x04 => {
                self.cr2 = value;
                if field(value, 4, 3) > 2 {
                    return Err(Unmodelled("trigger output from a compare channel"));
                }
            }
            0x08 if value != 0 => return Err(Unmodelled("slave modes")),
            0x08 => {}
            0x0C => {
                self.dier = value;
                if value & 0x7F00 != 0 {
                    return Err(Unmodelled("DMA requests of timers"));
                }
            }
            0x10 => self.sr &= value,
            0x14 => return self.generate(value, now),
            0x18 | 0x1C if self.shape.channels > 0 => {
                self.ccmr[(offset as usize - 0x18) / 4] = value;
                if value & 0x0303 != 0 {
                    return Err(Unmodelled("input capture"));
                }
            }
            0x20 if self.shape.channels > 0 => {
                self.ccer = value;
                if value != 0 {
                    return Err(Unmodelled("timer outputs on pins"));
                }
            }
            0x24 => self.set_count(value, now),
            0x28 => self.psc = value & 0xFFFF,
            0x2C => {
                self.arr = value & Self::mask(self.shape);
                if self.cr1 & ARPE == 0 {
                    self.arr_active = self.arr;
                }
            }
            0x34..=0x40 => match self.channel_of(offset) {
                Some(channel) => self.ccr[channel] = value & Self::mask(self.shape),
                None => return Err(NO_SUCH_REGISTER),
            },
            _ => return Err(NO_SUCH_REGISTER),
        }
        Ok(())
    }

    /// Whether the timer's interrupt line is high.
    pub fn interrupt(&self) -> bool {
        self.sr & self.dier & 0x5F != 0
    }

    fn write_control(&mut self, value: u32, now: Cycles) -> Write {
        let was_running = self.running();
        let count = self.count(now);
        if value & CEN != 0 && self.cr1 & CEN == 0 && self.trigger_mode() == 1 {
            self.trigger = true;
        }
        self.cr1 = value & !0x70;
        if !was_running && self.running() {
            self.starts += 1;
            self.restart_at(self.held, now);
        } else if was_running && !self.running() {
            self.held = count;
        }
        match value & 0x0870 {
            0 => Ok(()),
            _ => Err(Unmodelled(
                "down-counting, centre-aligned counting and UIFREMAP",
            )),
        }
    }

    fn generate(&mut self, value: u32, now: Cycles) -> Write {
        if bit(value, 0) {
            self.update(self.cr1 & URS == 0);
            if self.trigger_mode() == 0 {
                self.trigger = true;
            }
            self.held = 0;
            self.restart_at(0, now);
        }
        for channel in 0..self.shape.channels {
            if bit(value, channel as u32 + 1) {
                self.sr |= 2 << channel;
            }
        }
        Ok(())
    }

    fn channel_of(&self, offset: u32) -> Option<usize> {
        let channel = (offset as usize).checked_sub(0x34)? / 4;
        (channel < self.shape.channels).then_some(channel)
    }
}
