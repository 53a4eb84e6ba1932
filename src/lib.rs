//! The numbers of this board: what the firmware gives to the portable core, and the clock and converter settings behind
//! it. They name no driver, so that tests on the host read the same values as the firmware.
//!
//! The chain from crystal to sample is exact: 24 MHz · 25 / 4 = 150 MHz; TIM6 divides that by 4 and by a whole number for
//! each rate. So 1, 2 and 4 kHz are what they say, to the tolerance of the crystal. `docs/acquisition.md` has the reasons
//! for the settings of the converters.
#![no_std]
#![forbid(unsafe_code)]

use hexsense_core::channel::INERTIAL;
use hexsense_core::facts::{BoardFacts, FlashLayout};
use hexsense_core::wire::hello;

/// Frequency of the crystal, Hz.
pub const CRYSTAL_HZ: u32 = 24_000_000;
/// Core and bus clock, Hz. 150 MHz is the most that needs no core boost, and all rates divide it.
pub const CORE_HZ: u32 = 150_000_000;
/// Clock of the converters, Hz: the PLL's 300 MHz divided by 8, a quarter of the core's. The limit of a converter is 60 MHz
/// when it runs alone and 52 MHz when all run. A sixth of 300 MHz would leave the filters of the pins too little time.
pub const ADC_HZ: u32 = CORE_HZ / 4;

/// Conversions that the hardware adds up into one count.
pub const OVERSAMPLING: u32 = 16;
/// Sampling time of one conversion, half cycles of the converter's clock: 47.5 cycles (1.27 µs). It is the longest that
/// fits nine channels into the shortest period, so that the filters of the pins have the most time to charge the sampling
/// capacitor.
pub const SAMPLING_HALF_CYCLES: u32 = 95;
/// Half cycles of the successive approximation: 12.5 cycles.
pub const APPROXIMATION_HALF_CYCLES: u32 = 25;
/// Cycles of the converter's clock for one conversion.
pub const CONVERSION_CYCLES: u32 = (SAMPLING_HALF_CYCLES + APPROXIMATION_HALF_CYCLES) / 2;
/// Duration of a whole scan, ns: nine ranks of ADC1, while ADC2 does six beside them.
pub const SCAN_NS: u32 = FACTS.rank_ns * INERTIAL as u32;

/// Prescaler of TIM6: without it a period of 1 kHz does not fit into 16 bits. The converters' clock is a quarter of the
/// core's, so every trigger meets it in the same phase.
pub const TRIGGER_PRESCALER: u32 = 4;

/// Readings of the supply that make up its mean.
pub use hexsense_core::sampling::supply::READINGS as SUPPLY_READINGS;
/// Conversions that one reading of the supply adds up.
pub const SUPPLY_OVERSAMPLING: u32 = 256;
/// Conversions of ADC5 for a reading: one that is thrown away, VREFINT, and the temperature.
pub const SUPPLY_CONVERSIONS: u32 = 3;
/// Sampling time of such a conversion, half cycles: 640.5 cycles, the longest, which the internal sources need.
pub const SUPPLY_SAMPLING_HALF_CYCLES: u32 = 1_281;

/// What the core and the host must know of this board.
pub const FACTS: BoardFacts = BoardFacts {
    rates_hz: [1_000, 2_000, 4_000],
    rank_ns: (CONVERSION_CYCLES as u64 * OVERSAMPLING as u64 * 1_000_000_000 / ADC_HZ as u64)
        as u32,
    counts_at_supply: 4_096 * OVERSAMPLING,
    nominal_supply_v: 3.3,
    baud: 2_000_000,
    // Bank 2: it can be erased while the code in bank 1 runs.
    flash: FlashLayout {
        page_bytes: 2_048,
        pages: 128,
    },
};

/// Cycles of the prescaled timer clock in which a converter does one rank.
pub const RANK_TICKS: u32 =
    CONVERSION_CYCLES * OVERSAMPLING * (CORE_HZ / TRIGGER_PRESCALER / 1_000) / (ADC_HZ / 1_000);

/// Cycles of the prescaled timer clock in one period at `rate_hz`.
#[must_use]
pub const fn trigger_ticks(rate_hz: u32) -> u32 {
    CORE_HZ / TRIGGER_PRESCALER / rate_hz
}

/// A converter that was triggered while still busy ignores the trigger, and the rate would halve without a sign.
/// So a scan must fit the period, with 5 % to spare.
const _: () = {
    let rank_cycles = (CONVERSION_CYCLES * OVERSAMPLING) as u64;
    assert!(
        FACTS.rank_ns as u64 * ADC_HZ as u64 == rank_cycles * 1_000_000_000,
        "a rank is no whole number of nanoseconds"
    );
    assert!(
        FACTS.baud == hello::BAUD,
        "a host greets the board at another speed"
    );
    let mut i = 0;
    while i < FACTS.rates_hz.len() {
        let rate = FACTS.rates_hz[i];
        assert!(
            CORE_HZ.is_multiple_of(TRIGGER_PRESCALER * rate),
            "the rate is not exact"
        );
        assert!(
            trigger_ticks(rate) <= 1 << 16,
            "the period does not fit the timer"
        );
        assert!(
            SCAN_NS / 95 * 100 < 1_000_000_000 / rate,
            "the scan does not fit the period"
        );
        i += 1;
    }
};
