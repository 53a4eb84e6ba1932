//! RM0440 chapter 7; start-up times of the data sheet (DS12288).

use virtual_board::peripherals::rcc::{Clocks, Rcc, ResetCause, Source};

const CR: u32 = 0x00;
const CIFR: u32 = 0x1C;
const CICR: u32 = 0x20;
const CFGR: u32 = 0x08;
const PLLCFGR: u32 = 0x0C;
const AHB2ENR: u32 = 0x4C;
const CCIPR: u32 = 0x88;
const CSR: u32 = 0x94;
const CRRCR: u32 = 0x98;

const HSEON: u32 = 1 << 16;
const HSERDY: u32 = 1 << 17;
const CSSON: u32 = 1 << 19;
const PLLON: u32 = 1 << 24;
const PLLRDY: u32 = 1 << 25;
/// HSE / 4 · 50 / 2 = 150 MHz on output R, / 2 on P.
const PLL_150: u32 = 3 | 3 << 4 | 50 << 8 | 1 << 24 | 1 << 16 | 2 << 27;

fn on_crystal() -> (Rcc, u64) {
    let mut rcc = Rcc::new(ResetCause::PowerOn);
    let hsi = rcc.read(CR, 0).unwrap();
    rcc.write(CR, hsi | HSEON, 0).unwrap();
    rcc.write(PLLCFGR, PLL_150, 0).unwrap();
    let started = 32_000; // 2 ms at 16 MHz
    rcc.write(CR, hsi | HSEON | PLLON, started).unwrap();
    (rcc, started + 240) // 15 µs
}

#[test]
fn comes_up_on_the_internal_oscillator() {
    let mut rcc = Rcc::new(ResetCause::PowerOn);
    assert_eq!(rcc.read(CR, 0), Ok(0x0000_0500));
    assert_eq!(rcc.read(CFGR, 0), Ok(0x0000_0005));
    let clocks = rcc.clocks();
    assert_eq!((clocks.hclk, clocks.source), (16_000_000, Source::Internal));
}

#[test]
fn oscillators_are_ready_after_a_while_and_gone_when_switched_off() {
    let mut rcc = Rcc::new(ResetCause::PowerOn);
    rcc.write(CR, 1 << 8 | HSEON, 1000).unwrap();
    assert_eq!(rcc.read(CR, 1000 + 31_999).unwrap() & HSERDY, 0);
    assert_eq!(rcc.read(CR, 1000 + 32_000).unwrap() & HSERDY, HSERDY);
    let with_ready_bits = rcc.read(CR, 40_000).unwrap();
    rcc.write(CR, with_ready_bits & !HSEON, 40_000).unwrap();
    assert_eq!(
        rcc.read(CR, 40_000).unwrap() & HSERDY,
        0,
        "the ready bit cannot be written"
    );
    rcc.write(CRRCR, 1, 40_000).unwrap();
    assert_eq!(rcc.read(CRRCR, 40_048), Ok(3));
    assert!(!rcc.hsi48_ready(40_047) && rcc.hsi48_ready(40_048));
}

#[test]
fn the_system_clock_switches_when_its_source_is_ready() {
    let (mut rcc, locked) = on_crystal();
    rcc.write(CFGR, 3, locked - 1).unwrap();
    assert_eq!(
        rcc.read(CFGR, locked - 1).unwrap() >> 2 & 3,
        1,
        "SWS still says HSI"
    );
    assert_eq!(rcc.clocks().hclk, 16_000_000);
    assert_eq!(rcc.read(CFGR, locked).unwrap() >> 2 & 3, 3);
    assert_eq!(rcc.clocks().hclk, 150_000_000);
    assert_eq!(rcc.clocks().source, Source::Crystal);
}

#[test]
fn prescalers_divide_and_timers_run_at_twice_a_divided_bus() {
    let (mut rcc, locked) = on_crystal();
    rcc.write(CCIPR, 2 << 28 | 1 << 30, locked).unwrap();
    rcc.write(CFGR, 3 | 4 << 8 | 5 << 11, locked).unwrap();
    assert_eq!(
        rcc.clocks(),
        Clocks {
            source: Source::Crystal,
            system: 150_000_000,
            hclk: 150_000_000,
            apb1_timers: 150_000_000,
            apb2_timers: 75_000_000,
            lpuart1: 75_000_000,
            adc12: 150_000_000,
            adc345: 150_000_000,
        }
    );
    rcc.write(CFGR, 3 | 8 << 4, locked).unwrap();
    assert_eq!(
        (rcc.clocks().hclk, rcc.clocks().lpuart1),
        (75_000_000, 75_000_000)
    );
    rcc.write(CCIPR, 1 << 10, locked).unwrap();
    assert_eq!(rcc.clocks().lpuart1, 150_000_000, "SYSCLK");
    assert_eq!(rcc.clocks().adc12, 0, "no clock selected");
}

#[test]
fn a_running_pll_keeps_its_factors_and_a_clock_in_use_stays_on() {
    let (mut rcc, locked) = on_crystal();
    assert!(rcc.write(PLLCFGR, PLL_150 ^ 1 << 8, locked).is_err());
    rcc.write(CFGR, 3, locked).unwrap();
    rcc.write(CR, 1 << 8 | HSEON, locked).unwrap();
    assert_eq!(
        rcc.read(CR, locked).unwrap() & (PLLON | PLLRDY),
        PLLON | PLLRDY
    );
}

