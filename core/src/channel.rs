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
