//! Head, conditions and runs of the small campaign.

use hexsense_core::records::MAX_ENCODED;
use hexsense_probe::report::render;
use hexsense_probe::sensor_file::SensorFile;
use sha2::{Digest, Sha256};

use crate::page::{captioned, elements, parsed, words};
use crate::small::{SMALL, SMALL_PAGE, evidence};

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Identity of the set: the first eight bytes of the SHA-256 of what the board stores.
fn identity() -> String {
    let mut buffer = [0; MAX_ENCODED];
    hex(&Sha256::digest(SMALL.set.encode(&mut buffer).unwrap())[..8])
}

/// What stands beside each name in the list of facts.
fn facts(html: &str) -> Vec<(String, String)> {
    let document = parsed(html);
    let [names, values] = ["dt", "dd"].map(|tag| elements(&document, tag).into_iter().map(words));
    names.zip(values).collect()
}

#[test]
fn every_fact_is_that_of_its_name() {
    let geometry_hash = hex(&Sha256::digest(&SMALL.campaign.geometry.text));
    // 27.3 °C are the set's. Supply factors go from 0.99 to 1.02 of 3 V, and temperatures from 24.5 °C to 31.5 °C in the
    // runs that were analysed; the held-out run is not among them.
    let expected = [
        ("Date", "2026-05-28 20:26:40 UTC"),
        (
            "Motion base",
            "base seven; jacks 2.100 m to 3.400 m hinge to hinge, home at 2.1298 m; hinges ±0.40 mm (1σ)",
        ),
        ("Note on the base", "Where it stands."),
        (
            "Sensors",
            "block 12; block at X 0.400 m, Y −0.250 m, Z 0.100 m from O, ±30 mm",
        ),
        (
            "Local gravity",
            "9.81540 ± 0.00020 m/s² (1σ), gravity_m_s2 of the sensor file",
        ),
        (
            "Board",
            "interface board, second, id 0a1b2c3d4e5f60718293a4b5, firmware 1.2.3, build b0b1b2b3b4b5b6b7, wire version 45",
        ),
        (
            "Temperature of the board",
            "27.3 °C on average, 24.5 °C to 31.5 °C",
        ),
        (
            "Supply of the board",
            "2.9700 V to 3.0600 V, corrected scan by scan",
        ),
        ("Coefficient set", &identity()),
        (
            "SHA-256 of captures, programs, geometry and sensor file",
            "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f",
        ),
        ("SHA-256 of the geometry file", &geometry_hash),
    ];
    let expected = expected.map(|(name, value)| (name.to_owned(), value.to_owned()));
    assert_eq!(facts(&SMALL_PAGE), expected);
}

#[test]
fn gravity_by_the_place_is_that_of_the_ellipsoid() {
    let mut small = evidence();
    // Normal gravity of WGS 84 at 45° on the ellipsoid is 9.80620 m/s² (NIMA TR 8350.2).
    let text = include_str!("small/sensors.toml").replace(
        "gravity_m_s2 = 9.8154\ngravity_uncertainty_m_s2 = 0.0002",
        "latitude_deg = 45.0\nheight_m = 0.0\ngravity_uncertainty_m_s2 = 0.0003",
    );
    small.campaign.sensors = SensorFile::parse("sensors.toml", &text).unwrap();
    let facts = facts(&render(&small.verified()).unwrap());
    let gravity = facts
        .iter()
        .find(|(name, _)| name == "Local gravity")
        .unwrap();
    assert_eq!(
        gravity.1,
        "9.80620 ± 0.00030 m/s² (1σ), normal gravity of WGS 84 at latitude 45° and height 0 m"
    );
}

#[test]
fn the_head_names_base_board_date_folder_and_set() {
    let document = parsed(&SMALL_PAGE);
    let head = words(elements(&document, "header")[0]);
    assert!(head.contains(
        "Base base seven · board 0a1b2c3d4e5f60718293a4b5 · 2026-05-28 20:26:40 UTC · folder spring\n"
    ), "{head}");
    assert!(
        head.contains(&format!("Coefficient set {}.", identity())),
        "{head}"
    );
    assert_eq!(
        words(elements(&document, "title")[0]),
        "Calibration report, base seven"
    );
}

#[test]
fn every_run_has_its_movement_length_scans_losses_and_hash() {
    let table = captioned(&parsed(&SMALL_PAGE), 2);
    assert_eq!(
        table.caption,
        "Table 2. The runs. A dash stands for a run that is not recorded."
    );
    assert_eq!(
        table.head,
        "Run | Purpose | Movement from home | Length [s] | Scans | Lost | \
         SHA-256 of the jack program [first 16 digits]"
    );
    // A recording has its rate times the time before the movement, its length and 1 s.
    let expected = [
        "zero | calibrate | rest at home | 9.0 | 10000 | 0 | 1010101010101010",
        "pitch | calibrate | pitch ramps and holds to ±15.0°, Δt = 2.5 s, linear | 12.5 | 15250 | 3 | 1313131313131313",
        "roll | calibrate | roll ramps and holds to ±9.0°, Δt = 2 s, jerk-limited | 12.0 | 15250 | 5 | 1515151515151515",
        "heave | calibrate | heave 0.050 m at 0.5 Hz | 13.0 | 15250 | 8 | 1818181818181818",
        "roll-sine | calibrate | roll 4.0° at 0.25 Hz | 14.0 | 33000 | 13 | 1d1d1d1d1d1d1d1d",
        "together | characterise | sway multisine, harmonics 3, 9 of 0.1 Hz; pitch multisine, harmonics 5, 11 of 0.1 Hz \
         | 40.0 | – | – | –",
        "lift | characterise | heave ramps and holds to ±0.080 m, Δt = 4 s, linear | 12.0 | – | – | –",
        "held-out | verify | surge 0.040 m at 0.3 Hz; yaw 2.5° at 0.2 Hz | 11.0 | 14000 | 21 | 2525252525252525",
    ];
    assert_eq!(table.rows, expected);
}
