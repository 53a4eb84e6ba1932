//! The registers of LPUART1, its interrupt line and its DMA requests.

use super::{FE, FIFO_DEPTH, FIFOEN, IDLE, Lpuart, NE, ORE, TC, UE};
use crate::peripherals::{Cycles, NEVER, NO_SUCH_REGISTER, Read, Unmodelled, Write, bit, field};

const IDLEIE: u32 = 4;
const RXNEIE: u32 = 5;
const TCIE: u32 = 6;
const TXEIE: u32 = 7;
const TXFEIE: u32 = 30;
const RXFFIE: u32 = 31;
const EIE: u32 = 0;
const DMAR: u32 = 6;
const DMAT: u32 = 7;
const TXFTIE: u32 = 23;
const RXFTIE: u32 = 28;
const RXNE: u32 = 1 << 5;
const TXE: u32 = 1 << 7;

impl Lpuart {
    /// Reads a register.
    pub fn read(&mut self, offset: u32) -> Read {
        Ok(match offset {
            0x00 => self.cr1,
            0x04 => self.cr2,
            0x08 => self.cr3,
            0x0C => self.brr,
            0x18 | 0x20 | 0x28 => 0,
            0x1C => self.status(),
            0x24 => self.receive(),
            0x2C => self.presc,
            _ => return Err(NO_SUCH_REGISTER),
        })
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, now: Cycles) -> Write {
        match offset {
            0x00 => return self.write_cr1(value, now),
            0x04 => self.cr2 = value,
            0x08 => {
                self.cr3 = value;
                if value & 0x0000_4308 != 0 {
                    return Err(Unmodelled("half-duplex, flow control and driver enable"));
                }
            }
            0x0C => self.brr = value & 0xF_FFFF,
            0x18 => {
                if bit(value, 3) {
                    self.rx.clear();
                }
                if bit(value, 4) {
                    self.tx.clear();
                }
            }
            0x20 => self.latched &= !(value & (FE | NE | ORE | IDLE | TC)),
            0x28 => self.transmit(value as u8, now),
            0x2C => self.presc = value & 0xF,
            _ => return Err(NO_SUCH_REGISTER),
        }
        Ok(())
    }

    /// Whether the interrupt line is high.
    pub fn interrupt(&self) -> bool {
        let status = self.status();
        let on = |enable: bool, flags: u32| enable && status & flags != 0;
        on(bit(self.cr1, IDLEIE), IDLE)
            || on(bit(self.cr1, RXNEIE), RXNE | ORE)
            || on(bit(self.cr1, TCIE), TC)
            || on(bit(self.cr1, TXEIE), TXE)
            || on(bit(self.cr1, TXFEIE), 1 << 23)
            || on(bit(self.cr1, RXFFIE), 1 << 24)
            || on(bit(self.cr3, RXFTIE), 1 << 26)
            || on(bit(self.cr3, TXFTIE), 1 << 27)
            || on(bit(self.cr3, EIE), FE | NE | ORE)
    }

    /// Whether the receiver asks a DMA channel to fetch a character.
    pub fn rx_request(&self) -> bool {
        bit(self.cr3, DMAR) && !self.rx.is_empty()
    }

    /// Whether the transmitter asks a DMA channel for a character.
    pub fn tx_request(&self) -> bool {
        bit(self.cr3, DMAT) && self.transmitting() && self.tx.len() < self.depth()
    }

    fn status(&self) -> u32 {
        let fifo = bit(self.cr1, FIFOEN);
        let mut status = self.latched;
        let mut set = |condition: bool, index: u32| status |= u32::from(condition) << index;
        set(!self.rx.is_empty(), 5);
        set(self.tx.len() < self.depth(), 7);
        set(self.arriving.is_some() && self.receiving(), 16);
        set(self.transmitting(), 21);
        set(self.receiving(), 22);
        set(fifo && self.tx.is_empty(), 23);
        set(fifo && self.rx.len() == FIFO_DEPTH, 24);
        set(
            fifo && self.rx.len() >= threshold(field(self.cr3, 25, 3)),
            26,
        );
        set(
            fifo && FIFO_DEPTH - self.tx.len() >= threshold(field(self.cr3, 29, 3)),
            27,
        );
        status
    }

    fn write_cr1(&mut self, value: u32, now: Cycles) -> Write {
        let was_on = bit(self.cr1, UE);
        self.cr1 = value;
        if was_on && !bit(value, UE) {
            self.rx.clear();
            self.tx.clear();
            self.shifting = None;
            self.idle_at = NEVER;
            self.latched = TC;
        }
        self.begin_shift(now);
        if bit(value, 10) || bit(value, 13) {
            Err(Unmodelled("parity and mute mode"))
        } else {
            Ok(())
        }
    }
}

/// FIFO thresholds RXFTCFG and TXFTCFG in characters.
fn threshold(code: u32) -> usize {
    [1, 2, 4, 6, 7, 8, 8, 8][code as usize]
}
