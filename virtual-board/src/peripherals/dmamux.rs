//! DMA request multiplexer (RM0440 chapter 13): the request of each of the sixteen channels.
//!
//! Synchronisation, event generation and request generators are not modelled.

use super::{NO_SUCH_REGISTER, Read, Unmodelled, Write};

/// Channels: eight of DMA1, then eight of DMA2.
pub const CHANNELS: usize = 16;

/// CCR.SE and SOIE: requests are passed on after a synchronisation signal only.
const SYNCHRONISED: u32 = 1 << 16 | 1 << 8;

/// Numbers of the requests that the modelled peripherals make (RM0440 table 91).
pub mod request {
    /// No request.
    pub const NONE: u8 = 0;
    /// Requests of ADC1 to ADC5.
    pub const ADC: [u8; 5] = [5, 36, 37, 38, 39];
    /// LPUART1 has received.
    pub const LPUART1_RX: u8 = 34;
    /// LPUART1 has room to transmit.
    pub const LPUART1_TX: u8 = 35;
}

/// The multiplexer.
#[derive(Debug, Default)]
pub struct Dmamux {
    channels: [u32; CHANNELS],
}

impl Dmamux {
    /// Reads a register.
    pub fn read(&self, offset: u32) -> Read {
        match offset {
            0x80 => Ok(0),
            _ => self
                .channels
                .get(offset as usize / 4)
                .copied()
                .ok_or(NO_SUCH_REGISTER),
        }
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32) -> Write {
        if offset == 0x84 {
            return Ok(());
        }
        *self
            .channels
            .get_mut(offset as usize / 4)
            .ok_or(NO_SUCH_REGISTER)? = value;
        match value & SYNCHRONISED {
            0 => Ok(()),
            _ => Err(Unmodelled("synchronisation of DMA requests")),
        }
    }

    /// The request that a channel listens to.
    pub fn request(&self, channel: usize) -> u8 {
        (self.channels[channel] & 0x7F) as u8
    }
}
