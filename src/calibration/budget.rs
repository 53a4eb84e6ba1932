//! Uncertainty of a result from all its terms, by the GUM (JCGM 100:2008).
//!
//! A *term* is one cause of error with the standard uncertainty it gives to the result, in the result's own unit:
//! the change of the result when the cause changes by its standard uncertainty. Independent terms add in squares
//! (GUM 5.1.2); the *expanded* uncertainty is the combined one times the *coverage factor* k = 2, about 95 %.

/// Coverage factor of expanded uncertainties.
pub const COVERAGE: f64 = 2.0;

/// Causes of error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// Noise of the sensors and their wandering during the runs.
    SensorNoise,
    /// Wandering of a bias between its determination and its use.
    BiasWalk,
    /// Places of the hinges.
    Hinges,
    /// Gains of the jack transducers.
    JackGain,
    /// Offsets of the jack transducers.
    JackOffset,
    /// Gain and offset of the converter that reads the jacks.
    JackConverter,
    /// Reference by which the supply is measured.
    SupplyReference,
    /// Clock of the board.
    Clock,
    /// Place of the sensor block.
    LeverArm,
    /// Bandwidth of the sensors at the drive frequency.
    Bandwidth,
}

impl Cause {
    /// All causes.
    pub const ALL: [Self; 10] = [
        Self::SensorNoise,
        Self::BiasWalk,
        Self::Hinges,
        Self::JackGain,
        Self::JackOffset,
        Self::JackConverter,
        Self::SupplyReference,
        Self::Clock,
        Self::LeverArm,
        Self::Bandwidth,
    ];

    /// Name as people read it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SensorNoise => "sensor noise",
            Self::BiasWalk => "bias wandering",
            Self::Hinges => "hinge places",
            Self::JackGain => "jack gains",
            Self::JackOffset => "jack offsets",
            Self::JackConverter => "jack converter",
            Self::SupplyReference => "supply reference",
            Self::Clock => "board clock",
            Self::LeverArm => "lever arm",
            Self::Bandwidth => "sensor bandwidth",
        }
    }
}

/// Terms of one result; several contributions of one cause add in squares.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Budget {
    variances: [f64; Cause::ALL.len()],
}

impl Budget {
    /// Adds an independent contribution with standard uncertainty `standard`, in the unit of the result.
    pub fn add(&mut self, cause: Cause, standard: f64) {
        self.variances[cause as usize] += standard * standard;
    }

    /// Standard uncertainty by one cause.
    #[must_use]
    pub fn term(&self, cause: Cause) -> f64 {
        libm::sqrt(self.variances[cause as usize])
    }

    /// Combined standard uncertainty.
    #[must_use]
    pub fn combined(&self) -> f64 {
        libm::sqrt(self.variances.iter().sum())
    }

    /// Expanded uncertainty, coverage factor [`COVERAGE`].
    #[must_use]
    pub fn expanded(&self) -> f64 {
        COVERAGE * self.combined()
    }
}

/// Standard uncertainty of a value known to lie within ± `half_width`, all values equally likely (GUM 4.3.7).
#[must_use]
pub fn uniform(half_width: f64) -> f64 {
    half_width / libm::sqrt(3.0)
}
