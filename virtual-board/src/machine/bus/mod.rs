//! The bus: all memories and peripherals, wired together.
//!
//! The core and the DMA controllers access it by address. It carries out the peripherals' events in order of time
//! ([`events`]), passes triggers, DMA requests and interrupt lines between them, and tells them when the clock changes.

pub mod events;
pub mod map;
pub mod remarks;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng};

use self::events::SOURCES;
use self::map::{TIMERS, Unit};
use self::remarks::Remarks;
use super::clock::{OscillatorErrors, Timebase};
use super::memory::{
    Block, CCM_BASE, CCM_SIZE, FLASH_BASE, FlashMemory, RAM_BASE, RAM_SIZE, SYSTEM_BASE,
};
use super::system_memory;
use crate::bench::pins::{BoardParameters, Pins};
use crate::peripherals::adc::{Adc, AdcCommon};
use crate::peripherals::crc::Crc;
use crate::peripherals::debug::Debug;
use crate::peripherals::dma::Dma;
use crate::peripherals::dmamux::Dmamux;
use crate::peripherals::exti::Exti;
use crate::peripherals::flash::{self, Flash};
use crate::peripherals::gpio::Gpio;
use crate::peripherals::iwdg::Iwdg;
use crate::peripherals::lpuart::Lpuart;
use crate::peripherals::nvic::Nvic;
use crate::peripherals::pwr::Pwr;
use crate::peripherals::rcc::{Clocks, HSI_HZ, Rcc, ResetCause};
use crate::peripherals::rng::Rng;
use crate::peripherals::syscfg::Syscfg;
use crate::peripherals::systick::SysTick;
use crate::peripherals::timer::{Shape, Timer};
use crate::peripherals::{Cycles, NEVER, Read, Unmodelled, Write};

/// Private peripheral bus of the core: system control, SysTick, DWT, debug.
const PPB: std::ops::RangeInclusive<u32> = 0xE000_0000..=0xE00F_FFFF;
/// The internal oscillator is off by up to this, relatively (data sheet, 0 to 85 °C).
const HSI_TOLERANCE: f64 = 0.01;

/// Streams of the seeded generator, so that no consumer's use shifts another's numbers.
enum Stream {
    Converter = 0, // to 4
    RandomNumbers = 8,
    Tearing = 9,
    PowerOnRam = 10,
    InternalOscillator = 11,
}

/// An access to an address at which there is nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NothingThere;

/// Everything but the core.
pub struct Bus {
    /// The instant up to which everything has happened.
    pub now: Cycles,
    /// Cycles to true time.
    pub timebase: Timebase,
    /// Interrupt controller and system control.
    pub nvic: Nvic,
    /// Cycle counter and debug.
    pub debug: Debug,
    /// The serial port.
    pub lpuart: Lpuart,
    /// The flash interface.
    pub flash: Flash,
    /// The flash memory.
    pub flash_memory: FlashMemory,
    /// The SRAM.
    pub ram: Block,
    /// The system memory.
    pub system: Block,
    /// The analog pins.
    pub pins: Pins,
    /// The watchdog.
    pub iwdg: Iwdg,
    /// What has been remarked on.
    pub remarks: Remarks,
    /// Where the core is, roughly, for remarks.
    pub near_pc: u32,
    /// A reset that must be carried out before the core goes on.
    pub reset_request: Option<ResetCause>,
    /// The core's clock has changed: instants in cycles are others now.
    pub clock_changed: bool,
    /// Writing the flash file failed.
    pub flash_file_failure: Option<std::io::Error>,
    parameters: BoardParameters,
    rcc: Rcc,
    clocks: Clocks,
    pwr: Pwr,
    syscfg: Syscfg,
    exti: Exti,
    gpio: [Gpio; 7],
    timers: [Timer; TIMERS.len()],
    adc: [Adc; 5],
    adc_common: [AdcCommon; 2],
    dma: [Dma; 2],
    dmamux: Dmamux,
    /// DMA channels that wait for a request: controller, channel, request.
    listening: Vec<(usize, usize, u8)>,
    rng: Rng,
    crc: Crc,
    systick: SysTick,
    deadlines: [Cycles; SOURCES],
    next_deadline: Cycles,
}

