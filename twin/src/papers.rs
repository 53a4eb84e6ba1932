//! The sensor file: a laboratory's knowledge of its sensors before calibration.
//!
//! It holds data-sheet values, tolerance classes, and the place of the sensor block as a tape measures it: the true
//! place with a uniform error of up to 50 mm on each axis. Nothing else in it depends on the seed.

use crate::board;
use crate::random::Stream;
use crate::sheet::{self, TRIADS, TriadSheet};
use crate::truth;

/// The sensor file under a seed, as TOML.
#[must_use]
pub fn sensor_file(seed: u64) -> String {
    let mut text = head(seed);
    for sheet in &TRIADS {
        text += &triad(sheet);
    }
    text + &transducers_and_converter()
}

/// The lever arm as the laboratory measured it, m.
fn measured_lever_arm_m(seed: u64) -> [f64; 3] {
    let truth = truth::lever_arm_m(seed).0;
    let axes = ["x", "y", "z"];
    std::array::from_fn(|i| {
        let error = Stream::new(seed, &format!("papers.lever_arm.{}", axes[i]))
            .within(sheet::LEVER_ARM_TOLERANCE_M);
        truth[i] + error
    })
}

fn head(seed: u64) -> String {
    format!(
        "name = \"sensor block {seed}\"\n\
         gravity_m_s2 = {:?}\n\
         gravity_uncertainty_m_s2 = {:?} # 1 sigma\n\
         # Known disturbances, Hz: mains, servos, structure. Blocks of the board's sums are chosen to keep clear of them.\n\
         lines_hz = [{:?}]\n\
         supply_v = {:?}\n\
         # From O to the sensor block, body axes: X forward, Y up, Z right.\n\
         lever_arm_m = {:?}\n\
         lever_arm_tolerance_m = {:?}\n",
        sheet::STANDARD_GRAVITY_M_S2,
        sheet::GRAVITY_UNCERTAINTY_M_S2,
        board::MAINS_HZ,
        sheet::SUPPLY_V,
        measured_lever_arm_m(seed),
        sheet::LEVER_ARM_TOLERANCE_M,
    )
}

fn triad(sheet: &TriadSheet) -> String {
    let TriadSheet {
        name,
        unit,
        full_scale,
        gain_tolerance,
        bias_tolerance,
        noise_density,
        bias_walk_5min,
        ..
    } = sheet;
    format!(
        "\n[{name}] # unit: {unit}\n\
         full_scale = {full_scale:?}\n\
         volts_per_unit = {:?} # full scale = {:?} V\n\
         zero_volts = {:?}\n\
         gain_tolerance = {gain_tolerance:?} # relative, uniform\n\
         bias_tolerance = {bias_tolerance:?} # unit, uniform\n\
         noise_density = {noise_density:?} # unit/sqrt(Hz), one-sided\n\
         bias_walk_5min = {bias_walk_5min:?} # unit, 1 sigma after 300 s\n\
         bandwidth_hz = {:?} # natural frequency of a second-order response, uniform\n\
         damping = {:?} # uniform\n\
         # Normal, 1 sigma of each of the two tilt angles of a sensitive axis; the whole tilt is at most {:?} deg.\n\
         misalignment_deg = {:?}\n",
        sheet.volts_per_unit(),
        sheet::FULL_SCALE_V,
        sheet::ZERO_V,
        sheet::BANDWIDTH_HZ,
        sheet::DAMPING,
        sheet::MISALIGNMENT_MAX_DEG,
        sheet::MISALIGNMENT_DEG,
    )
}

fn transducers_and_converter() -> String {
    format!(
        "\n[jacks]\n\
         full_stroke_volts = {:?} # length_max - length_min, centred on zero_volts\n\
         zero_volts = {:?} # at mid-stroke\n\
         gain_tolerance = {:?} # relative, uniform\n\
         offset_tolerance_m = {:?} # uniform\n\
         noise_rms_m = {:?} # at 1 kHz\n\
         \n[adc]\n\
         gain_tolerance = {:?} # relative, uniform\n\
         offset_tolerance_lsb = {:?} # of 12 bits, uniform\n\
         clock_tolerance_ppm = {:?}\n",
        sheet::JACK_SPAN_V,
        sheet::ZERO_V,
        sheet::JACK_GAIN_TOLERANCE,
        sheet::JACK_OFFSET_TOLERANCE_M,
        sheet::JACK_NOISE_RMS_M,
        sheet::ADC_GAIN_TOLERANCE,
        sheet::ADC_OFFSET_TOLERANCE_LSB,
        sheet::BOARD_CLOCK_TOLERANCE_PPM,
    )
}
