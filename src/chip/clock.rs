//! The clock tree: 24 MHz crystal (HSE) → PLL → 150 MHz for core, buses and timers, 37.5 MHz for the converters.
//!
//! The sampling period is only as good as its clock, and a drive frequency enters an acceleration as its square.
//! Without the crystal the board runs on the internal oscillator, about 1 % off. It says [`Source::Internal`] in its
//! status and refuses to calibrate.

use embassy_stm32::pac;
use embassy_stm32::rcc::{self, mux};
use embassy_stm32::time::Hertz;
use hexsense::{ADC_HZ, CORE_HZ, CRYSTAL_HZ};

use super::pins::DRIVER_PRIORITY;
use super::timing::CRYSTAL_START_MS;

/// The core's clock after reset, Hz.
const RESET_HZ: u32 = 16_000_000;

/// What the core's clock is derived from.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum Source {
    /// The 24 MHz crystal, within 50 ppm.
    Crystal,
    /// The internal oscillator, about 1 %: the crystal did not start.
    Internal,
}

/// Configuration for `embassy_stm32::init`, and the source that it uses. Starts the crystal to see whether it runs.
pub fn configuration() -> (embassy_stm32::Config, Source) {
    let source = start_crystal();
    let mut config = embassy_stm32::Config::default();
    let (pll_source, prediv, mul) = match source {
        // 24 MHz / 4 · 50 = 300 MHz, and 16 MHz / 4 · 75 = 300 MHz.
        Source::Crystal => (
            rcc::PllSource::HSE,
            rcc::PllPreDiv::DIV4,
            rcc::PllMul::MUL50,
        ),
        Source::Internal => (
            rcc::PllSource::HSI,
            rcc::PllPreDiv::DIV4,
            rcc::PllMul::MUL75,
        ),
    };
    config.rcc.hse = (source == Source::Crystal).then_some(rcc::Hse {
        freq: Hertz(CRYSTAL_HZ),
        mode: rcc::HseMode::Oscillator,
    });
    config.rcc.pll = Some(rcc::Pll {
        source: pll_source,
        prediv,
        mul,
        // 300 MHz / 8 = 37.5 MHz.
        divp: Some(rcc::PllPDiv::DIV8),
        divq: None,
        divr: Some(rcc::PllRDiv::DIV2),
    });
    config.rcc.sys = rcc::Sysclk::PLL1_R;
    // The generator of random numbers starts its own oscillator: the library would wait for it for ever.
    config.rcc.hsi48 = None;
    config.rcc.ls = rcc::LsConfig::off();
    // One source for all converters, which do not divide it: they disturb each other otherwise (ES0430).
    config.rcc.mux.adc12sel = mux::Adcsel::PLL1_P;
    config.rcc.mux.adc345sel = mux::Adcsel::PLL1_P;
    config.rcc.mux.lpuart1sel = mux::Uartsel::PCLK1;
    config.bdma_interrupt_priority = DRIVER_PRIORITY;
    (config, source)
}

/// Switches the crystal on and waits a bounded time for it; `embassy_stm32::init` would wait for ever.
fn start_crystal() -> Source {
    // Each turn reads a register over the bus, which takes more than four core cycles.
    const TURNS: u32 = RESET_HZ / 1_000 * CRYSTAL_START_MS / 4;
    pac::RCC.cr().modify(|cr| cr.set_hseon(true));
    for _ in 0..TURNS {
        if pac::RCC.cr().read().hserdy() {
            return Source::Crystal;
        }
    }
    Source::Internal
}

/// Checks that the tree gives what every constant in [`hexsense`] assumes.
///
/// # Panics
/// When it does not: a mistake of the build, not of the input.
pub fn check(clocks: &rcc::Clocks) {
    let core = clocks.sys.to_hertz();
    assert!(
        core == Some(Hertz(CORE_HZ)),
        "the core does not run at 150 MHz"
    );
    let converters = clocks.pll1_p.to_hertz();
    assert!(
        converters == Some(Hertz(ADC_HZ)),
        "the converters do not run at 37.5 MHz"
    );
}