impl Bus {
    /// The chip at power-on.
    pub fn new(parameters: BoardParameters, pins: Pins, flash_memory: FlashMemory) -> Self {
        let seeded = |stream: u64| {
            let mut generator = ChaCha8Rng::seed_from_u64(parameters.seed);
            generator.set_stream(stream);
            generator
        };
        let unit =
            f64::from(seeded(Stream::InternalOscillator as u64).next_u32()) / f64::from(u32::MAX);
        let errors = OscillatorErrors {
            internal: HSI_TOLERANCE * (2.0 * unit - 1.0),
            crystal: parameters.clock_ppm * 1e-6,
        };
        let timebase = Timebase::new(errors, HSI_HZ);
        let core_hz = timebase.core_hz();
        let rcc = Rcc::new(ResetCause::PowerOn);
        let mut ram = Block::new(RAM_SIZE);
        fill(&mut ram, seeded(Stream::PowerOnRam as u64));
        Self {
            now: 0,
            timebase,
            nvic: Nvic::default(),
            debug: Debug::default(),
            lpuart: Lpuart::new(),
            flash: Flash::new(seeded(Stream::Tearing as u64), core_hz),
            flash_memory,
            ram,
            system: system_memory::build(parameters.unique_id, parameters.vrefint_v),
            pins,
            iwdg: Iwdg::new(core_hz),
            remarks: Remarks::default(),
            near_pc: 0,
            reset_request: None,
            clock_changed: false,
            flash_file_failure: None,
            clocks: rcc.clocks(),
            rcc,
            pwr: Pwr::default(),
            syscfg: Syscfg::default(),
            exti: Exti::default(),
            gpio: std::array::from_fn(Gpio::new),
            timers: std::array::from_fn(|index| Timer::new(shape(index))),
            adc: std::array::from_fn(|index| {
                Adc::new(
                    parameters.adc[index],
                    seeded(Stream::Converter as u64 + index as u64),
                )
            }),
            adc_common: Default::default(),
            dma: Default::default(),
            dmamux: Dmamux::default(),
            listening: Vec::new(),
            rng: Rng::new(seeded(Stream::RandomNumbers as u64), u64::from(HSI_HZ)),
            crc: Crc::default(),
            systick: SysTick::default(),
            deadlines: [NEVER; SOURCES],
            next_deadline: NEVER,
            parameters,
        }
    }

    /// A warm reset: everything but the memories, the line and the pins starts again.
    pub fn reset(&mut self, cause: ResetCause) {
        if let Err(error) = self.flash.reset(&mut self.flash_memory) {
            self.flash_file_failure = Some(error);
        }
        self.rcc.reset(cause);
        self.nvic = Nvic::default();
        self.debug = Debug::default();
        self.lpuart.reset();
        self.pwr = Pwr::default();
        self.syscfg = Syscfg::default();
        self.exti = Exti::default();
        self.gpio = std::array::from_fn(Gpio::new);
        self.timers.iter_mut().for_each(Timer::reset);
        self.adc.iter_mut().for_each(Adc::reset);
        self.adc_common = Default::default();
        self.dma = Default::default();
        self.dmamux = Dmamux::default();
        self.listening.clear();
        self.rng.reset();
        self.crc = Crc::default();
        self.systick = SysTick::default();
        self.change_clocks();
        self.iwdg = Iwdg::new(self.timebase.core_hz());
        self.refresh_all();
    }

    /// True time since power-on, s.
    pub fn now_s(&self) -> f64 {
        self.timebase.seconds(self.now)
    }

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

