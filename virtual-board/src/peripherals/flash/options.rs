//! Option registers of the flash (RM0440 3.4, 3.7.8 to 3.7.17), as they are loaded at a reset: set from outside, as a debug
//! probe does it, and only read by the firmware.
//!
//! | option | effect in the model |
//! |---|---|
//! | OPTR.DBANK | with 0 the flash is one bank of 128 pages of 4 KB: an operation keeps all of it busy, a page number counts from the begin of the flash, and BKER has no meaning |
//! | WRP1AR, WRP1BR, WRP2AR, WRP2BR | pages from STRT to END cannot be programmed or erased (WRPERR): of bank 1 (WRP1) or 2 (WRP2), with one bank of the whole flash |
//!
//! The other options can be read and have no effect.

use std::ops::Range;
use std::str::FromStr;

use crate::memory::{BANK_SIZE, PAGE_SIZE};
use crate::peripherals::{bit, field};

const DBANK: u32 = 22;
/// Names of the registers of write protection, in the order of [`Options::write_protection`].
const AREAS: [&str; 4] = ["WRP1AR", "WRP1BR", "WRP2AR", "WRP2BR"];

/// The option registers.
#[derive(Debug, Clone)]
pub struct Options {
    /// OPTR.
    pub(super) optr: u32,
    /// WRP1AR, WRP1BR, WRP2AR, WRP2BR.
    pub(super) write_protection: [u32; 4],
}

impl Default for Options {
    /// Factory setting: dual bank, watchdogs started by software, no protection.
    fn default() -> Self {
        Self {
            optr: 0xFFEF_F8AA,
            write_protection: [0xFF00_FFFF; 4],
        }
    }
}

/// One register and its value, `NAME=0xVALUE`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    name: String,
    value: u32,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "expected NAME=0xVALUE with OPTR, {}, such as OPTR=0xffaff8aa",
                AREAS.join(", ")
            )
        };
        let (name, value) = text.split_once("=0x").ok_or_else(expected)?;
        let value = u32::from_str_radix(value, 16).map_err(|_| expected())?;
        if name != "OPTR" && !AREAS.contains(&name) {
            return Err(expected());
        }
        Ok(Self {
            name: name.to_owned(),
            value,
        })
    }
}

impl Options {
    /// Sets one register.
    pub fn set(&mut self, setting: &Setting) {
        match AREAS.iter().position(|area| *area == setting.name) {
            Some(area) => self.write_protection[area] = setting.value,
            None => self.optr = setting.value,
        }
    }

    /// Whether the flash has two banks.
    pub(super) fn dual_bank(&self) -> bool {
        bit(self.optr, DBANK)
    }

    /// The page that an erasure with this page number and bank selection means, in bytes of the flash.
    pub(super) fn page(&self, number: usize, second_bank: bool) -> Range<usize> {
        let size = self.page_size();
        let bank = if self.dual_bank() && second_bank {
            BANK_SIZE
        } else {
            0
        };
        let start = bank + number * size;
        start..start + size
    }

    /// Whether a byte of this range is protected from writing.
    pub(super) fn protects(&self, range: &Range<usize>) -> bool {
        self.write_protection
            .iter()
            .enumerate()
            .any(|(index, register)| {
                let bank = if self.dual_bank() {
                    index / 2 * BANK_SIZE
                } else {
                    0
                };
                let page = |lowest| field(*register, lowest, 7) as usize;
                let (first, last) = (page(0), page(16));
                let size = self.page_size();
                // An area that ends before it begins is none.
                first <= last
                    && range.start < bank + (last + 1) * size
                    && bank + first * size < range.end
            })
    }

    fn page_size(&self) -> usize {
        if self.dual_bank() {
            PAGE_SIZE
        } else {
            2 * PAGE_SIZE
        }
    }
}
