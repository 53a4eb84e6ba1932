//! The registers of the interrupt controller and of the system control block, by offset from 0xE000_E000.

use super::{
    BUS_FAULT, EXCEPTIONS, INTERRUPTS, MEM_MANAGE, NMI, Nvic, PEND_SV, SV_CALL, SYS_TICK,
    USAGE_FAULT, bit128,
};
use crate::peripherals::{NO_SUCH_REGISTER, Read, Unmodelled, Write, bit, field};

impl Nvic {
    /// Reads `size` bytes of the system control space, by offset from 0xE000_E000.
    pub fn read(&self, offset: u32, size: u32) -> Read {
        let word = self.read_word(offset & !3)?;
        Ok(word >> (8 * (offset & 3)) & (u32::MAX >> (32 - 8 * size)))
    }

    /// Writes `size` bytes of the system control space. Priorities may be written by byte, all else by word.
    pub fn write(&mut self, offset: u32, value: u32, size: u32) -> Write {
        match offset {
            0x400..=0x4EF => self.write_priorities(16 + (offset - 0x400) as usize, value, size),
            0xD18..=0xD23 => self.write_priorities(4 + (offset - 0xD18) as usize, value, size),
            _ if size == 4 => return self.write_word(offset, value),
            _ => return Err(Unmodelled("write of less than a word")),
        }
        Ok(())
    }

    /// Four of eight bits of each priority exist.
    fn write_priorities(&mut self, first: usize, value: u32, size: u32) {
        let bytes = value.to_le_bytes();
        for (priority, byte) in self
            .priorities
            .iter_mut()
            .skip(first)
            .zip(&bytes[..size as usize])
        {
            *priority = byte & 0xF0;
        }
        self.recompute_running();
    }

    fn read_word(&self, offset: u32) -> Read {
        let interrupts = |set: u128, base: u32| (set >> (16 + 8 * (offset - base))) as u32;
        let priorities = |first: usize| {
            u32::from_le_bytes(std::array::from_fn(|i| {
                self.priorities.get(first + i).copied().unwrap_or(0)
            }))
        };
        Ok(match offset {
            0x004 => 3, // ICTR: up to 128 interrupts
            0x008 => 0,
            0x100..=0x10C => interrupts(self.enabled, 0x100),
            0x180..=0x18C => interrupts(self.enabled, 0x180),
            0x200..=0x20C => interrupts(self.pending, 0x200),
            0x280..=0x28C => interrupts(self.pending, 0x280),
            0x300..=0x30C => interrupts(self.active, 0x300),
            0x400..=0x4EC => priorities(16 + (offset - 0x400) as usize),
            0xD00 => 0x410F_C241, // CPUID: Cortex-M4 r0p1
            0xD04 => self.icsr(),
            0xD08 => self.vtor,
            0xD0C => 0xFA05_0000 | self.prigroup << 8,
            0xD10 => self.scr,
            0xD14 => self.ccr,
            0xD18..=0xD20 => priorities(4 + (offset - 0xD18) as usize),
            0xD24 => self.read_shcsr(),
            0xD28 => self.cfsr,
            0xD2C => self.hfsr,
            0xD30 | 0xD3C => 0,
            0xD34 => self.mmfar,
            0xD38 => self.bfar,
            0xD88 => self.cpacr,
            0xD90 => 0x0000_0800, // MPU_TYPE: eight regions
            0xDF0 => 0,           // DHCSR: no debugger attached
            0xF34 => self.fpccr,
            0xF38 => self.fpcar,
            0xF3C => self.fpdscr,
            0xF40 => 0x1011_0021,
            0xF44 => 0x1100_0011,
            0xF48 => 0x0000_0040,
            _ => return Err(NO_SUCH_REGISTER),
        })
    }

