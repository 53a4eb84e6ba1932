//! The data sheets of the sensors, the transducers and the board: nominal values and tolerance classes.
//!
//! The truth is drawn from these figures, and a laboratory has no others. A tolerance is the limit of a uniform
//! distribution unless the text says otherwise.

/// Standard gravity, m/s², which the laboratory assumes.
pub const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;
/// 1σ of local gravity about it, m/s²: gravity at the base has not been measured.
pub const GRAVITY_UNCERTAINTY_M_S2: f64 = 5e-4;
/// Supply of the board, V.
pub const SUPPLY_V: f64 = 3.3;
/// Output of every sensor and transducer at zero, V.
pub const ZERO_V: f64 = 1.65;
/// Output of a sensor at full scale, above [`ZERO_V`], V.
pub const FULL_SCALE_V: f64 = 1.5;
/// Output at which a sensor saturates, as a fraction of its full scale.
pub const SATURATION: f64 = 1.05;
/// Natural frequency of a sensor's second-order response, Hz.
pub const BANDWIDTH_HZ: [f64; 2] = [50.0, 120.0];
/// Its damping.
pub const DAMPING: [f64; 2] = [0.6, 1.0];
/// 1σ of each of the two tilt angles of a sensitive axis, degrees. The sheet says "up to 1°, normal": both angles are
/// normal with σ = 0.5° and drawn again until the whole tilt is at most 1°.
pub const MISALIGNMENT_DEG: f64 = 0.5;
/// Largest tilt of a sensitive axis, degrees.
pub const MISALIGNMENT_MAX_DEG: f64 = 1.0;
/// Largest offset of the sensor block from O on each axis, m.
pub const LEVER_ARM_MAX_M: f64 = 1.5;
/// Tolerance of the laboratory's measurement of that offset on each axis, m.
pub const LEVER_ARM_TOLERANCE_M: f64 = 0.05;

/// Span of a transducer's output over the stroke, V.
pub const JACK_SPAN_V: f64 = 3.1;
/// Relative error of a transducer's gain.
pub const JACK_GAIN_TOLERANCE: f64 = 0.0005;
/// Offset of a transducer, m.
pub const JACK_OFFSET_TOLERANCE_M: f64 = 0.0005;
/// Noise of a transducer sampled at 1 kHz, rms, m.
pub const JACK_NOISE_RMS_M: f64 = 0.0001;

/// Relative error of the gain of a converter.
pub const ADC_GAIN_TOLERANCE: f64 = 0.001;
/// Offset of a converter, LSB of 12 bits.
pub const ADC_OFFSET_TOLERANCE_LSB: f64 = 2.0;
/// Noise of one conversion, rms, LSB of 12 bits.
pub const ADC_NOISE_LSB: f64 = 1.5;
/// Error of the board's crystal, ppm.
pub const BOARD_CLOCK_TOLERANCE_PPM: f64 = 50.0;
/// Reference voltage of the chip (STM32G474 data sheet, VREFINT), V.
pub const VREFINT_V: [f64; 2] = [1.182, 1.232];

/// The data sheet of three sensors of one kind, along X, Y, Z.
#[derive(Debug, Clone, Copy)]
pub struct TriadSheet {
    /// Name of the kind: the section of the sensor file.
    pub name: &'static str,
    /// Names of the channels.
    pub channels: [&'static str; 3],
    /// Physical unit.
    pub unit: &'static str,
    /// Full scale to either side, unit.
    pub full_scale: f64,
    /// Relative error of the gain.
    pub gain_tolerance: f64,
    /// Output at zero input, unit.
    pub bias_tolerance: f64,
    /// White noise before the bandwidth, unit/√Hz (one-sided).
    pub noise_density: f64,
    /// Random walk of the bias: 1σ after 300 s, unit.
    pub bias_walk_5min: f64,
}

impl TriadSheet {
    /// Nominal sensitivity, V per unit.
    #[must_use]
    pub fn volts_per_unit(&self) -> f64 {
        FULL_SCALE_V / self.full_scale
    }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const MILLI_G: f64 = 1e-3 * STANDARD_GRAVITY_M_S2;

/// The three triads, in the order of the channels.
pub const TRIADS: [TriadSheet; 3] = [
    TriadSheet {
        name: "linear_acceleration",
        channels: ["ax", "ay", "az"],
        unit: "m/s²",
        full_scale: 2000.0 * MILLI_G,
        gain_tolerance: 0.03,
        bias_tolerance: 30.0 * MILLI_G,
        noise_density: 0.1 * MILLI_G,
        bias_walk_5min: 1.0 * MILLI_G,
    },
    TriadSheet {
        name: "angular_acceleration",
        channels: ["ex", "ey", "ez"],
        unit: "rad/s²",
        full_scale: 10.0,
        gain_tolerance: 0.05,
        bias_tolerance: 0.1,
        noise_density: 5e-3,
        bias_walk_5min: 0.01,
    },
    TriadSheet {
        name: "angular_rate",
        channels: ["wx", "wy", "wz"],
        unit: "rad/s",
        full_scale: 100.0 * DEGREE,
        gain_tolerance: 0.03,
        bias_tolerance: 1.0 * DEGREE,
        noise_density: 0.01 * DEGREE,
        bias_walk_5min: 0.02 * DEGREE,
    },
];