#[test]
fn enable_bits_gate() {
    let mut rcc = Rcc::new(ResetCause::PowerOn);
    assert!(!rcc.enabled(AHB2ENR, 13));
    rcc.write(AHB2ENR, 1 << 13, 0).unwrap();
    assert!(rcc.enabled(AHB2ENR, 13));
}

#[test]
fn reset_causes_pile_up_until_they_are_removed() {
    let mut rcc = Rcc::new(ResetCause::PowerOn);
    assert_eq!(rcc.read(CSR, 0), Ok(1 << 27 | 1 << 26));
    rcc.reset(ResetCause::IndependentWatchdog);
    assert_eq!(rcc.read(CSR, 0), Ok(1 << 29 | 1 << 27 | 1 << 26));
    rcc.write(CSR, 1 << 23, 0).unwrap();
    assert_eq!(rcc.read(CSR, 0), Ok(0));
    rcc.reset(ResetCause::Software);
    assert_eq!(rcc.read(CSR, 0), Ok(1 << 28 | 1 << 26));
}

#[test]
fn causes_of_resets_add_up_until_they_are_removed_or_the_supply_dips() {
    const PIN: u32 = 1 << 26;
    const BROWN_OUT: u32 = 1 << 27;
    const WATCHDOG: u32 = 1 << 29;
    let mut rcc = Rcc::new(ResetCause::PowerOn);
    let flags = |rcc: &mut Rcc| rcc.read(CSR, 0).unwrap() & 0xFE00_0000;
    assert_eq!(flags(&mut rcc), BROWN_OUT | PIN);
    rcc.write(CSR, 1 << 23, 0).unwrap();
    rcc.reset(ResetCause::Pin);
    assert_eq!(flags(&mut rcc), PIN);
    rcc.reset(ResetCause::IndependentWatchdog);
    assert_eq!(flags(&mut rcc), WATCHDOG | PIN);
    rcc.reset(ResetCause::BrownOut);
    assert_eq!(flags(&mut rcc), BROWN_OUT | PIN);
}

#[test]
fn a_dead_crystal_never_gets_ready_not_even_after_a_reset() {
    let mut rcc = Rcc::new(ResetCause::PowerOn);
    rcc.write(CR, 1 << 8 | HSEON, 0).unwrap();
    assert!(!rcc.stop_crystal(4, false, 0), "nothing watches it");
    assert_eq!(rcc.read(CR, 1 << 40).unwrap() & HSERDY, 0);
    rcc.reset(ResetCause::Pin);
    rcc.write(CR, 1 << 8 | HSEON, 0).unwrap();
    assert_eq!(rcc.read(CR, 1 << 40).unwrap() & HSERDY, 0);
}

#[test]
fn a_pll_without_its_crystal_drifts_to_a_fraction_and_clocks_the_chip_on() {
    let (mut rcc, locked) = on_crystal();
    rcc.write(CFGR, 3, locked).unwrap();
    assert!(!rcc.stop_crystal(12, false, locked));
    assert_eq!(rcc.clocks().hclk, 12_500_000);
    assert_eq!(rcc.read(CFGR, locked).unwrap() >> 2 & 3, 3, "SWS says PLL");
    assert_eq!(rcc.read(CIFR, locked), Ok(0));
}

#[test]
fn clock_security_takes_the_internal_oscillator_and_flags_it_until_it_is_cleared() {
    let (mut rcc, locked) = on_crystal();
    rcc.write(CFGR, 3, locked).unwrap();
    let control = rcc.read(CR, locked).unwrap();
    rcc.write(CR, control | CSSON, locked).unwrap();
    rcc.write(CR, control & !CSSON, locked).unwrap();
    assert_eq!(
        rcc.read(CR, locked).unwrap() & CSSON,
        CSSON,
        "only a reset switches it off"
    );
    assert!(rcc.stop_crystal(12, false, locked));
    let clocks = rcc.clocks();
    assert_eq!((clocks.hclk, clocks.source), (16_000_000, Source::Internal));
    assert_eq!(rcc.read(CFGR, locked).unwrap() & 0xF, 1 | 1 << 2);
    assert_eq!(
        rcc.read(CR, locked).unwrap() & (HSEON | HSERDY | PLLON | PLLRDY),
        0
    );
    assert_eq!(rcc.read(CIFR, locked), Ok(1 << 8), "CSSF");
    rcc.write(CICR, 1 << 8, locked).unwrap();
    assert_eq!(rcc.read(CIFR, locked), Ok(0));
}

#[test]
fn a_crystal_that_is_not_ready_is_not_watched() {
    let mut rcc = Rcc::new(ResetCause::PowerOn);
    rcc.write(CR, 1 << 8 | HSEON | CSSON, 0).unwrap();
    assert!(!rcc.stop_crystal(4, false, 31_999));
    assert_eq!(rcc.read(CIFR, 40_000), Ok(0));
}

#[test]
fn a_crystal_that_returns_starts_after_the_next_reset() {
    let (mut rcc, locked) = on_crystal();
    assert!(!rcc.stop_crystal(4, true, locked));
    assert_eq!(rcc.read(CR, 1 << 40).unwrap() & HSERDY, 0);
    rcc.reset(ResetCause::Software);
    rcc.write(CR, 1 << 8 | HSEON, 0).unwrap();
    assert_eq!(rcc.read(CR, 32_000).unwrap() & HSERDY, HSERDY);
}