    fn write_word(&mut self, offset: u32, value: u32) -> Write {
        let interrupts =
            |base: u32| u128::from(value) << (16 + 8 * (offset - base)) & ((1 << EXCEPTIONS) - 1);
        match offset {
            0x008 => {}
            0x100..=0x10C => self.enabled |= interrupts(0x100),
            0x180..=0x18C => self.enabled &= !interrupts(0x180),
            0x200..=0x20C => self.pending |= interrupts(0x200),
            // A pending state from a high line returns at once.
            0x280..=0x28C => self.pending &= !(interrupts(0x280) & !(self.lines & !self.active)),
            0xD04 => self.write_icsr(value),
            0xD08 => self.vtor = value & 0xFFFF_FF80,
            0xD0C if value >> 16 == 0x05FA => {
                self.prigroup = field(value, 8, 3);
                self.reset_requested |= bit(value, 2);
                self.recompute_running();
            }
            0xD0C => {}
            0xD10 => self.scr = value & 0x16,
            0xD14 => self.ccr = value,
            0xD24 => self.write_shcsr(value),
            0xD28 => self.cfsr &= !value,
            0xD2C => self.hfsr &= !value,
            0xD34 => self.mmfar = value,
            0xD38 => self.bfar = value,
            0xD88 => self.cpacr = value & 0x00F0_0000,
            0xD94 if value & 1 != 0 => return Err(Unmodelled("memory protection unit")),
            0xD94..=0xDB8 => {}
            0xF00 => self.pend(16 + field(value, 0, 9) as usize % INTERRUPTS),
            0xF34 => self.fpccr = value & 0xC000_0000,
            0xF38 => self.fpcar = value,
            0xF3C => self.fpdscr = value & 0x07C0_0000,
            _ => return Err(NO_SUCH_REGISTER),
        }
        if offset == 0xD10 && bit(value, 2) {
            Err(Unmodelled("deep sleep"))
        } else {
            Ok(())
        }
    }

    fn icsr(&self) -> u32 {
        let active = if self.active == 0 {
            0
        } else {
            self.vect_active()
        };
        let pending = self
            .most_urgent()
            .map_or(0, |(exception, _)| exception as u32);
        let flag =
            |exception: usize, index: u32| u32::from(bit128(self.pending, exception)) << index;
        active
            | u32::from(!self.nested()) << 11
            | pending << 12
            | u32::from(self.pending >> 16 != 0) << 22
            | flag(SYS_TICK, 26)
            | flag(PEND_SV, 28)
            | flag(NMI, 31)
    }

    fn write_icsr(&mut self, value: u32) {
        let mut apply = |set: u32, clear: Option<u32>, exception: usize| {
            if bit(value, set) {
                self.pending |= 1 << exception;
            }
            if clear.is_some_and(|clear| bit(value, clear)) {
                self.pending &= !(1 << exception);
            }
        };
        apply(31, None, NMI);
        apply(28, Some(27), PEND_SV);
        apply(26, Some(25), SYS_TICK);
    }

    /// Fault enables are kept in `enabled`; active and pending bits follow from the sets.
    fn read_shcsr(&self) -> u32 {
        let of =
            |set: u128, exception: usize, index: u32| u32::from(bit128(set, exception)) << index;
        of(self.active, MEM_MANAGE, 0)
            | of(self.active, BUS_FAULT, 1)
            | of(self.active, USAGE_FAULT, 3)
            | of(self.active, SV_CALL, 7)
            | of(self.active, PEND_SV, 10)
            | of(self.active, SYS_TICK, 11)
            | of(self.pending, SV_CALL, 15)
            | self.shcsr
    }

    fn write_shcsr(&mut self, value: u32) {
        self.shcsr = value & 0x0007_0000;
        for (index, fault) in [(16, MEM_MANAGE), (17, BUS_FAULT), (18, USAGE_FAULT)] {
            self.enabled = (self.enabled & !(1 << fault)) | u128::from(bit(value, index)) << fault;
        }
    }
}
