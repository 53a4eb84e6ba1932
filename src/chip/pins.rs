//! Which pin, converter, DMA channel and priority belongs to what. The room of a driver binds the driver's interrupt.
//!
//! | channel | pin | converter | rank |   | channel | pin | converter | rank |
//! |---|---|---|---|---|---|---|---|---|
//! | ax | PA0 | ADC1_IN1 | 1 | | jack1 | PA4 | ADC2_IN17 | 1 |
//! | ay | PA1 | ADC1_IN2 | 2 | | jack2 | PA6 | ADC2_IN3 | 2 |
//! | az | PB0 | ADC1_IN15 | 3 | | jack3 | PA7 | ADC2_IN4 | 3 |
//! | ex | PB1 | ADC1_IN12 | 4 | | jack4 | PB2 | ADC2_IN12 | 4 |
//! | ey | PB11 | ADC1_IN14 | 5 | | jack5 | PB15 | ADC2_IN15 | 5 |
//! | ez | PB12 | ADC1_IN11 | 6 | | jack6 | PC4 | ADC2_IN5 | 6 |
//! | wx | PB14 | ADC1_IN5 | 7 | | VREFINT | – | ADC5_IN18 | |
//! | wy | PC0 | ADC1_IN6 | 8 | | die temperature | – | ADC5_IN4 | |
//! | wz | PC1 | ADC1_IN7 | 9 | | link | PA2 (TX), PA3 (RX) | LPUART1 | |

use embassy_stm32::Peri;
use embassy_stm32::Peripherals;
use embassy_stm32::adc::{AdcChannel, AnyAdcChannel};
use embassy_stm32::interrupt::{self, Priority};
use embassy_stm32::peripherals::{
    ADC1, ADC2, ADC5, DMA1_CH1, DMA1_CH2, DMA1_CH3, DMA1_CH4, DMA1_CH5, FLASH, LPUART1, PA0, PA1,
    PA2, PA3, PA4, PA6, PA7, PB0, PB1, PB2, PB11, PB12, PB14, PB15, PC0, PC1, PC4, RNG, TIM6,
};
use hexsense_core::channel::{INERTIAL, JACKS};

/// The sample path: above everything else.
pub const SAMPLE_PRIORITY: Priority = Priority::P0;
/// Interrupts of drivers, which only move data and wake tasks.
pub const DRIVER_PRIORITY: Priority = Priority::P2;
/// The task above the sample path.
pub const SAMPLING_PRIORITY: Priority = Priority::P4;
/// The link. Pose, harmonics, storage, supply and watchdog run below every interrupt.
pub const LINK_PRIORITY: Priority = Priority::P8;
/// The sample interrupt: DMA of the converter that ends last.
pub const SAMPLE_VECTOR: interrupt::Interrupt = interrupt::Interrupt::DMA1_CHANNEL1;
/// The other drivers' interrupts but those of DMA.
pub const DRIVER_VECTORS: [interrupt::Interrupt; 3] = [
    interrupt::Interrupt::LPUART1,
    interrupt::Interrupt::FLASH,
    interrupt::Interrupt::TIM1_BRK_TIM15,
];
/// Number of the inertial channels' DMA channel, from 0.
pub const INERTIAL_DMA: usize = 0;
/// Number of the jacks' DMA channel, from 0.
pub const JACK_DMA: usize = 1;
/// Vector of an unused peripheral that runs the sampling task's executor.
pub const SAMPLING_VECTOR: interrupt::Interrupt = interrupt::Interrupt::I2C4_EV;
/// Vector of an unused peripheral that runs the link's executor.
pub const LINK_VECTOR: interrupt::Interrupt = interrupt::Interrupt::I2C4_ER;

/// What the sample path owns.
pub struct Acquisition {
    /// The trigger.
    pub timer: Peri<'static, TIM6>,
    /// Converter of the inertial channels.
    pub inertial_adc: Peri<'static, ADC1>,
    /// Its DMA channel.
    pub inertial_dma: Peri<'static, DMA1_CH1>,
    /// Its pins.
    pub inertial: InertialPins,
    /// Converter of the jack channels.
    pub jack_adc: Peri<'static, ADC2>,
    /// Its DMA channel.
    pub jack_dma: Peri<'static, DMA1_CH2>,
    /// Its pins.
    pub jacks: JackPins,
}

