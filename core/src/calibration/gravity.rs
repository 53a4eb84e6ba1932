//! Local gravity where nobody has measured it: normal gravity of the WGS 84 ellipsoid at a latitude φ and a height h.
//!
//! ```text
//! γ₀ = γₑ (1 + k sin²φ) / √(1 − e² sin²φ)                                  on the ellipsoid (Somigliana)
//! γ  = γ₀ (1 − (2/a)(1 + f + m − 2f sin²φ) h + 3 h²/a²)                    free air, to second order
//! ```
//!
//! (NIMA TR8350.2, Department of Defense World Geodetic System 1984, 3rd edition, equations 4-1 and 4-3.) The
//! ground below adds an anomaly, which the formula does not contain; [`ANOMALY_M_S2`] is its standard uncertainty.

/// Gravity at the equator, γₑ, m/s².
const EQUATOR_M_S2: f64 = 9.780_325_335_9;
/// Somigliana's constant k.
const SOMIGLIANA: f64 = 0.001_931_852_652_41;
/// Square of the first eccentricity, e².
const ECCENTRICITY_SQUARE: f64 = 0.006_694_379_990_14;
/// Equatorial radius a, m.
const RADIUS_M: f64 = 6_378_137.0;
/// Flattening f.
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// ω²a²b/GM.
const M: f64 = 0.003_449_786_506_84;

/// Standard uncertainty of normal gravity as the gravity of a place, m/s²: 50 mGal, the usual size of anomalies.
pub const ANOMALY_M_S2: f64 = 5e-4;

/// Normal gravity, m/s², at `latitude_rad` (−π/2 to π/2) and `height_m` above the ellipsoid, within ± 10 km.
#[must_use]
pub fn normal_gravity_m_s2(latitude_rad: f64, height_m: f64) -> f64 {
    let sine = libm::sin(latitude_rad);
    let square = sine * sine;
    let on_ellipsoid =
        EQUATOR_M_S2 * (1.0 + SOMIGLIANA * square) / libm::sqrt(1.0 - ECCENTRICITY_SQUARE * square);
    let radii = height_m / RADIUS_M;
    let gradient = 2.0 * (1.0 + FLATTENING + M - 2.0 * FLATTENING * square);
    on_ellipsoid * (1.0 - gradient * radii + 3.0 * radii * radii)
}
