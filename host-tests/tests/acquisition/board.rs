//! What the firmware does, and the noise that the twin's data sheets promise.

use hexsense::FACTS;
use hexsense_core::channel::INERTIAL;
use twin::sheet;

/// The settings of the firmware.
pub struct Board {
    pub core_hz: f64,
    pub adc_hz: f64,
    pub ratio: f64,
    pub sampling_cycles: f64,
    pub conversion_cycles: f64,
    pub trigger_prescaler: f64,
}

impl Board {
    pub fn new() -> Self {
        Self {
            core_hz: hexsense::CORE_HZ.into(),
            adc_hz: hexsense::ADC_HZ.into(),
            ratio: hexsense::OVERSAMPLING.into(),
            sampling_cycles: f64::from(hexsense::SAMPLING_HALF_CYCLES) / 2.0,
            conversion_cycles: hexsense::CONVERSION_CYCLES.into(),
            trigger_prescaler: hexsense::TRIGGER_PRESCALER.into(),
        }
    }

    /// Duration of nine ranks, µs.
    pub fn scan_us(&self, ratio: f64, sampling_cycles: f64) -> f64 {
        (sampling_cycles + 12.5) * ratio * INERTIAL as f64 / self.adc_hz * 1e6
    }

    /// Whether nine ranks leave 5 % of the shortest period.
    pub fn fits(&self, ratio: f64, sampling_cycles: f64) -> bool {
        self.scan_us(ratio, sampling_cycles) < 0.95 * 1e6 / f64::from(FACTS.rates_hz[2])
    }

    /// Frequency of single conversions, Hz.
    pub fn burst_hz(&self) -> f64 {
        self.adc_hz / self.conversion_cycles
    }
}

/// Noise of one conversion, LSB of 12 bits: the twin's, and rounding.
pub fn conversion_noise() -> f64 {
    (sheet::ADC_NOISE_LSB.powi(2) + 1.0 / 12.0).sqrt()
}

/// Rms of a sine that fills the converter, LSB of 12 bits.
pub fn full_sine() -> f64 {
    4_096.0 / 8_f64.sqrt()
}

pub fn bits(noise_lsb: f64) -> f64 {
    (20.0 * (full_sine() / noise_lsb).log10() - 1.76) / 6.02
}

/// Noise of one count, counts rms.
pub fn count_noise() -> f64 {
    conversion_noise() * Board::new().ratio.sqrt()
}

/// One-sided density of the converter's noise, counts/√Hz.
pub fn converter_density(rate_hz: f64) -> f64 {
    count_noise() * (2.0 / rate_hz).sqrt()
}

pub fn counts_per_volt() -> f64 {
    f64::from(FACTS.counts_at_supply) / f64::from(FACTS.nominal_supply_v)
}

/// Density of a sensor's noise, counts/√Hz.
pub fn sensor_density(triad: &sheet::TriadSheet) -> f64 {
    triad.noise_density * triad.volts_per_unit() * counts_per_volt()
}
