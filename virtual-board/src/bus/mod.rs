//! The bus: all memories and peripherals, wired together.
//!
//! The core and the DMA controllers access it by address. It carries out the peripherals' events in order of time
//! ([`events`]), passes triggers, DMA requests and interrupt lines between them, and tells them when the clock changes.

mod access;
mod clocks;
pub mod events;
mod injected;
pub mod map;
pub mod remarks;
pub mod timebase;
pub mod triggers;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng};

use self::events::SOURCES;
use self::injected::Stalls;
use self::map::{TIMERS, Unit};
use self::remarks::Remarks;
use self::timebase::{OscillatorErrors, Timebase};
use self::triggers::Triggers;
use crate::memory::block::Block;
use crate::memory::flash::FlashMemory;
use crate::memory::{RAM_SIZE, system};
use crate::peripherals::adc::{Adc, AdcCommon};
use crate::peripherals::crc::Crc;
use crate::peripherals::debug::Debug;
use crate::peripherals::dma::Dma;
use crate::peripherals::dmamux::Dmamux;
use crate::peripherals::exti::Exti;
use crate::peripherals::flash::Flash;
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
use crate::peripherals::{Cycles, NEVER};
use crate::pins::{BoardParameters, Pins};

/// Largest relative error of the internal oscillator (data sheet, 0 to 85 °C).
const HSI_TOLERANCE: f64 = 0.01;

/// Streams of the seeded generator: the use of one stream does not shift the numbers of another.
enum Stream {
    Converter = 0, // to 4
    RandomNumbers = 8,
    Tearing = 9,
    PowerOnRam = 10,
    InternalOscillator = 11,
}

/// An access to an address without memory or peripheral.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NothingThere;

/// Everything but the core.
pub struct Bus {
    /// The instant up to which all events have been carried out.
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
    /// When the converters were triggered.
    pub triggers: Triggers,
    /// Remarks that have been printed.
    pub remarks: Remarks,
    /// Approximate program counter of the core, for remarks.
    pub near_pc: u32,
    /// A reset that must be carried out before the core goes on.
    pub reset_request: Option<ResetCause>,
    /// The core's clock has changed, so that instants in cycles have changed too.
    pub clock_changed: bool,
    /// Writing the flash file failed.
    pub flash_file_failure: Option<std::io::Error>,
    parameters: BoardParameters,
    rcc: Rcc,
    clocks: Clocks,
    /// When the system clock was last switched, s.
    switched_s: f64,
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
    stalls: Stalls,
    /// Content of the SRAM after a loss of power.
    ram_noise: ChaCha8Rng,
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
        let mut ram_noise = seeded(Stream::PowerOnRam as u64);
        fill(&mut ram, &mut ram_noise);
        let clocks = rcc.clocks();
        let mut bus = Self {
            now: 0,
            timebase,
            nvic: Nvic::default(),
            debug: Debug::default(),
            lpuart: Lpuart::new(),
            flash: Flash::new(seeded(Stream::Tearing as u64), core_hz),
            flash_memory,
            ram,
            system: system::build(parameters.unique_id, parameters.vrefint_v),
            pins,
            iwdg: Iwdg::new(core_hz),
            remarks: Remarks::default(),
            triggers: Triggers::default(),
            near_pc: 0,
            reset_request: None,
            clock_changed: false,
            flash_file_failure: None,
            clocks,
            switched_s: 0.0,
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
            stalls: Stalls::default(),
            ram_noise,
            deadlines: [NEVER; SOURCES],
            next_deadline: NEVER,
            parameters,
        };
        bus.apply_clocks(clocks);
        bus
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

    /// The core stores into the flash memory.
    pub fn store_to_flash(&mut self, offset: usize, value: u32, size: usize) {
        self.flash
            .store(offset, value, size, &self.flash_memory, self.now);
        self.refresh(Unit::Flash);
    }

    /// The core reads from a bank that is watched.
    pub fn check_flash_read(&mut self, offset: usize) {
        if self.flash.check_read(offset, &self.flash_memory) {
            self.nvic.pend(crate::peripherals::nvic::NMI);
        }
        self.refresh(Unit::Flash);
    }

    /// Whether reads of a bank of flash must be looked at.
    pub fn is_watched(&self, bank: usize) -> bool {
        self.flash.watched(bank, &self.flash_memory)
    }

    /// The core slept for this long.
    pub fn slept(&mut self, duration: Cycles) {
        self.debug.slept(duration);
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

/// Fills the SRAM with random content, as after power-on.
fn fill(ram: &mut Block, noise: &mut ChaCha8Rng) {
    let mut content = vec![0; ram.size()];
    noise.fill_bytes(&mut content);
    assert!(ram.write(0, &content), "sizes agree");
}
