//! The clock tree: from the registers to frequencies.

use super::clocks::{Clocks, Source};
use super::{CFGR, HSE_HZ, HSI_HZ, PLLCFGR, Rcc};
use crate::peripherals::{bit, field};

const LSE_HZ: u32 = 32_768;
const CCIPR: usize = 0x88 / 4;

impl Rcc {
    /// The clock tree as it is now.
    pub fn clocks(&self) -> Clocks {
        let cfgr = self.registers[CFGR];
        let (system, source) = match field(cfgr, 2, 2) {
            2 => (HSE_HZ, Source::Crystal),
            3 => (self.pll_output(24, 25), self.pll_source()),
            _ => (HSI_HZ, Source::Internal),
        };
        let hclk = system / ahb_divider(field(cfgr, 4, 4));
        let (apb1, apb2) = (
            apb_divider(field(cfgr, 8, 3)),
            apb_divider(field(cfgr, 11, 3)),
        );
        // Timers run at twice a divided bus clock (RM0440 7.2.14).
        let timers = |divider: u32| {
            if divider == 1 {
                hclk
            } else {
                2 * hclk / divider
            }
        };
        let ccipr = self.registers[CCIPR];
        let adc = |selection| match selection {
            1 => self.pll_p_output(),
            2 => system,
            _ => 0,
        };
        Clocks {
            source,
            system,
            hclk,
            apb1_timers: timers(apb1),
            apb2_timers: timers(apb2),
            lpuart1: [hclk / apb1, system, HSI_HZ, LSE_HZ][field(ccipr, 10, 2) as usize],
            adc12: adc(field(ccipr, 28, 2)),
            adc345: adc(field(ccipr, 30, 2)),
        }
    }

    pub(super) fn pll_source(&self) -> Source {
        if field(self.registers[PLLCFGR], 0, 2) == 3 {
            Source::Crystal
        } else {
            Source::Internal
        }
    }

    fn vco_hz(&self) -> u64 {
        let pllcfgr = self.registers[PLLCFGR];
        let input = match field(pllcfgr, 0, 2) {
            2 => HSI_HZ,
            3 => HSE_HZ / self.drift,
            _ => 0,
        };
        u64::from(input) * u64::from(field(pllcfgr, 8, 7)) / u64::from(field(pllcfgr, 4, 4) + 1)
    }

    /// Output Q or R: enable bit, and the lowest bit of the two that divide by 2, 4, 6 or 8.
    fn pll_output(&self, enable: u32, divider: u32) -> u32 {
        let pllcfgr = self.registers[PLLCFGR];
        let divider = u64::from(2 * (field(pllcfgr, divider, 2) + 1));
        if bit(pllcfgr, enable) {
            (self.vco_hz() / divider) as u32
        } else {
            0
        }
    }

    fn pll_p_output(&self) -> u32 {
        let pllcfgr = self.registers[PLLCFGR];
        let divider = match (field(pllcfgr, 27, 5), bit(pllcfgr, 17)) {
            (0, false) => 7,
            (0, true) => 17,
            (divider, _) => u64::from(divider),
        };
        if bit(pllcfgr, 16) {
            (self.vco_hz() / divider) as u32
        } else {
            0
        }
    }
}

fn ahb_divider(code: u32) -> u32 {
    match code {
        0..=7 => 1,
        8..=11 => 2 << (code - 8),
        _ => 64 << (code - 12),
    }
}

fn apb_divider(code: u32) -> u32 {
    if code < 4 { 1 } else { 2 << (code - 4) }
}
