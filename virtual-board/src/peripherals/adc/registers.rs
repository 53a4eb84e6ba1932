//! The registers of a converter.

use super::{
    ADCAL, ADCALDIF, ADDIS, ADEN, ADSTART, ADSTP, ADVREGEN, Adc, CALIBRATION_CLOCKS, DEEPPWD,
    DISABLE_CLOCKS, ENABLE_CLOCKS, EOC, FACTOR_MASK,
};
use crate::peripherals::{Cycles, NO_SUCH_REGISTER, Read, Unmodelled, Write};

const JADSTART: u32 = 1 << 3;

impl Adc {
    /// Reads a register.
    pub fn read(&mut self, offset: u32) -> Read {
        Ok(match offset {
            0x00 => self.isr,
            0x04 => self.ier,
            0x08 => self.cr,
            0x0C => self.cfgr,
            0x10 => self.cfgr2,
            0x14 | 0x18 => self.smpr[(offset as usize - 0x14) / 4],
            0x20..=0x28 => self.thresholds[(offset as usize - 0x20) / 4],
            0x30..=0x3C => self.sqr[(offset as usize - 0x30) / 4],
            0x40 => self.take_data(),
            0x4C | 0x60..=0x6C | 0x80..=0x8C | 0xA0 | 0xA4 | 0xC0 => 0,
            0xB0 => self.difsel,
            0xB4 => self.calfact,
            _ => return Err(NO_SUCH_REGISTER),
        })
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, now: Cycles) -> Write {
        const BUSY: Unmodelled = Unmodelled("ignored by hardware: written while ADSTART is set");
        const ON: Unmodelled = Unmodelled("ignored by hardware: written while ADEN is set");
        let busy = self.cr & ADSTART != 0;
        match offset {
            0x00 => self.isr &= !value,
            0x04 => self.ier = value,
            0x08 => return self.control(value, now),
            0x0C if busy && value != self.cfgr => return Err(BUSY),
            0x0C => {
                self.cfgr = value;
                if value & 0x07FF_C000 != 0 {
                    return Err(Unmodelled(
                        "auto-delay, alignment, discontinuous mode and analog watchdogs",
                    ));
                }
            }
            0x10 if busy && value != self.cfgr2 => return Err(BUSY),
            0x10 => {
                self.cfgr2 = value;
                if value & 0x0E01_0202 != 0 {
                    return Err(Unmodelled(
                        "triggered oversampling, injected oversampling, gain compensation",
                    ));
                }
            }
            0x14 | 0x18 if busy => return Err(BUSY),
            0x14 | 0x18 => self.smpr[(offset as usize - 0x14) / 4] = value,
            0x20..=0x28 => self.thresholds[(offset as usize - 0x20) / 4] = value,
            0x30..=0x3C if busy => return Err(BUSY),
            0x30..=0x3C => self.sqr[(offset as usize - 0x30) / 4] = value,
            0xB0 if self.enabled() && value != self.difsel => return Err(ON),
            0xB0 => {
                self.difsel = value;
                if value != 0 {
                    return Err(Unmodelled("differential inputs"));
                }
            }
            0xB4 if busy || !self.enabled() => {
                return Err(Unmodelled(
                    "ignored by hardware: CALFACT written while ADEN is clear or ADSTART is set",
                ));
            }
            0xB4 => {
                self.calfact = value & (FACTOR_MASK << 16 | FACTOR_MASK);
                self.corrected = true;
            }
            0x4C | 0x60..=0x6C | 0xA0 | 0xA4 | 0xC0 if value == 0 => {}
            _ => return Err(NO_SUCH_REGISTER),
        }
        Ok(())
    }

    fn control(&mut self, value: u32, now: Cycles) -> Write {
        let off = self.cr & (ADCAL | ADSTART | ADSTP | ADDIS | ADEN) == 0;
        if off {
            self.cr = (self.cr & !(DEEPPWD | ADVREGEN | ADCALDIF))
                | (value & (DEEPPWD | ADVREGEN | ADCALDIF));
        }
        let powered = self.cr & (ADVREGEN | DEEPPWD) == ADVREGEN;
        if value & ADCAL != 0 && off && powered {
            self.cr |= ADCAL;
            self.transition_at = now + self.half_clocks(2 * CALIBRATION_CLOCKS);
        } else if value & ADEN != 0 && off && powered {
            self.cr |= ADEN;
            self.transition_at = now + self.half_clocks(2 * ENABLE_CLOCKS);
        } else if value & (ADCAL | ADEN) & !self.cr != 0 {
            return Err(Unmodelled(
                "ignored by hardware: ADCAL or ADEN without regulator or while not off",
            ));
        }
        if value & ADDIS != 0 && self.cr & (ADEN | ADSTART | ADDIS) == ADEN {
            self.cr |= ADDIS;
            self.transition_at = now + self.half_clocks(2 * DISABLE_CLOCKS);
        }
        if value & ADSTP != 0 && self.cr & (ADSTART | ADDIS) == ADSTART {
            self.conversion = None;
            self.cr &= !ADSTART;
        }
        if value & ADSTART != 0 && value & ADSTP == 0 && self.cr & (ADEN | ADDIS | ADSTART) == ADEN
        {
            self.start(now);
        }
        if value & JADSTART != 0 {
            Err(Unmodelled("injected conversions"))
        } else {
            Ok(())
        }
    }

    fn take_data(&mut self) -> u32 {
        self.isr &= !EOC;
        self.request = false;
        self.dr
    }
}
