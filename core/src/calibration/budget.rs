//! Uncertainty of a result from all its terms, by the GUM (JCGM 100:2008).
//!
//! A *term* is one cause of error with the standard uncertainty it gives to the result, in the result's own unit:
//! the change of the result when the cause changes by its standard uncertainty. Independent terms add in squares
//! (GUM 5.1.2); the *expanded* uncertainty is the combined one times the *coverage factor* k = 2, about 95 %.
//!
//! How near to 95 % depends on the distribution of the largest terms: a tolerance, all values within it equally likely,
//! never errs by more than √3 of its standard uncertainty. So the fourth cumulant κ₄ of each term is added up too (−1.2·u⁴
//! for a uniform term, 0 for a normal one), and the excess kurtosis γ = Σκ₄/u_c⁴ gives the factor of the interval
//! that holds 95 %: 1.960 for a normal sum (γ = 0) down to 1.645 for a single uniform term (γ = −1.2). (Method:
//! R. Willink, Metrologia 42 (2005) 329; the polynomial here is fitted to sums of a uniform and a normal term.)

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
    /// Local gravity.
    Gravity,
    /// Noise of the jack transducers.
    JackNoise,
    /// What is left of transients on holds and in sines.
    Settling,
}

impl Cause {
    /// All causes.
    pub const ALL: [Self; 13] = [
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
        Self::Gravity,
        Self::JackNoise,
        Self::Settling,
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
            Self::Gravity => "local gravity",
            Self::JackNoise => "jack noise",
            Self::Settling => "settling",
        }
    }
}

/// Terms of one result; several contributions of one cause add in squares.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Budget {
    variances: [f64; Cause::ALL.len()],
    fourth_cumulant: f64,
}

/// How the values of a term are distributed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distribution {
    /// Normal.
    Normal,
    /// All values within a tolerance equally likely.
    Uniform,
}

impl Budget {
    /// Adds an independent contribution with standard uncertainty `standard`, in the unit of the result.
    pub fn add(&mut self, cause: Cause, shape: Distribution, standard: f64) {
        let variance = standard * standard;
        self.variances[cause as usize] += variance;
        if shape == Distribution::Uniform {
            self.fourth_cumulant -= 1.2 * variance * variance;
        }
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

    /// Half width of the interval that holds the true value with 95 % probability; the error of the factor is below
    /// 0.3 % for every mixture of a uniform and a normal term.
    #[must_use]
    pub fn interval_95(&self) -> f64 {
        let combined = self.combined();
        let square = combined * combined;
        let kurtosis = if square > 0.0 {
            self.fourth_cumulant / (square * square)
        } else {
            0.0
        };
        combined * (1.960 + kurtosis * (0.118 + kurtosis * (0.05 * kurtosis - 0.06)))
    }
}

/// Standard uncertainty of a value known to lie within ± `half_width`, all values equally likely (GUM 4.3.7).
#[must_use]
pub fn uniform(half_width: f64) -> f64 {
    half_width / libm::sqrt(3.0)
}