    /// The core stores into the flash memory.
    pub fn store_to_flash(&mut self, offset: usize, value: u32, size: usize) {
        self.flash
            .store(offset, value, size, &self.flash_memory, self.now);
        self.refresh(Unit::Flash);
    }

    /// The core reads from a bank that is watched.
    pub fn check_flash_read(&mut self, offset: usize) {
        if self.flash.check_read(offset) {
            self.nvic.pend(crate::peripherals::nvic::NMI);
        }
    }

    /// The core slept for this long.
    pub fn slept(&mut self, duration: Cycles) {
        self.debug.slept(duration);
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
            self.nvic.pend(crate::peripherals::nvic::HARD_FAULT);
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
    fn fetch(&mut self, address: u32, size: u32) -> Result<u32, NothingThere> {
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
    fn deliver(&mut self, address: u32, value: u32, size: u32) -> Result<(), NothingThere> {
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

    fn change_clocks(&mut self) {
        let clocks = self.rcc.clocks();
        if clocks == self.clocks {
            return;
        }
        let now = self.now;
        self.clocks = clocks;
        self.clock_changed = true;
        self.timebase.change(now, clocks.hclk, clocks.source);
        let core_hz = self.timebase.core_hz();
        self.rcc.set_core_clock(core_hz);
        self.iwdg.set_core_clock(core_hz, now);
        self.flash.set_core_clock(core_hz);
        self.rng.set_core_clock(u64::from(clocks.hclk));
        self.lpuart.set_clock(clocks.lpuart1, clocks.hclk);
        for (timer, place) in self.timers.iter_mut().zip(&TIMERS) {
            let clock = if place.base < 0x4001_0000 {
                clocks.apb1_timers
            } else {
                clocks.apb2_timers
            };
            timer.set_clock(u64::from((clocks.hclk / clock.max(1)).max(1)), now);
        }
        self.set_converter_clocks();
        self.refresh_all();
        self.check_limits();
    }

    fn set_converter_clocks(&mut self) {
        let clocks = self.clocks;
        for (index, adc) in self.adc.iter_mut().enumerate() {
            let (common, kernel) = if index < 2 {
                (&self.adc_common[0], clocks.adc12)
            } else {
                (&self.adc_common[1], clocks.adc345)
            };
            adc.set_clock(common.clock(kernel, clocks.hclk), clocks.hclk);
        }
    }

    /// A chip outside of its limits may do anything; the model goes on, and says so.
    fn check_limits(&mut self) {
        let hclk = self.clocks.hclk;
        let now_s = self.now_s();
        let limit = self.pwr.max_core_hz();
        if hclk > limit {
            let detail = format!("{hclk} Hz, but the voltage range of PWR_CR5 allows {limit} Hz");
            self.remarks.state(now_s, "the core is too fast", &detail);
        }
        let per_wait_state = if limit == 150_000_000 {
            30_000_000
        } else {
            34_000_000
        };
        let needed = hclk.div_ceil(per_wait_state).saturating_sub(1);
        if self.flash.wait_states() < needed {
            let detail = format!(
                "{} are set, {hclk} Hz need {needed}",
                self.flash.wait_states()
            );
            self.remarks
                .state(now_s, "too few wait states of the flash memory", &detail);
        }
    }
}

fn shape(index: usize) -> Shape {
    match TIMERS[index].number {
        2 | 5 => Shape::GENERAL_32,
        3 | 4 => Shape::GENERAL_16,
        15 => Shape::TWO_CHANNELS,
        16 | 17 => Shape::ONE_CHANNEL,
        _ => Shape::BASIC,
    }
}

/// SRAM comes up with whatever its cells fall into.
fn fill(ram: &mut Block, mut noise: ChaCha8Rng) {
    let mut content = vec![0; ram.size()];
    noise.fill_bytes(&mut content);
    assert!(ram.write(0, &content), "sizes agree");
}

/// Bytes of flash memory, for callers that map it.
pub const FLASH_SIZE: usize = flash::SIZE;
