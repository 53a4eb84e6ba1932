//! The clocks of the chip.

/// The first source of the system clock, which determines its error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The internal RC oscillator, good to about 1 %.
    Internal,
    /// The board's crystal.
    Crystal,
}

/// Nominal frequencies of the clock tree, Hz; zero is a clock that does not run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clocks {
    /// Where the system clock comes from.
    pub source: Source,
    /// The system clock, before the divider of the bus.
    pub system: u32,
    /// Core and buses.
    pub hclk: u32,
    /// Timers on bus APB1.
    pub apb1_timers: u32,
    /// Timers on bus APB2.
    pub apb2_timers: u32,
    /// Kernel clock of LPUART1.
    pub lpuart1: u32,
    /// Kernel clock of ADC1 and ADC2.
    pub adc12: u32,
    /// Kernel clock of ADC3, ADC4 and ADC5.
    pub adc345: u32,
}
