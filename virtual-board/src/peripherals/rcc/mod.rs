//! Reset and clock control (RM0440 chapter 7): oscillators, PLL, prescalers, gating, peripheral resets, reset causes.
//!
//! ```text
//! f_VCO = f_source / M · N      SYSCLK = HSI16, HSE or f_VCO / R      HCLK = SYSCLK / HPRE
//! ```
//!
//! The board's crystal is 24 MHz. Oscillators become ready after the typical start-up times of the data sheet
//! (DS12288); a switch of the system clock waits for its source. Oscillator interrupts are not modelled.
//!
//! A crystal that stops leaves the PLL without its input: it drifts to a fraction of its frequency and clocks the chip
//! on. The clock security system (7.2.8), when it is on, finds that at once: it switches the crystal and its PLL off,
//! takes the internal oscillator, and raises the non-maskable interrupt, here once and not until CSSF is cleared.

mod clocks;
mod tree;

pub use self::clocks::{Clocks, Source};

use super::{Cycles, NEVER, NO_SUCH_REGISTER, Read, Unmodelled, Write, bit, field};

/// Frequency of the high-speed internal oscillator, Hz.
pub const HSI_HZ: u32 = 16_000_000;
/// Frequency of the board's crystal, Hz.
pub const HSE_HZ: u32 = 24_000_000;

const REGISTERS: usize = 0xA0 / 4;
const CR: usize = 0;
const ICSCR: usize = 1;
const CFGR: usize = 0x08 / 4;
const PLLCFGR: usize = 0x0C / 4;
const AHB1ENR: usize = 0x48 / 4;
const BDCR: usize = 0x90 / 4;
const CSR: usize = 0x94 / 4;
const CRRCR: usize = 0x98 / 4;
// CR
const HSION: u32 = 8;
const HSEON: u32 = 16;
const CSSON: u32 = 19;
const PLLON: u32 = 24;
/// CIFR, and the bit that clears it in CICR.
const CSSF: u32 = 1 << 8;

/// The oscillators: register and bits (on, ready) of each, and its start-up time, s.
const OSCILLATORS: [(usize, u32, u32, f64); 6] = [
    (CR, 8, 10, 1.0e-6),   // HSI16
    (CR, 16, 17, 2.0e-3),  // HSE
    (CR, 24, 25, 15.0e-6), // PLL
    (CSR, 0, 1, 130.0e-6), // LSI
    (BDCR, 0, 1, 2.0),     // LSE
    (CRRCR, 0, 1, 3.0e-6), // HSI48
];
const HSI: usize = 0;
const HSE: usize = 1;
const PLL: usize = 2;
const HSI48: usize = 5;

/// Why the chip was reset; the bit of RCC_CSR that says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResetCause {
    /// Power came on (BORRSTF; every reset also sets PINRSTF).
    PowerOn,
    /// The supply dipped (BORRSTF too; only the RAM may tell).
    BrownOut,
    /// A person pulled NRST low.
    Pin,
    /// SYSRESETREQ (SFTRSTF).
    Software,
    /// The independent watchdog (IWDGRSTF).
    IndependentWatchdog,
    /// Reloading of the option bytes (OBLRSTF).
    OptionBytes,
}

impl ResetCause {
    fn flags(self) -> u32 {
        let pin = 1 << 26;
        pin | match self {
            Self::PowerOn | Self::BrownOut => 1 << 27,
            Self::Pin => 0,
            Self::Software => 1 << 28,
            Self::IndependentWatchdog => 1 << 29,
            Self::OptionBytes => 1 << 25,
        }
    }
}

/// The controller.
#[derive(Debug)]
pub struct Rcc {
    registers: [u32; REGISTERS],
    ready_at: [Cycles; OSCILLATORS.len()],
    core_hz: f64,
    /// The crystal works.
    crystal: bool,
    /// A crystal that does not work does so again after the next reset.
    crystal_returns: bool,
    /// What the PLL divides the frequency of its missing input by; 1 while the crystal works.
    drift: u32,
    /// The flag of the clock security system.
    cssf: u32,
    /// The 48 MHz oscillator works.
    hsi48: bool,
}

