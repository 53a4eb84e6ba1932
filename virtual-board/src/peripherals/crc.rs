//! CRC calculation unit (RM0440 chapter 15): programmable polynomial of 7, 8, 16 or 32 bits, reversible in and out.

use super::{NO_SUCH_REGISTER, Read, Write, bit, field};

/// The unit.
#[derive(Debug)]
pub struct Crc {
    remainder: u32,
    scratch: u32,
    cr: u32,
    init: u32,
    polynomial: u32,
}

impl Default for Crc {
    fn default() -> Self {
        Self {
            remainder: u32::MAX,
            scratch: 0,
            cr: 0,
            init: u32::MAX,
            polynomial: 0x04C1_1DB7,
        }
    }
}

impl Crc {
    /// Reads a register.
    pub fn read(&mut self, offset: u32) -> Read {
        Ok(match offset {
            0x00 => self.output(),
            0x04 => self.scratch,
            0x08 => self.cr,
            0x10 => self.init,
            0x14 => self.polynomial,
            _ => return Err(NO_SUCH_REGISTER),
        })
    }

    /// Writes `size` bytes to a register; only the data register minds the size.
    pub fn write(&mut self, offset: u32, value: u32, size: u32) -> Write {
        match offset {
            0x00 => self.feed(value, 8 * size),
            0x04 => self.scratch = value,
            0x08 => {
                self.cr = value & !1;
                if bit(value, 0) {
                    self.remainder = self.init & self.mask();
                }
            }
            0x10 => {
                self.init = value;
                self.remainder = value & self.mask();
            }
            0x14 => self.polynomial = value,
            _ => return Err(NO_SUCH_REGISTER),
        }
        Ok(())
    }

    /// Width of the polynomial in bits (CR.POLYSIZE).
    fn width(&self) -> u32 {
        [32, 16, 8, 7][field(self.cr, 3, 2) as usize]
    }

    fn mask(&self) -> u32 {
        u32::MAX >> (32 - self.width())
    }

    fn feed(&mut self, value: u32, bits: u32) {
        let group = match field(self.cr, 5, 2) {
            0 => 0,
            n => (4 << n).min(bits),
        };
        let value = reverse_groups(value, bits, group);
        let top = self.width() - 1;
        for index in (0..bits).rev() {
            let feedback = bit(value, index) != bit(self.remainder, top);
            self.remainder = (self.remainder << 1) & self.mask();
            if feedback {
                self.remainder ^= self.polynomial & self.mask();
            }
        }
    }

    fn output(&self) -> u32 {
        if bit(self.cr, 7) {
            self.remainder.reverse_bits() >> (32 - self.width())
        } else {
            self.remainder
        }
    }
}

/// Reverses the bits within each group of `group` bits of a value of `bits` bits; zero means no reversal.
fn reverse_groups(value: u32, bits: u32, group: u32) -> u32 {
    if group == 0 {
        return value;
    }
    let mask = u32::MAX >> (32 - group);
    (0..bits / group)
        .map(|index| {
            (((value >> (index * group)) & mask).reverse_bits() >> (32 - group)) << (index * group)
        })
        .fold(0, |all, part| all | part)
}
