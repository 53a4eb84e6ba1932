//! The clock tree: 24 MHz crystal (HSE) → PLL → 150 MHz for core, buses and timers, 37.5 MHz for the converters.
//!
//! The sampling period is only as good as its clock, and a drive frequency enters an acceleration as its square.
//! Without the crystal the board runs on the internal oscillator, about 1 % off. It says [`Source::Internal`] in its
//! status and refuses to calibrate.
//!
//! The core comes to 150 MHz in two steps (RM0440, 7.2.7): above 80 MHz its bus must run at half the system clock for a
//! microsecond after the switch. embassy makes the first step and knows the halved clocks; [`go_full_speed`] makes the
//! second and keeps for every driver the clock that embassy has told it.
//!
//! A PLL that loses its crystal runs on, slowly, and nothing stands still. So the clock security system watches the
//! crystal. When it fails, the chip falls back to the internal oscillator at 16 MHz and raises the non-maskable
//! interrupt, which resets the board.

use embassy_stm32::pac;
use embassy_stm32::pac::flash::vals::Latency;
use embassy_stm32::rcc::{self, mux};
use embassy_stm32::time::Hertz;
use hexsense::{ADC_HZ, CORE_HZ, CRYSTAL_HZ};
use hexsense_core::wire::status::ResetCause;

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

/// Configuration for `embassy_stm32::init`, and the source that it uses. Starts the crystal to see whether it runs,
/// unless its failure is the cause of this start: a crystal that fails again and again must not reset the board for ever.
pub fn configuration(reset: ResetCause) -> (embassy_stm32::Config, Source) {
    let source = match reset {
        ResetCause::Crystal => Source::Internal,
        _ => start_crystal(),
    };
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
    config.rcc.ahb_pre = rcc::AHBPrescaler::DIV2;
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

/// Brings core and buses from half the system clock to all of it. LPUART1 and the timer of the time driver keep their
/// 75 MHz through the dividers of their buses; the other timers of bus 1, the trigger among them, get 150 MHz.
pub fn go_full_speed() {
    pac::FLASH.acr().modify(|acr| acr.set_latency(Latency::WS4));
    while pac::FLASH.acr().read().latency() != Latency::WS4 {}
    cortex_m::asm::delay(CORE_HZ / 2 / 1_000_000);
    pac::RCC.cfgr().modify(|cfgr| {
        cfgr.set_hpre(rcc::AHBPrescaler::DIV1);
        cfgr.set_ppre1(rcc::APBPrescaler::DIV2);
        cfgr.set_ppre2(rcc::APBPrescaler::DIV4);
    });
}

/// Has the chip watch the crystal. A crystal that has failed by now is not watched any more; false says so.
pub fn watch_crystal() -> bool {
    pac::RCC.cr().modify(|cr| cr.set_csson(true));
    pac::RCC.cr().read().hserdy()
}

/// Whether the crystal has failed while the chip watched it.
pub fn crystal_failed() -> bool {
    pac::RCC.cifr().read().cssf()
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
