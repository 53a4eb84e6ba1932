//! The fifteen channels of one scan, and their order everywhere.
//!
//! A *scan* is one hardware-triggered conversion of all channels: the nine inertial sensors in three *triads*,
//! then the six jack displacement transducers. A *count* is what the board reports for one channel of one scan, a `u16`;
//! [`BoardFacts::counts_at_supply`](crate::facts::BoardFacts::counts_at_supply) says what the supply voltage would read.

use serde::{Deserialize, Serialize};

/// Number of inertial channels of a scan: three triads of three axes.
pub const INERTIAL: usize = 9;
/// Number of jacks, and of jack displacement channels of a scan.
pub const JACKS: usize = 6;
/// Number of channels of a scan.
pub const CHANNELS: usize = INERTIAL + JACKS;

/// Names of the channels, in the order of a scan.
pub const NAMES: [&str; CHANNELS] = [
    "ax", "ay", "az", "ex", "ey", "ez", "wx", "wy", "wz", "jack1", "jack2", "jack3", "jack4",
    "jack5", "jack6",
];

/// Raw counts of one scan, in the order of [`NAMES`].
pub type Scan = [u16; CHANNELS];

/// Three sensors of one kind along the body axes X (forward), Y (up), Z (right).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Triad {
    /// Specific force, m/s² (at rest and level: +g along Y).
    LinearAcceleration,
    /// Angular acceleration, rad/s².
    AngularAcceleration,
    /// Angular rate, rad/s.
    AngularRate,
}

impl Triad {
    /// The triads in the order of a scan.
    pub const ALL: [Self; 3] = [
        Self::LinearAcceleration,
        Self::AngularAcceleration,
        Self::AngularRate,
    ];

    /// Index of the triad in [`Triad::ALL`], 0 to 2.
    #[must_use]
    pub const fn index(self) -> usize {
        match self {
            Self::LinearAcceleration => 0,
            Self::AngularAcceleration => 1,
            Self::AngularRate => 2,
        }
    }

    /// Index in a scan of the triad's first channel; the other two follow.
    #[must_use]
    pub const fn first_channel(self) -> usize {
        3 * self.index()
    }

    /// Unit of a calibrated value, as people write it.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::LinearAcceleration => "m/s²",
            Self::AngularAcceleration => "rad/s²",
            Self::AngularRate => "rad/s",
        }
    }
}

/// Calls `one` for the first `N` channels. Unrolled: the compiler emits no loop although it builds for size. In the
/// sample path a turn of a loop would cost more than its work.
#[inline(always)]
pub fn unrolled<const N: usize>(mut one: impl FnMut(usize)) {
    const { assert!(N == JACKS || N == INERTIAL || N == CHANNELS) };
    one(0);
    one(1);
    one(2);
    one(3);
    one(4);
    one(5);
    if N >= INERTIAL {
        one(6);
        one(7);
        one(8);
    }
    if N >= CHANNELS {
        one(9);
        one(10);
        one(11);
        one(12);
        one(13);
        one(14);
    }
}

/// The channels whose signal is *ratiometric*: the sensor is fed by the supply of the converters, so that a drift of the
/// supply moves the signal and the reference alike. The supply factor does not act on their counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Ratiometric(u16);

impl Ratiometric {
    /// No channel.
    pub const NONE: Self = Self(0);

    /// From one bit for each channel, the first channel the lowest; `None` when a bit belongs to no channel.
    #[must_use]
    pub const fn from_bits(bits: u16) -> Option<Self> {
        if bits >> CHANNELS == 0 {
            Some(Self(bits))
        } else {
            None
        }
    }

    /// One bit for each channel, the first channel the lowest.
    #[must_use]
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// With another channel, 0 to 14; other numbers change nothing.
    #[must_use]
    pub const fn with(self, channel: usize) -> Self {
        if channel < CHANNELS {
            Self(self.0 | 1 << channel)
        } else {
            self
        }
    }

    /// Whether a channel is ratiometric.
    #[must_use]
    pub const fn has(self, channel: usize) -> bool {
        channel < CHANNELS && self.0 >> channel & 1 == 1
    }

    /// The factor that makes counts of a channel those at nominal supply: `supply`, or one.
    #[must_use]
    #[inline]
    pub fn factor(self, channel: usize, supply: f32) -> f32 {
        if self.has(channel) { 1.0 } else { supply }
    }
}
