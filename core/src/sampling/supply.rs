//! The mean of the supply readings, without those that no working board has.
//!
//! The supply factor multiplies every count, so a single wrong reading would move all values for as long as the mean
//! remembers it. A reading outside [`SUPPLY_FACTORS`] or [`DIE_C`], or none at all, is refused: the mean of the good ones
//! stays. When none has come for a second, the mean is *old*; then it says what the supply was, not what it is.

use crate::facts::SUPPLY_FACTORS;

/// Readings in a second, once the mean is settled.
pub const READINGS_HZ: u32 = 10;
/// Readings that make up the mean.
pub const READINGS: u8 = 16;
/// The lowest and the highest temperature that the die of a working chip can have, °C: its junction may have -40 to 130 °C
/// (DS12288, thermal characteristics), and the sensor is off by some kelvin.
pub const DIE_C: [f32; 2] = [-50.0, 140.0];
/// Refused readings in a row after which the mean is old: those of a second.
const OLD: u8 = READINGS_HZ as u8;

/// A smoothed reading of supply and temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SupplyReading {
    /// Supply factor c, see [`crate::sampling`].
    pub factor: f32,
    /// Temperature of the die, °C.
    pub temperature_c: f32,
    /// Readings that this is the mean of; 0 before the first, and then the factor is 1 and the temperature 0 °C.
    pub readings: u8,
    /// Whether no good reading has come for a second.
    pub is_old: bool,
}

impl SupplyReading {
    /// Before the first reading: what the board is built for.
    pub const NONE: Self = Self {
        factor: 1.0,
        temperature_c: 0.0,
        readings: 0,
        is_old: true,
    };
}

/// The mean of the good readings: of all, and from [`READINGS`] on a step of a sixteenth towards each.
#[derive(Debug)]
pub struct SupplyMean {
    mean: SupplyReading,
    /// Readings that were refused since the last good one.
    refused: u8,
}

impl SupplyMean {
    /// No reading yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            mean: SupplyReading::NONE,
            refused: 0,
        }
    }

    /// Takes a reading into the mean, or refuses it; `None` is a reading that did not come. Returns whether it was taken.
    pub fn take(&mut self, reading: Option<(f32, f32)>) -> bool {
        // Not true of a number that is none.
        let within = |[least, most]: [f32; 2], value: f32| least <= value && value <= most;
        let possible = |(factor, temperature_c): &(f32, f32)| {
            within(SUPPLY_FACTORS, *factor) && within(DIE_C, *temperature_c)
        };
        let mean = &mut self.mean;
        let Some((factor, temperature_c)) = reading.filter(possible) else {
            self.refused = self.refused.saturating_add(1);
            mean.is_old |= self.refused >= OLD;
            return false;
        };
        self.refused = 0;
        mean.is_old = false;
        mean.readings = (mean.readings + 1).min(READINGS);
        let weight = 1.0 / f32::from(mean.readings);
        mean.factor += weight * (factor - mean.factor);
        mean.temperature_c += weight * (temperature_c - mean.temperature_c);
        true
    }

    /// The mean of the good readings so far.
    #[must_use]
    pub const fn reading(&self) -> SupplyReading {
        self.mean
    }
}

impl Default for SupplyMean {
    fn default() -> Self {
        Self::new()
    }
}
