//! The memory map (RM0440 2.2.2): the peripheral at an address, its name, its clock enable bit, its interrupt.

/// A peripheral that the model has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Index into [`TIMERS`].
    Timer(usize),
    /// Independent watchdog.
    Iwdg,
    /// Power control.
    Pwr,
    /// Low-power UART.
    Lpuart1,
    /// System configuration.
    Syscfg,
    /// Extended interrupts.
    Exti,
    /// 0 is DMA1.
    Dma(usize),
    /// DMA request multiplexer.
    Dmamux,
    /// Reset and clock control.
    Rcc,
    /// Flash interface.
    Flash,
    /// CRC unit.
    Crc,
    /// 0 is port A.
    Gpio(usize),
    /// 0 is ADC1.
    Adc(usize),
    /// 0 is shared by ADC1 and ADC2, 1 by ADC3 to ADC5.
    AdcCommon(usize),
    /// Random number generator.
    Rng,
}

/// A timer's place in the chip.
pub struct TimerPlace {
    /// Number in its name.
    pub number: u32,
    /// Address of its registers.
    pub base: u32,
    /// Offset of the enable register in the RCC, and bit.
    pub clock: (u32, u32),
    /// Interrupt number.
    pub interrupt: usize,
    /// Number of its trigger output in EXTSEL of the converters (RM0440 tables 163 and 164).
    pub adc_trigger: Option<u32>,
}

const AHB1ENR: u32 = 0x48;
const AHB2ENR: u32 = 0x4C;
const APB1ENR1: u32 = 0x58;
const APB1ENR2: u32 = 0x5C;
const APB2ENR: u32 = 0x60;
/// A reset register lies this far beneath the enable register with the same bits.
const RESET_BENEATH_ENABLE: u32 = 0x20;

const fn timer(
    number: u32,
    base: u32,
    clock: (u32, u32),
    interrupt: usize,
    adc_trigger: Option<u32>,
) -> TimerPlace {
    TimerPlace {
        number,
        base,
        clock,
        interrupt,
        adc_trigger,
    }
}

/// The timers that the model has.
pub const TIMERS: [TimerPlace; 9] = [
    timer(2, 0x4000_0000, (APB1ENR1, 0), 28, Some(11)),
    timer(3, 0x4000_0400, (APB1ENR1, 1), 29, Some(4)),
    timer(4, 0x4000_0800, (APB1ENR1, 2), 30, Some(12)),
    timer(5, 0x4000_0C00, (APB1ENR1, 3), 50, None),
    timer(6, 0x4000_1000, (APB1ENR1, 4), 54, Some(13)),
    timer(7, 0x4000_1400, (APB1ENR1, 5), 55, Some(30)),
    timer(15, 0x4001_4000, (APB2ENR, 16), 24, Some(14)),
    timer(16, 0x4001_4400, (APB2ENR, 17), 25, None),
    timer(17, 0x4001_4800, (APB2ENR, 18), 26, None),
];

/// Interrupts of ADC1 and ADC2 (shared), ADC3, ADC4, ADC5.
pub const ADC_INTERRUPTS: [usize; 5] = [18, 18, 47, 61, 62];
/// Interrupts of the eight channels of each DMA controller.
pub const DMA_INTERRUPTS: [[usize; 8]; 2] = [
    [11, 12, 13, 14, 15, 16, 17, 96],
    [56, 57, 58, 59, 60, 97, 98, 99],
];
/// Interrupt of the flash interface.
pub const FLASH_INTERRUPT: usize = 4;
/// Interrupt of LPUART1.
pub const LPUART1_INTERRUPT: usize = 91;
/// Interrupt of the random number generator.
pub const RNG_INTERRUPT: usize = 90;
/// Interrupts of lines 0 to 4, 5 to 9 and 10 to 15 of the extended interrupts.
pub const EXTI_INTERRUPTS: [(u32, usize); 7] = [
    (1 << 0, 6),
    (1 << 1, 7),
    (1 << 2, 8),
    (1 << 3, 9),
    (1 << 4, 10),
    (0x03E0, 23),
    (0xFC00, 40),
];

