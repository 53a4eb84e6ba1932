//! The registers of the flash interface.

use super::{
    BSY, ECCC, ECCCIE, ECCD, EOP, EOPIE, ERRIE, ERRORS, Flash, Keyhole, LOCK, OPERR, OPTLOCK, PG,
    STRT,
};
use crate::peripherals::{Cycles, NO_SUCH_REGISTER, Read, Unmodelled, Write, bit, field};

const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
const OPTION_KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];

const FSTPG: u32 = 18;
const OPTSTRT: u32 = 17;
const OBL_LAUNCH: u32 = 27;

impl Flash {
    /// Reads a register.
    pub fn read(&self, offset: u32) -> Read {
        Ok(match offset {
            0x00 => self.acr,
            0x04..=0x0C => 0,
            0x10 => self.sr | if self.running.is_some() { BSY } else { 0 },
            0x14 => self.cr,
            0x18 => self.eccr,
            0x20 => self.options.optr,
            0x24 | 0x44 => 0xFFFF_FFFF,
            0x28 | 0x48 => 0xFFFF_0000,
            0x2C => self.options.write_protection[0],
            0x30 => self.options.write_protection[1],
            0x4C => self.options.write_protection[2],
            0x50 => self.options.write_protection[3],
            0x70 | 0x74 => 0xFF00_FF00,
            _ => return Err(NO_SUCH_REGISTER),
        })
    }

    /// Writes a register. A write may ask for a reset of the chip: see [`Self::option_bytes_reload`].
    pub fn write(&mut self, offset: u32, value: u32, now: Cycles) -> Write {
        match offset {
            0x00 => self.acr = value & !0x1800,
            0x08 => {
                self.bus_error |= turn(&mut self.keyhole, KEYS, value);
                if self.keyhole == Keyhole::Open {
                    self.cr &= !(1 << LOCK);
                }
            }
            0x0C => {
                self.bus_error |= turn(&mut self.option_keyhole, OPTION_KEYS, value);
                if self.option_keyhole == Keyhole::Open && !bit(self.cr, LOCK) {
                    self.cr &= !(1 << OPTLOCK);
                }
            }
            0x10 => self.sr &= !(value & (ERRORS | EOP)),
            0x14 => return self.control(value, now),
            0x18 => {
                const KEPT: u32 = !(1 << ECCD | 1 << ECCC | 1 << ECCCIE);
                let flags = self.eccr & !value & (1 << ECCD | 1 << ECCC);
                self.eccr = (self.eccr & KEPT) | flags | (value & 1 << ECCCIE);
            }
            0x04 => return Err(Unmodelled("power-down of the flash memory")),
            0x20..=0x74 => return Err(Unmodelled("programming of option bytes")),
            _ => return Err(NO_SUCH_REGISTER),
        }
        Ok(())
    }

    fn control(&mut self, value: u32, now: Cycles) -> Write {
        if bit(self.cr, LOCK) {
            return Err(Unmodelled(
                "ignored by hardware: control register written while it is locked",
            ));
        }
        self.cr = (value & !(1 << OPTLOCK)) | (self.cr & (1 << OPTLOCK | 1 << STRT));
        if bit(value, LOCK) && self.keyhole == Keyhole::Open {
            self.keyhole = Keyhole::Locked;
        }
        if !bit(value, PG) {
            self.latch = None;
        }
        if bit(value, STRT) && self.running.is_none() {
            self.begin_erase(now);
        }
        match () {
            () if bit(value, FSTPG) => Err(Unmodelled("fast programming")),
            () if bit(value, OPTSTRT) => Err(Unmodelled("programming of option bytes")),
            () => Ok(()),
        }
    }

    /// Whether the interrupt line is high.
    pub fn interrupt(&self) -> bool {
        (bit(self.cr, EOPIE) && self.sr & EOP != 0)
            || (bit(self.cr, ERRIE) && self.sr & OPERR != 0)
            || (bit(self.eccr, ECCCIE) && bit(self.eccr, ECCC))
    }

    /// Wait states that are set (ACR.LATENCY).
    pub fn wait_states(&self) -> u32 {
        field(self.acr, 0, 4)
    }

    /// Collects the bus error of a wrong key.
    pub fn take_bus_error(&mut self) -> bool {
        std::mem::take(&mut self.bus_error)
    }

    /// Whether the firmware asked for the option bytes to be loaded again, which resets the chip.
    pub fn option_bytes_reload(&self) -> bool {
        bit(self.cr, OBL_LAUNCH)
    }
}

/// Tries a key; true if it was the wrong one, which jams the keyhole and is a bus error.
fn turn(keyhole: &mut Keyhole, keys: [u32; 2], key: u32) -> bool {
    *keyhole = match *keyhole {
        Keyhole::Locked if key == keys[0] => Keyhole::FirstKey,
        Keyhole::FirstKey if key == keys[1] => Keyhole::Open,
        _ => Keyhole::Jammed,
    };
    *keyhole == Keyhole::Jammed
}
