//! The signal that every estimator gets: a sine of 2000 counts at 0.5 Hz that rides on gravity, at 1 kHz.

/// Drive frequency, Hz.
pub const FREQUENCY_HZ: f64 = 0.5;
/// Scan rate, Hz.
pub const RATE_HZ: u32 = 1_000;
/// Scans of three periods.
pub const SCANS: usize = 6_000;
/// Counts for 1 m/s².
const COUNTS: f64 = 2_000.0;
const STANDARD_GRAVITY: f64 = 9.806_65;

/// Count of scan `n`.
pub fn count(n: usize) -> u16 {
    let turns = FREQUENCY_HZ / f64::from(RATE_HZ) * n as f64;
    let value = STANDARD_GRAVITY + libm::cos(core::f64::consts::TAU * turns - 0.7);
    libm::round(32_768.0 + COUNTS * value) as u16
}
