//! The board's wiring and its true properties: converters, crystal, reference, supply, temperature, and the mains hum
//! in its cables.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::random::Stream;
use crate::sheet;

/// Columns of a row: nine sensors (ax ay az ex ey ez wx wy wz), six jacks, die temperature, supply.
pub const COLUMNS: [&str; 17] = [
    "PA0", "PA1", "PB0", "PB1", "PB11", "PB12", "PB14", "PC0", "PC1", "PA4", "PA6", "PA7", "PB2",
    "PB15", "PC4", "temp_c", "vdda_v",
];
/// Counts of the supply voltage: the sum of 16 conversions of 12 bits.
pub const COUNTS_AT_SUPPLY: f64 = 65_536.0;
/// Counts of one LSB of 12 bits.
const COUNTS_PER_LSB: f64 = 16.0;

/// Earliest date of a power-on, s since 1970.
const BOOT_UNIX_S: u64 = 1_780_000_000;
/// The dates of power-on are spread over this time, s: a year.
const BOOT_SPREAD_S: u64 = 31_536_000;

/// What the twin tells the board about itself.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoardTruth {
    /// The seed.
    pub seed: u64,
    /// Unique number of the chip, 24 hexadecimal digits.
    pub uid: String,
    /// Error of the crystal, ppm.
    pub clock_ppm: f64,
    /// Reference voltage, V.
    pub vrefint_v: f64,
    /// Date of power-on, s since 1970.
    pub boot_unix_s: u64,
    /// ADC1 to ADC5.
    pub adc: [AdcTruth; 5],
}

/// True properties of one converter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AdcTruth {
    /// Relative error of the gain.
    pub gain_error: f64,
    /// Offset, LSB of 12 bits.
    pub offset_lsb: f64,
    /// Noise of one conversion, rms, LSB of 12 bits.
    pub noise_lsb: f64,
}

impl BoardTruth {
    /// Draws the board.
    #[must_use]
    pub fn draw(seed: u64) -> Self {
        let stream = |quantity: &str| Stream::new(seed, &format!("board.{quantity}"));
        let mut uid = stream("uid");
        let (uid_high, uid_low) = (uid.bits(), uid.bits() as u32);
        let [vrefint_low, vrefint_high] = sheet::VREFINT_V;
        Self {
            seed,
            uid: format!("{uid_high:016x}{uid_low:08x}"),
            clock_ppm: stream("clock").within(sheet::BOARD_CLOCK_TOLERANCE_PPM),
            vrefint_v: stream("vrefint").uniform(vrefint_low, vrefint_high),
            boot_unix_s: BOOT_UNIX_S + stream("boot").bits() % BOOT_SPREAD_S,
            adc: std::array::from_fn(|index| AdcTruth::draw(seed, index)),
        }
    }
}

impl AdcTruth {
    fn draw(seed: u64, index: usize) -> Self {
        let stream = |quantity: &str| Stream::new(seed, &format!("adc{}.{quantity}", index + 1));
        Self {
            gain_error: stream("gain").within(sheet::ADC_GAIN_TOLERANCE),
            offset_lsb: stream("offset").within(sheet::ADC_OFFSET_TOLERANCE_LSB),
            noise_lsb: sheet::ADC_NOISE_LSB,
        }
    }

    /// Mean counts of 16 conversions of a voltage, at a supply of exactly 3.300 V.
    #[must_use]
    pub fn counts(&self, volts: f64) -> f64 {
        self.counts_per_volt() * volts + COUNTS_PER_LSB * self.offset_lsb
    }

    /// Counts per volt, at a supply of exactly 3.300 V.
    #[must_use]
    pub fn counts_per_volt(&self) -> f64 {
        COUNTS_AT_SUPPLY * (1.0 + self.gain_error) / sheet::SUPPLY_V
    }
}

/// The changing surroundings of the board: temperature, supply, hum.
#[derive(Debug, Clone)]
pub struct Surroundings {
    start_c: f64,
    warming_c: f64,
    supply_shift: f64,
    supply_swing: f64,
    supply_period_s: f64,
    supply_phase: f64,
    hum_phase: f64,
}

/// Time in which the board warms up, s.
const WARMING_TIME_S: f64 = 600.0;
/// Largest deviation of the supply, relative.
const SUPPLY_TOLERANCE: f64 = 0.001;
/// Hum, peak, of full scale.
const HUM: f64 = 0.0005;
/// Frequency of the mains, Hz.
pub const MAINS_HZ: f64 = 50.0;

impl Surroundings {
    /// Draws the surroundings.
    #[must_use]
    pub fn draw(seed: u64) -> Self {
        let stream = |quantity: &str| Stream::new(seed, &format!("surroundings.{quantity}"));
        Self {
            start_c: stream("temperature.start").uniform(25.0, 29.0),
            warming_c: stream("temperature.rise").uniform(1.0, 6.0),
            supply_shift: stream("supply.shift").within(0.5 * SUPPLY_TOLERANCE),
            supply_swing: stream("supply.swing").uniform(0.0, 0.5 * SUPPLY_TOLERANCE),
            supply_period_s: stream("supply.period").uniform(300.0, 900.0),
            supply_phase: stream("supply.phase").uniform(0.0, TAU),
            hum_phase: stream("hum.phase").uniform(0.0, TAU),
        }
    }

    /// Temperature of the die, °C.
    #[must_use]
    pub fn temperature_c(&self, time_s: f64) -> f64 {
        self.start_c + self.warming_c * (1.0 - libm::exp(-time_s / WARMING_TIME_S))
    }

    /// Supply, V.
    #[must_use]
    pub fn supply_v(&self, time_s: f64) -> f64 {
        let angle = TAU * time_s / self.supply_period_s + self.supply_phase;
        sheet::SUPPLY_V * (1.0 + self.supply_shift + self.supply_swing * libm::sin(angle))
    }

    /// Hum on every analog pin, V.
    #[must_use]
    pub fn hum_v(&self, time_s: f64) -> f64 {
        HUM * sheet::FULL_SCALE_V * libm::sin(TAU * MAINS_HZ * time_s + self.hum_phase)
    }
}