impl Rcc {
    /// The controller after a reset for the given cause.
    pub fn new(cause: ResetCause) -> Self {
        let mut registers = [0; REGISTERS];
        registers[CR] = 0x0000_0100;
        registers[ICSCR] = 0x4000_0000;
        registers[CFGR] = 0x0000_0005;
        registers[PLLCFGR] = 0x0000_1000;
        registers[AHB1ENR] = 0x0000_0100;
        registers[CSR] = cause.flags();
        let mut ready_at = [NEVER; OSCILLATORS.len()];
        ready_at[HSI] = 0;
        Self {
            registers,
            ready_at,
            core_hz: f64::from(HSI_HZ),
            crystal: true,
            crystal_returns: false,
            drift: 1,
            cssf: 0,
            hsi48: true,
        }
    }

    /// The controller after a reset: earlier causes stay until the firmware removes them, or the supply dips.
    pub fn reset(&mut self, cause: ResetCause) {
        let earlier = match cause {
            ResetCause::PowerOn | ResetCause::BrownOut => 0,
            _ => self.registers[CSR] & 0xFE00_0000,
        };
        let works = self.crystal || self.crystal_returns;
        *self = Self {
            crystal: works,
            drift: if works { 1 } else { self.drift },
            hsi48: self.hsi48,
            ..Self::new(cause)
        };
        self.registers[CSR] |= earlier;
    }

    /// The crystal stops, for good or until the next reset; a PLL that it drives runs on at `1 / drift` of its frequency.
    /// True when the clock security system finds it, which raises the non-maskable interrupt.
    pub fn stop_crystal(&mut self, drift: u32, returns: bool, now: Cycles) -> bool {
        self.settle(now);
        let watched = bit(self.registers[CR], CSSON) && now >= self.ready_at[HSE];
        (self.crystal, self.crystal_returns) = (false, returns);
        self.drift = drift;
        self.ready_at[HSE] = NEVER;
        if watched {
            self.fall_back(now);
        }
        watched
    }

    /// What the clock security system does.
    fn fall_back(&mut self, now: Cycles) {
        const SW_AND_SWS: u32 = 0xF;
        const HSI_IS_USED: u32 = 1 | 1 << 2;
        let on_crystal = match field(self.registers[CFGR], 2, 2) {
            2 => true,
            3 => self.pll_source() == Source::Crystal,
            _ => false,
        };
        if on_crystal {
            self.registers[CFGR] = self.registers[CFGR] & !SW_AND_SWS | HSI_IS_USED;
        }
        if self.pll_source() == Source::Crystal {
            self.registers[CR] &= !(1 << PLLON);
            self.ready_at[PLL] = NEVER;
        }
        self.registers[CR] = self.registers[CR] & !(1 << HSEON) | 1 << HSION;
        self.ready_at[HSI] = self.ready_at[HSI].min(now);
        self.cssf = CSSF;
    }

    /// Whether the system clock is the crystal's own: such a core stands still when it stops.
    pub fn runs_on_crystal_itself(&self) -> bool {
        field(self.registers[CFGR], 2, 2) == 2
    }

    /// The 48 MHz oscillator stops and never starts again.
    pub fn stop_hsi48(&mut self) {
        self.hsi48 = false;
        self.ready_at[HSI48] = NEVER;
    }

    /// Sets the frequency of the core, for the start-up times of oscillators.
    pub fn set_core_clock(&mut self, core_hz: f64) {
        self.core_hz = core_hz;
    }

