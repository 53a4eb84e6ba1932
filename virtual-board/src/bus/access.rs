//! Access to registers and memories by address, as the core and the DMA controllers do it.

use super::map::{self, Unit};
use super::{Bus, NothingThere};
use crate::memory::{CCM_BASE, CCM_SIZE, FLASH_BASE, RAM_BASE, RAM_SIZE, SYSTEM_BASE};
use crate::peripherals::adc::{Adc, AdcCommon};
use crate::peripherals::crc::Crc;
use crate::peripherals::dma::Dma;
use crate::peripherals::dmamux::Dmamux;
use crate::peripherals::gpio::Gpio;
use crate::peripherals::nvic::HARD_FAULT;
use crate::peripherals::pwr::Pwr;
use crate::peripherals::rcc::ResetCause;
use crate::peripherals::syscfg::Syscfg;
use crate::peripherals::{Read, Unmodelled, Write};

/// Private peripheral bus of the core: system control, SysTick, DWT, debug.
const PPB: std::ops::RangeInclusive<u32> = 0xE000_0000..=0xE00F_FFFF;

impl Bus {
    /// The core reads `size` bytes of a register.
    pub fn read(&mut self, address: u32, size: u32) -> u32 {
        let value = self.read_register(address, size);
        self.settle();
        value
    }

    /// The core writes `size` bytes of a register.
    pub fn write(&mut self, address: u32, value: u32, size: u32) {
        self.write_register(address, value, size);
        self.settle();
    }

    fn read_register(&mut self, address: u32, size: u32) -> u32 {
        let found = if PPB.contains(&address) {
            self.read_private(address, size)
        } else {
            // Registers are words; a part of one is read by reading it whole.
            self.read_unit(address & !3)
                .map(|word| word >> (8 * (address & 3)) & (u32::MAX >> (32 - 8 * size)))
        };
        found.unwrap_or_else(|Unmodelled(why)| {
            self.remark(address, None, why);
            0
        })
    }

    fn write_register(&mut self, address: u32, value: u32, size: u32) {
        let done = if PPB.contains(&address) {
            self.write_private(address, value, size)
        } else {
            self.write_unit(address, value, size)
        };
        if let Err(Unmodelled(why)) = done {
            self.remark(address, Some(value), why);
        }
    }

    fn remark(&mut self, address: u32, write: Option<u32>, why: &'static str) {
        let what = match map::locate(address) {
            Some((unit, offset)) => format!("{}+{offset:#04x}", unit.name()),
            None => "a register".to_owned(),
        };
        self.remarks.access(
            self.timebase.seconds(self.now),
            self.near_pc,
            address,
            write,
            &what,
            why,
        );
    }

    fn clocked(&self, unit: Unit) -> bool {
        unit.clock()
            .is_none_or(|(register, index)| self.rcc.enabled(register, index))
    }

    fn read_unit(&mut self, address: u32) -> Read {
        let (unit, offset) =
            map::locate(address).ok_or(Unmodelled("no such peripheral in the model"))?;
        if !self.clocked(unit) {
            return Err(Unmodelled("its clock is off (RCC)"));
        }
        let now = self.now;
        match unit {
            Unit::Timer(index) => {
                self.timers[index].advance(now);
                self.timers[index].read(offset, now)
            }
            Unit::Iwdg => self.iwdg.read(offset, now),
            Unit::Pwr => self.pwr.read(offset),
            Unit::Lpuart1 => self.lpuart.read(offset).inspect(|_| self.refresh(unit)),
            Unit::Syscfg => self.syscfg.read(offset),
            Unit::Exti => self.exti.read(offset),
            Unit::Dma(index) => self.dma[index].read(offset),
            Unit::Dmamux => self.dmamux.read(offset),
            Unit::Rcc => self.rcc.read(offset, now).inspect(|_| self.change_clocks()),
            Unit::Flash => self.flash.read(offset),
            Unit::Crc => self.crc.read(offset),
            Unit::Gpio(index) => self.gpio[index].read(offset),
            Unit::Adc(index) => self.adc[index].read(offset).inspect(|_| self.refresh(unit)),
            Unit::AdcCommon(index) => self.adc_common[index].read(offset),
            Unit::Rng => {
                let clocked = self.rcc.hsi48_ready(now);
                self.rng
                    .read(offset, now, clocked)
                    .inspect(|_| self.refresh(unit))
            }
        }
    }

    fn write_unit(&mut self, address: u32, value: u32, size: u32) -> Write {
        let (unit, offset) =
            map::locate(address).ok_or(Unmodelled("no such peripheral in the model"))?;
        if !self.clocked(unit) {
            return Err(Unmodelled("its clock is off (RCC)"));
        }
        if address & 3 != 0 {
            return Err(Unmodelled("write to a part of a register"));
        }
        let now = self.now;
        let done = match unit {
            Unit::Timer(index) => {
                self.timers[index].advance(now);
                self.timers[index].write(offset, value, now)
            }
            Unit::Iwdg => self.iwdg.write(offset, value, now),
            Unit::Pwr => self
                .pwr
                .write(offset, value)
                .inspect(|()| self.check_limits()),
            Unit::Lpuart1 => self.lpuart.write(offset, value, now),
            Unit::Syscfg => self.syscfg.write(offset, value),
            Unit::Exti => self.exti.write(offset, value),
            Unit::Dma(index) => self.dma[index].write(offset, value),
            Unit::Dmamux => self.dmamux.write(offset, value),
            Unit::Rcc => self.write_clock_control(offset, value),
            Unit::Flash => self.write_flash_control(offset, value),
            Unit::Crc => self.crc.write(offset, value, size),
            Unit::Gpio(index) => self.gpio[index].write(offset, value),
            Unit::Adc(index) => self.adc[index].write(offset, value, now),
            Unit::AdcCommon(index) => {
                let members = if index == 0 { 0..2 } else { 2..5 };
                let any_enabled = self.adc[members].iter().any(Adc::enabled);
                let done = self.adc_common[index].write(offset, value, any_enabled);
                self.set_converter_clocks();
                done
            }
            Unit::Rng => self.rng.write(offset, value, now),
        };
        self.refresh(unit);
        done
    }

