//! DMA controllers (RM0440 chapter 12): eight channels each, normal and circular, half and complete interrupts.
//!
//! A channel moves one item per request, in no time. NDTR counts down; at zero the channel stops, or with CIRC it is
//! reloaded and the addresses start again. Memory-to-memory transfers are not modelled.

use super::{NO_SUCH_REGISTER, Read, Unmodelled, Write, bit, field};

/// Channels of one controller.
pub const CHANNELS: usize = 8;

const EN: u32 = 0;
const DIR: u32 = 4;
const CIRC: u32 = 5;
const PINC: u32 = 6;
const MINC: u32 = 7;
const MEM2MEM: u32 = 14;
const GIF: u32 = 1;
const TCIF: u32 = 2;
const HTIF: u32 = 4;
const TEIF: u32 = 8;
/// The global flags of all channels.
const ALL_GIF: u32 = 0x1111_1111;

/// One item to be moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transfer {
    /// Address to read from.
    pub from: u32,
    /// Bytes to read: 1, 2 or 4.
    pub from_size: u32,
    /// Address to write to.
    pub to: u32,
    /// Bytes to write: 1, 2 or 4.
    pub to_size: u32,
}

#[derive(Debug, Default, Clone, Copy)]
struct Channel {
    ccr: u32,
    count: u32,
    reload: u32,
    peripheral: u32,
    memory: u32,
    moved: u32,
}

/// One controller.
#[derive(Debug, Default)]
pub struct Dma {
    flags: u32,
    channels: [Channel; CHANNELS],
}

impl Dma {
    /// Reads a register.
    pub fn read(&self, offset: u32) -> Read {
        if offset == 0x00 {
            return Ok(self.flags);
        }
        if offset == 0x04 {
            return Ok(0);
        }
        let (channel, register) = locate(offset)?;
        let channel = &self.channels[channel];
        Ok(match register {
            0x00 => channel.ccr,
            0x04 => channel.count,
            0x08 => channel.peripheral,
            _ => channel.memory,
        })
    }

    /// Writes a register. Count and addresses of a running channel do not change.
    pub fn write(&mut self, offset: u32, value: u32) -> Write {
        if offset == 0x00 {
            return Ok(());
        }
        if offset == 0x04 {
            self.clear(value);
            return match value & ALL_GIF {
                0 => Ok(()),
                _ => Err(Unmodelled(
                    "clearing the global flag can lose an event that comes at the same time: clear the others",
                )),
            };
        }
        let (index, register) = locate(offset)?;
        let channel = &mut self.channels[index];
        match register {
            0x00 => return channel.control(value),
            _ if bit(channel.ccr, EN) => {
                return Err(Unmodelled("write to a DMA channel that is enabled"));
            }
            0x04 => {
                channel.count = value & 0xFFFF;
                channel.reload = channel.count;
            }
            0x08 => channel.peripheral = value,
            _ => channel.memory = value,
        }
        Ok(())
    }

    /// Whether the channel would answer a request.
    pub fn ready(&self, channel: usize) -> bool {
        let channel = &self.channels[channel];
        bit(channel.ccr, EN) && !bit(channel.ccr, MEM2MEM) && channel.count > 0
    }

    /// What the channel moves next.
    pub fn transfer(&self, channel: usize) -> Transfer {
        let channel = &self.channels[channel];
        let peripheral_size = 1 << field(channel.ccr, 8, 2).min(2);
        let memory_size = 1 << field(channel.ccr, 10, 2).min(2);
        let step = |increments, size: u32| {
            if bit(channel.ccr, increments) {
                channel.moved * size
            } else {
                0
            }
        };
        let peripheral = channel.peripheral.wrapping_add(step(PINC, peripheral_size));
        let memory = channel.memory.wrapping_add(step(MINC, memory_size));
        if bit(channel.ccr, DIR) {
            Transfer {
                from: memory,
                from_size: memory_size,
                to: peripheral,
                to_size: peripheral_size,
            }
        } else {
            Transfer {
                from: peripheral,
                from_size: peripheral_size,
                to: memory,
                to_size: memory_size,
            }
        }
    }

    /// Counts an item that was moved.
    pub fn moved(&mut self, index: usize) {
        let channel = &mut self.channels[index];
        channel.moved += 1;
        channel.count -= 1;
        let mut raised = 0;
        if channel.count == channel.reload / 2 {
            raised |= HTIF;
        }
        if channel.count == 0 {
            raised |= TCIF;
            channel.moved = 0;
            if bit(channel.ccr, CIRC) {
                channel.count = channel.reload;
            }
        }
        if raised != 0 {
            self.flags |= (raised | GIF) << (4 * index);
        }
    }

    /// Notes that an item's address does not exist: the channel is switched off (RM0440 12.4.6).
    pub fn failed(&mut self, index: usize) {
        self.channels[index].ccr &= !(1 << EN);
        self.flags |= (TEIF | GIF) << (4 * index);
    }

    /// Whether the channel's interrupt line is high.
    pub fn interrupt(&self, channel: usize) -> bool {
        // TCIE, HTIE, TEIE are bits 1 to 3 of CCR, as the flags are of their group.
        field(self.flags, 4 * channel as u32, 4) & self.channels[channel].ccr & (TCIF | HTIF | TEIF)
            != 0
    }

    /// Clearing the global flag clears the whole group.
    fn clear(&mut self, value: u32) {
        for channel in 0..CHANNELS as u32 {
            let group = field(value, 4 * channel, 4);
            let cleared = if group & GIF != 0 { 0xF } else { group };
            self.flags &= !(cleared << (4 * channel));
            if field(self.flags, 4 * channel, 4) == GIF {
                self.flags &= !(GIF << (4 * channel));
            }
        }
    }
}

impl Channel {
    fn control(&mut self, value: u32) -> Write {
        let enables = bit(value & !self.ccr, EN);
        self.ccr = value & 0x7FFF;
        if enables {
            // The counter goes on where it stopped; only the addresses start again.
            self.moved = 0;
            self.reload = self.count;
        }
        if bit(value, EN) && bit(value, MEM2MEM) {
            Err(Unmodelled("memory-to-memory DMA"))
        } else {
            Ok(())
        }
    }
}

fn locate(offset: u32) -> Result<(usize, u32), Unmodelled> {
    let from_first = offset.checked_sub(0x08).ok_or(NO_SUCH_REGISTER)?;
    let (channel, register) = (from_first as usize / 20, from_first % 20);
    if channel < CHANNELS && register < 16 {
        Ok((channel, register))
    } else {
        Err(NO_SUCH_REGISTER)
    }
}