/// The peripheral at an address, and the offset in it.
pub fn locate(address: u32) -> Option<(Unit, u32)> {
    let page = address & !0x3FF;
    if let Some(index) = TIMERS.iter().position(|timer| timer.base == page) {
        return Some((Unit::Timer(index), address - page));
    }
    let (unit, base) = match page {
        0x4000_3000 => (Unit::Iwdg, page),
        0x4000_7000 => (Unit::Pwr, page),
        0x4000_8000 => (Unit::Lpuart1, page),
        0x4001_0000 => (Unit::Syscfg, page),
        0x4001_0400 => (Unit::Exti, page),
        0x4002_0000 => (Unit::Dma(0), page),
        0x4002_0400 => (Unit::Dma(1), page),
        0x4002_0800 => (Unit::Dmamux, page),
        0x4002_1000 => (Unit::Rcc, page),
        0x4002_2000 => (Unit::Flash, page),
        0x4002_3000 => (Unit::Crc, page),
        0x4800_0000..=0x4800_1800 => (Unit::Gpio(((page - 0x4800_0000) >> 10) as usize), page),
        0x5000_0000..=0x5000_0400 => return locate_converter(address),
        0x5006_0800 => (Unit::Rng, page),
        _ => return None,
    };
    Some((unit, address - base))
}

fn locate_converter(address: u32) -> Option<(Unit, u32)> {
    let base = address & !0xFF;
    let unit = match base {
        0x5000_0000 => Unit::Adc(0),
        0x5000_0100 => Unit::Adc(1),
        0x5000_0300 => Unit::AdcCommon(0),
        0x5000_0400 => Unit::Adc(2),
        0x5000_0500 => Unit::Adc(3),
        0x5000_0600 => Unit::Adc(4),
        0x5000_0700 => Unit::AdcCommon(1),
        _ => return None,
    };
    Some((unit, address - base))
}

impl Unit {
    /// Name as in the manual.
    pub fn name(self) -> String {
        match self {
            Self::Timer(index) => format!("TIM{}", TIMERS[index].number),
            Self::Dma(index) => format!("DMA{}", index + 1),
            Self::Gpio(index) => format!("GPIO{}", char::from(b'A' + index as u8)),
            Self::Adc(index) => format!("ADC{}", index + 1),
            Self::AdcCommon(0) => "ADC12_COMMON".to_owned(),
            Self::AdcCommon(_) => "ADC345_COMMON".to_owned(),
            other => format!("{other:?}").to_uppercase(),
        }
    }

    /// Offset of the enable register in the RCC, and bit; none if the unit is always clocked.
    pub fn clock(self) -> Option<(u32, u32)> {
        Some(match self {
            Self::Timer(index) => TIMERS[index].clock,
            Self::Pwr => (APB1ENR1, 28),
            Self::Lpuart1 => (APB1ENR2, 0),
            Self::Syscfg => (APB2ENR, 0),
            Self::Dma(index) => (AHB1ENR, index as u32),
            Self::Dmamux => (AHB1ENR, 2),
            Self::Flash => (AHB1ENR, 8),
            Self::Crc => (AHB1ENR, 12),
            Self::Gpio(index) => (AHB2ENR, index as u32),
            Self::Adc(0 | 1) | Self::AdcCommon(0) => (AHB2ENR, 13),
            Self::Adc(_) | Self::AdcCommon(_) => (AHB2ENR, 14),
            Self::Rng => (AHB2ENR, 26),
            Self::Iwdg | Self::Exti | Self::Rcc => return None,
        })
    }

    /// Every unit that the bits in a reset register of the RCC reset.
    pub fn reset_by(offset: u32, bits: u32) -> impl Iterator<Item = Self> {
        let enable = offset + RESET_BENEATH_ENABLE;
        let fixed = [
            Self::Pwr,
            Self::Lpuart1,
            Self::Syscfg,
            Self::Dmamux,
            Self::Flash,
            Self::Crc,
            Self::Rng,
        ];
        (0..TIMERS.len())
            .map(Self::Timer)
            .chain((0..2).flat_map(|i| [Self::Dma(i), Self::AdcCommon(i)]))
            .chain((0..7).map(Self::Gpio))
            .chain((0..5).map(Self::Adc))
            .chain(fixed)
            .filter(move |unit| {
                unit.clock()
                    .is_some_and(|(register, bit)| register == enable && bits & (1 << bit) != 0)
            })
    }
}