    fn write_flash_control(&mut self, offset: u32, value: u32) -> Write {
        let done = self.flash.write(offset, value, self.now);
        if self.flash.take_bus_error() {
            self.nvic.pend(HARD_FAULT);
        }
        if self.flash.option_bytes_reload() {
            self.reset_request = Some(ResetCause::OptionBytes);
        }
        done
    }

    fn write_clock_control(&mut self, offset: u32, value: u32) -> Write {
        let done = self.rcc.write(offset, value, self.now);
        for unit in Unit::reset_by(offset, value) {
            self.reset_unit(unit);
        }
        self.change_clocks();
        done
    }

    fn reset_unit(&mut self, unit: Unit) {
        match unit {
            Unit::Timer(index) => self.timers[index].reset(),
            Unit::Pwr => self.pwr = Pwr::default(),
            Unit::Lpuart1 => self.lpuart.reset(),
            Unit::Syscfg => self.syscfg = Syscfg::default(),
            Unit::Dma(index) => self.dma[index] = Dma::default(),
            Unit::Dmamux => self.dmamux = Dmamux::default(),
            Unit::Crc => self.crc = Crc::default(),
            Unit::Gpio(index) => self.gpio[index] = Gpio::new(index),
            Unit::Adc(index) => self.adc[index].reset(),
            Unit::AdcCommon(index) => self.adc_common[index] = AdcCommon::default(),
            Unit::Rng => self.rng.reset(),
            Unit::Flash | Unit::Iwdg | Unit::Exti | Unit::Rcc => {}
        }
        self.refresh(unit);
    }

    fn read_private(&mut self, address: u32, size: u32) -> Read {
        let now = self.now;
        match address {
            0xE000_1000..=0xE000_1FFF => self.debug.read_dwt(address & 0xFFF, now),
            0xE000_E010..=0xE000_E01F => self.systick.read(address - 0xE000_E010, now),
            0xE000_EDFC => Ok(self.debug.demcr()),
            0xE000_E000..=0xE000_EFFF => self.nvic.read(address & 0xFFF, size),
            0xE004_2000..=0xE004_23FF => self.debug.read_dbgmcu(address & 0x3FF),
            _ => Err(Unmodelled("no such block in the model of the core")),
        }
    }

    fn write_private(&mut self, address: u32, value: u32, size: u32) -> Write {
        let now = self.now;
        match address {
            0xE000_1000..=0xE000_1FFF => self.debug.write_dwt(address & 0xFFF, value, now),
            0xE000_E010..=0xE000_E01F => {
                let done = self.systick.write(address - 0xE000_E010, value, now);
                self.refresh_systick();
                done
            }
            0xE000_EDFC => {
                self.debug.write_demcr(value, now);
                Ok(())
            }
            0xE000_E000..=0xE000_EFFF => {
                let done = self.nvic.write(address & 0xFFF, value, size);
                if self.nvic.take_reset_request() {
                    self.reset_request = Some(ResetCause::Software);
                }
                done
            }
            0xE004_2000..=0xE004_23FF => self.debug.write_dbgmcu(address & 0x3FF, value),
            _ => Err(Unmodelled("no such block in the model of the core")),
        }
    }

    /// Reads as a DMA controller does: memory or register.
    pub(super) fn fetch(&mut self, address: u32, size: u32) -> Result<u32, NothingThere> {
        let mut bytes = [0; 4];
        let into = &mut bytes[..size as usize];
        let found = match address {
            0x4000_0000..=0x5FFF_FFFF => return Ok(self.read_register(address, size)),
            RAM_BASE..=0x2001_FFFF => self.ram.read((address - RAM_BASE) as usize, into),
            CCM_BASE..=0x1000_7FFF => self
                .ram
                .read(RAM_SIZE - CCM_SIZE + (address - CCM_BASE) as usize, into),
            FLASH_BASE..=0x0807_FFFF => self
                .flash_memory
                .block()
                .read((address - FLASH_BASE) as usize, into),
            SYSTEM_BASE..=0x1FFF_7FFF => self.system.read((address - SYSTEM_BASE) as usize, into),
            _ => false,
        };
        if found {
            Ok(u32::from_le_bytes(bytes))
        } else {
            Err(NothingThere)
        }
    }

    /// Writes as a DMA controller does.
    pub(super) fn deliver(
        &mut self,
        address: u32,
        value: u32,
        size: u32,
    ) -> Result<(), NothingThere> {
        let bytes = &value.to_le_bytes()[..size as usize];
        let done = match address {
            0x4000_0000..=0x5FFF_FFFF => {
                self.write_register(address, value, size);
                true
            }
            RAM_BASE..=0x2001_FFFF => self.ram.write((address - RAM_BASE) as usize, bytes),
            CCM_BASE..=0x1000_7FFF => self
                .ram
                .write(RAM_SIZE - CCM_SIZE + (address - CCM_BASE) as usize, bytes),
            _ => false,
        };
        if done { Ok(()) } else { Err(NothingThere) }
    }
}
