//! Normal gravity against published values.

use hexsense_core::calibration::gravity::normal_gravity_m_s2;

#[test]
fn normal_gravity_is_that_of_the_world_geodetic_system() {
    // NIMA TR8350.2, table 3.4: gravity at the equator and at the poles.
    for (latitude_deg, published) in [(0.0, 9.780_325_335_9), (90.0, 9.832_184_937_8)] {
        for sign in [-1.0, 1.0] {
            let found = normal_gravity_m_s2(f64::to_radians(sign * latitude_deg), 0.0);
            assert!((found - published).abs() < 1e-9, "{latitude_deg}: {found}");
        }
    }
}

#[test]
fn it_falls_with_height_as_free_air_gravity_does() {
    // −(0.3087691 − 0.0004398 sin²φ)·h + 7.2125e-8·h² mGal (W. J. Hinze et al., Geophysics 70 (2005) J25, equation 5).
    for (latitude_deg, height_m) in [
        (0.0, 1_000.0),
        (45.0, 200.0),
        (55.75, 3_000.0),
        (90.0, 100.0),
    ] {
        let latitude_rad = f64::to_radians(latitude_deg);
        let fall =
            normal_gravity_m_s2(latitude_rad, height_m) - normal_gravity_m_s2(latitude_rad, 0.0);
        let gradient = 0.308_769_1 - 0.000_439_8 * latitude_rad.sin().powi(2);
        let published = 1e-5 * (-gradient * height_m + 7.212_5e-8 * height_m * height_m);
        assert!(
            (fall - published).abs() < 2e-7,
            "{latitude_deg}: {fall} for {published}"
        );
    }
}