    /// Reads a register.
    pub fn read(&mut self, offset: u32, now: Cycles) -> Read {
        self.settle(now);
        let index = offset as usize / 4;
        match offset {
            0x1C => Ok(self.cssf),
            0x20 => Ok(0),
            _ => self
                .registers
                .get(index)
                .map(|value| value | self.ready_bits(index, now))
                .ok_or(NO_SUCH_REGISTER),
        }
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, now: Cycles) -> Write {
        self.settle(now);
        let index = offset as usize / 4;
        let old = *self.registers.get(index).ok_or(NO_SUCH_REGISTER)?;
        let value = value & !ready_mask(index);
        self.registers[index] = match index {
            CFGR => (value & !0xC) | (old & 0xC),
            PLLCFGR if self.pll_locked(old, value) => {
                return Err(Unmodelled("change of a running PLL"));
            }
            CSR if bit(value, 23) => value & 1,
            CSR => (old & 0xFE00_0000) | (value & 1),
            // Only a reset switches the clock security system off.
            CR => value | (old & 1 << CSSON),
            _ => value,
        };
        self.switch_oscillators(index, old, now);
        self.settle(now);
        match offset {
            0x18 if value != 0 => Err(Unmodelled("interrupts of oscillators")),
            0x20 => {
                self.cssf &= !value;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Whether bit `index` of the enable register at `offset` is set: a peripheral without clock cannot be accessed.
    pub fn enabled(&self, offset: u32, index: u32) -> bool {
        bit(self.registers[offset as usize / 4], index)
    }

    /// Whether the 48 MHz oscillator runs.
    pub fn hsi48_ready(&self, now: Cycles) -> bool {
        now >= self.ready_at[HSI48]
    }

    /// Switches the system clock to its new source when that is ready.
    fn settle(&mut self, now: Cycles) {
        let wanted = field(self.registers[CFGR], 0, 2);
        let source = [None, Some(HSI), Some(HSE), Some(PLL)][wanted as usize];
        let pll_output_off = wanted == 3 && !bit(self.registers[PLLCFGR], 24);
        if source.is_some_and(|source| now >= self.ready_at[source]) && !pll_output_off {
            self.registers[CFGR] = (self.registers[CFGR] & !0xC) | (wanted << 2);
        }
    }

    fn switch_oscillators(&mut self, index: usize, old: u32, now: Cycles) {
        for (oscillator, &(register, on, _, start_s)) in OSCILLATORS.iter().enumerate() {
            if register != index {
                continue;
            }
            let in_use =
                [None, Some(HSI), Some(HSE), Some(PLL)][field(self.registers[CFGR], 2, 2) as usize];
            if in_use == Some(oscillator) && bit(old, on) {
                self.registers[index] |= 1 << on; // the clock in use cannot be switched off
            } else if oscillator == HSE && !self.crystal || oscillator == HSI48 && !self.hsi48 {
                // It does not start.
            } else if bit(self.registers[index] & !old, on) {
                self.ready_at[oscillator] = now + (start_s * self.core_hz) as Cycles;
            } else if !bit(self.registers[index], on) {
                self.ready_at[oscillator] = NEVER;
            }
        }
    }

    fn ready_bits(&self, index: usize, now: Cycles) -> u32 {
        OSCILLATORS
            .iter()
            .zip(&self.ready_at)
            .filter(|((register, ..), ready_at)| *register == index && now >= **ready_at)
            .fold(0, |bits, ((_, _, ready, _), _)| bits | 1 << ready)
    }

    /// The PLL's factors may change only while it is off; its outputs may be switched at any time.
    fn pll_locked(&self, old: u32, value: u32) -> bool {
        const OUTPUTS: u32 = 1 << 16 | 1 << 20 | 1 << 24;
        bit(self.registers[CR], 24) && (old ^ value) & !OUTPUTS != 0
    }
}

/// The bits of a register that only the hardware sets.
fn ready_mask(index: usize) -> u32 {
    OSCILLATORS
        .iter()
        .filter(|(register, ..)| *register == index)
        .fold(0, |bits, (_, _, ready, _)| bits | 1 << ready)
}