/// Pins of the nine inertial channels.
pub struct InertialPins(
    Peri<'static, PA0>,
    Peri<'static, PA1>,
    Peri<'static, PB0>,
    Peri<'static, PB1>,
    Peri<'static, PB11>,
    Peri<'static, PB12>,
    Peri<'static, PB14>,
    Peri<'static, PC0>,
    Peri<'static, PC1>,
);

/// Pins of the six jack channels.
pub struct JackPins(
    Peri<'static, PA4>,
    Peri<'static, PA6>,
    Peri<'static, PA7>,
    Peri<'static, PB2>,
    Peri<'static, PB15>,
    Peri<'static, PC4>,
);

impl InertialPins {
    /// The pins in the order of a scan.
    pub fn sequence(&mut self) -> [AnyAdcChannel<'_, ADC1>; INERTIAL] {
        [
            self.0.reborrow().degrade_adc(),
            self.1.reborrow().degrade_adc(),
            self.2.reborrow().degrade_adc(),
            self.3.reborrow().degrade_adc(),
            self.4.reborrow().degrade_adc(),
            self.5.reborrow().degrade_adc(),
            self.6.reborrow().degrade_adc(),
            self.7.reborrow().degrade_adc(),
            self.8.reborrow().degrade_adc(),
        ]
    }
}

impl JackPins {
    /// The pins in the order of a scan.
    pub fn sequence(&mut self) -> [AnyAdcChannel<'_, ADC2>; JACKS] {
        [
            self.0.reborrow().degrade_adc(),
            self.1.reborrow().degrade_adc(),
            self.2.reborrow().degrade_adc(),
            self.3.reborrow().degrade_adc(),
            self.4.reborrow().degrade_adc(),
            self.5.reborrow().degrade_adc(),
        ]
    }
}

/// What the supply and temperature measurement owns.
pub struct Supply {
    /// Converter of the internal channels.
    pub adc: Peri<'static, ADC5>,
    /// Its DMA channel.
    pub dma: Peri<'static, DMA1_CH3>,
}

/// What the link owns: the ST-LINK's virtual COM port.
pub struct Serial {
    /// The serial port.
    pub uart: Peri<'static, LPUART1>,
    /// Board to host.
    pub tx: Peri<'static, PA2>,
    /// Host to board.
    pub rx: Peri<'static, PA3>,
    /// DMA of the transmitter.
    pub tx_dma: Peri<'static, DMA1_CH5>,
    /// DMA of the receiver.
    pub rx_dma: Peri<'static, DMA1_CH4>,
}

/// The chip's parts, sorted by their owners.
pub struct Parts {
    /// For the sample path.
    pub acquisition: Acquisition,
    /// For supply and temperature.
    pub supply: Supply,
    /// For the link.
    pub serial: Serial,
    /// For the storage.
    pub flash: Peri<'static, FLASH>,
    /// For the storage's challenges.
    pub random: Peri<'static, RNG>,
}

/// Sorts the chip's peripherals by their owners.
pub fn assign(p: Peripherals) -> Parts {
    Parts {
        acquisition: Acquisition {
            timer: p.TIM6,
            inertial_adc: p.ADC1,
            inertial_dma: p.DMA1_CH1,
            inertial: InertialPins(
                p.PA0, p.PA1, p.PB0, p.PB1, p.PB11, p.PB12, p.PB14, p.PC0, p.PC1,
            ),
            jack_adc: p.ADC2,
            jack_dma: p.DMA1_CH2,
            jacks: JackPins(p.PA4, p.PA6, p.PA7, p.PB2, p.PB15, p.PC4),
        },
        supply: Supply {
            adc: p.ADC5,
            dma: p.DMA1_CH3,
        },
        serial: Serial {
            uart: p.LPUART1,
            tx: p.PA2,
            rx: p.PA3,
            tx_dma: p.DMA1_CH5,
            rx_dma: p.DMA1_CH4,
        },
        flash: p.FLASH,
        random: p.RNG,
    }
}
